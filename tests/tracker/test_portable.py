"""The network as ONNX: the same numbers without torch, the same bytes again, weights read back."""

import numpy as np
import onnxruntime
import pytest
import torch
from numpy.testing import assert_allclose, assert_array_equal
from refusals import refusal
from scipy.special import expit

from snowsim.front import REFERENCE
from snowsim.io import read_tracker
from snowsim.patches import to_signed
from snowsim.tracker import (
    MultiScaleNetwork,
    PyramidNetwork,
    log_odds_by_lines,
    network_of_onnx,
    runner,
    stretches,
    to_onnx,
)

SHIPPED = REFERENCE.parent / "universal.onnx"


@pytest.fixture(scope="module", params=[(MultiScaleNetwork, 1), (PyramidNetwork, 2)])
def network(request):
    kind, n_averaged = request.param
    network = kind(8, n_averaged=n_averaged)
    network.initialise(rng=np.random.default_rng(1))
    with torch.no_grad():
        # Larger than drawn: probabilities then differ from a half.
        for side in network.sides:
            side.weight *= 20
    return network.eval()


def run(content, image):
    """Logits that ONNX Runtime makes of images of uint8, (n, range_bin, range_line)."""
    signed = image.astype(np.float32) * np.float32(2 / 255) - np.float32(1)
    return runner(content)(signed[:, None])


@pytest.mark.parametrize("shape", [(1, 64, 48), (1, 37, 53), (2, 401, 255), (3, 16, 1), (1, 1, 1)])
def test_probability_is_that_of_torch_at_any_size(network, rng, shape):
    image = rng.integers(0, 256, shape, dtype=np.uint8)
    with torch.no_grad():
        expected = torch.sigmoid(network(to_signed(image))[-1]).numpy()
    found = expit(run(to_onnx(network), image))
    assert found.shape == expected.shape
    # Sums of some hundred products of float32, in another order.
    assert_allclose(found, expected, atol=1e-5)


@pytest.mark.parametrize("size", [(300, 700), (1291, 517)])
def test_an_echogram_in_windows_gives_what_the_whole_gives(network, rng, size, monkeypatch):
    image = rng.integers(0, 256, size, dtype=np.uint8)
    run = runner(to_onnx(network))

    def logits(window):
        for name in ("WINDOW_ROWS", "WINDOW_LINES"):
            monkeypatch.setitem(log_odds_by_lines.__globals__, name, window)
        parts = log_odds_by_lines(run, lambda first, stop: image[:, first:stop], *size)
        return np.concatenate([part for _, part, _ in parts], axis=1)

    whole = logits(4096)
    assert np.ptp(whole) > 1e-3
    # Sums of 32-bit products in another order.
    assert_allclose(logits(256), whole, atol=2e-6 * np.abs(whole).max() + 1e-6)


@pytest.mark.parametrize("n_rows", [1, 150, 700])
def test_log_odds_of_upper_rows_are_those_of_the_whole_and_rows_far_below_are_not_seen(
    network, rng, n_rows
):
    image = rng.integers(0, 256, (1000, 64), dtype=np.uint8)
    network_run = runner(to_onnx(network))
    seen = []

    def counted(images):
        seen.append(images.shape[2])
        return network_run(images)

    ((_, _, log_odds_of),) = stretches(counted, lambda first, stop: image[:, first:stop], 64)
    whole = log_odds_of(1000)
    assert seen == [1000]
    upper = log_odds_of(n_rows)
    # Up to the next of 16 rows, and the margin of 128.
    assert n_rows + 128 <= seen[1] < n_rows + 144
    # Sums of 32-bit products in another order.
    assert_allclose(upper, whole[:n_rows], atol=2e-6 * np.abs(whole).max() + 1e-6)


def test_an_offset_is_taken_off_every_logit_and_what_is_told_stands_in_the_file(network, rng):
    image = rng.integers(0, 256, (1, 40, 40), dtype=np.uint8)
    about = {"name": "mine", "version": "3"}
    content = to_onnx(network, 1.5, about)
    # Rounding of float32 at logits of a few units.
    assert_allclose(run(to_onnx(network), image) - run(content, image), 1.5, atol=1e-5)
    session = onnxruntime.InferenceSession(content, providers=["CPUExecutionProvider"])
    assert session.get_modelmeta().custom_metadata_map == about


def test_weights_are_read_back_equal_ones_too(network):
    # As drawn all biases are zero, and the file keeps equal weights once.
    read = network_of_onnx(to_onnx(network))
    expected = network.state_dict()
    found = read.state_dict()
    assert found.keys() == expected.keys()
    for name, values in expected.items():
        assert_array_equal(found[name], values, err_msg=name)
    assert (read.kind, read.width, read.n_averaged) == (network.kind, 8, network.n_averaged)


@pytest.mark.parametrize("content", [b"", b"no network", b"\x00" * 100])
def test_what_is_no_network_is_refused_in_a_line(content):
    with refusal("expected (a network as ONNX|fuse.bias)"):
        network_of_onnx(content)


def test_the_shipped_tracker_fits_its_card_and_is_a_network_of_this_package():
    content, card = read_tracker(SHIPPED)
    assert card["name"] == "universal"
    assert "never scored on an annotated real frame" in card["trained_on"]
    assert len(content) < 4e6
    network_of_onnx(content)
