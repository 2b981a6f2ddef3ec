import numpy as np
import pytest
import torch
from numpy.testing import assert_array_equal
from torch import nn

from snowsim.cgan.measured import Generator
from snowsim.cgan.networks import PatchDiscriminator, ResizeConvolution, initialise


@pytest.mark.parametrize("shape", [(24, 20), (2, 3)])  # few weights for a pixel, and many
def test_doubling_within_a_convolution_is_doubling_before_it(shape):
    torch.manual_seed(1)
    network = ResizeConvolution(6, 4).double()
    x = torch.randn(2, 6, *shape, dtype=torch.float64)
    doubled = x.repeat_interleave(2, 2).repeat_interleave(2, 3)
    expected = nn.functional.conv2d(doubled, network.weight, network.bias, padding=1)
    torch.testing.assert_close(network(x), expected, rtol=1e-12, atol=1e-12)


def test_logits_are_as_many_as_pix2pix_has_of_patches_of_70_pixels():
    image = torch.zeros(1, 1, 256, 256)
    assert PatchDiscriminator(2)(image, image).shape == (1, 1, 30, 30)


def test_noise_has_one_level_for_each_slab_and_changes_the_image(rng):
    generator = Generator(4, depth=4, n_inputs=1)
    initialise(generator, rng=rng)
    slabs = np.repeat(np.arange(4), 16)[None, :, None] * np.ones((2, 1, 64), int)
    noise, other = (generator.draw_noise(slabs, rng=rng) for _ in range(2))
    levels = noise["slab"].numpy().reshape(8, -1)
    assert_array_equal(np.ptp(levels, axis=1), 0)
    assert len(np.unique(levels)) == 8
    masks = torch.full((2, 1, 64, 64), -1.0)
    with torch.no_grad():
        assert not torch.equal(generator(masks, noise), generator(masks, other))
