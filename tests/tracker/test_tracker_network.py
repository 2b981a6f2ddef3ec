import numpy as np
import pytest
import torch
from numpy.testing import assert_allclose

from snowsim.constants import OUTPUTS
from snowsim.tracker import MultiScaleNetwork, PyramidNetwork


@pytest.mark.parametrize(("width", "n_parameters"), [(64, 14_715_019), (16, 920_875), (8, 230_619)])
def test_parameter_counts_are_the_published_ones(width, n_parameters):
    assert (
        sum(parameter.numel() for parameter in MultiScaleNetwork(width).parameters())
        == n_parameters
    )


def drawn(network, rng):
    network.initialise(rng=rng)
    return network.eval()


@pytest.fixture
def noise(rng):
    """Image of so many rows and columns."""
    return lambda *size: torch.from_numpy(rng.standard_normal((1, 1, *size)).astype(np.float32))


@pytest.fixture(autouse=True)
def _without_gradients():
    with torch.no_grad():
        yield


@pytest.mark.parametrize("size", [(64, 64), (33, 47), (1, 1)])
def test_averaged_range_lines_count_by_their_mean_alone(rng, noise, size):
    network = drawn(MultiScaleNetwork(2, n_averaged=2), rng)
    image = noise(*size)
    means = image.clone()
    for line in range(0, size[1], 2):
        # The last mean may be of one line.
        pair = slice(line, line + 2)
        means[..., pair] = image[..., pair].mean(dim=3, keepdim=True)
    logits = network(image)
    assert logits.shape == (len(OUTPUTS), 1, 1, *size)
    assert_allclose(logits, network(means), atol=1e-6)


@pytest.mark.parametrize(("kind", "n_seen"), [(MultiScaleNetwork, 1), (PyramidNetwork, 5)])
def test_sides_upsample_about_pixel_centres_what_their_stage_or_coarser_ones_hold(kind, n_seen):
    """A map that is a ramp in its own pixels comes out as that ramp in pixels of the image."""
    network = kind(1)
    for parameter in network.parameters():
        parameter.zero_()
        if parameter.ndim == 4:
            parameter[0, 0, parameter.shape[2] // 2, parameter.shape[3] // 2] = 1
    logits = network(torch.arange(64.0).repeat(64, 1)[None, None])
    # Pooling takes the largest of 2^k columns: stage k + 1 holds x + (2^k - 1) / 2, but for half a
    # coarse pixel, and half of each finer one, at either end.
    ramps = np.arange(16, 48) + (2.0 ** np.arange(5)[:, None] - 1) / 2
    for k, side in enumerate(logits[:5, 0, 0]):
        expected = ramps[k : k + n_seen].sum(axis=0)
        assert_allclose(side[:, 16:48], np.tile(expected, (64, 1)), rtol=1e-6)


def test_the_fuse_starts_as_the_mean_of_sides_and_activations_neither_vanish_nor_explode(
    noise, rng
):
    logits = drawn(MultiScaleNetwork(2), rng)(noise(32, 32))
    assert_allclose(logits[5], logits[:5].mean(dim=0), atol=1e-6)
    network, x = drawn(MultiScaleNetwork(8), rng), noise(64, 64)
    for stage in network.stages:
        for convolution in stage:
            x = torch.relu(convolution(x))
    # He et al. (2015) keep the mean square through 13 layers; at 8 to 64 channels it wanders, but
    # not by powers.
    assert 0.05 < x.square().mean() < 20
