import numpy as np
import pytest
import torch
from numpy.testing import assert_allclose

from snowsim.constants import OUTPUTS
from snowsim.tracker import MultiScaleNetwork


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


def test_side_outputs_upsample_about_pixel_centres():
    """A side map that is a ramp in its own pixels comes out as that ramp in pixels of the image."""
    network = MultiScaleNetwork(1)
    for parameter in network.parameters():
        parameter.zero_()
    for stage, side in zip(network.stages, network.sides, strict=True):
        for convolution in stage:
            convolution.weight[0, 0, 1, 1] = 1
        side.weight[0, 0] = 1
    logits = network(torch.arange(64.0).repeat(64, 1)[None, None])
    # Pooling takes the largest of 2^k columns: side k + 1 holds x + (2^k - 1) / 2 between the first
    # and last centres.
    for k, side in enumerate(logits[:5, 0, 0]):
        inside = slice(2 ** (k - 1) if k else 0, 64 - 2 ** (k - 1) if k else 64)
        ramp = np.arange(64)[inside] + (2**k - 1) / 2
        assert_allclose(side[:, inside], np.tile(ramp, (64, 1)), rtol=1e-6)


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
