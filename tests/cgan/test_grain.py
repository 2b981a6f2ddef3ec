"""Grain: what its weights say of it is so, and it learns the texture of what images lack."""

import numpy as np
import pytest
import torch
from numpy.testing import assert_allclose
from scipy.ndimage import convolve1d

from snowsim.cgan.grain import (
    GRAIN_DISTANCES,
    GRAIN_LAGS,
    Grain,
    change_covariance,
    correlated,
    third_moment,
)
from snowsim.cgan.networks import initialise

SIZE = (200, 200)


def held(n_air=0):
    """Pixels in snow, (patch, 1, range_bin, range_line), under some rows of air."""
    is_snow = np.ones((1, 1, *SIZE), bool)
    is_snow[:, :, :n_air] = False
    return torch.from_numpy(is_snow)


@pytest.fixture
def grain(rng):
    made = Grain()
    initialise(made, rng=rng)
    made.gain.data.fill_(0.02)
    made.skew.data.fill_(-0.3)
    return made


def drawn(grain, is_snow, *, rng):
    with torch.no_grad():
        return grain(grain.draw(is_snow[:, 0].numpy(), rng=rng))


def test_covariance_in_snow_and_air_and_third_moment_are_what_the_weights_say(grain, rng):
    is_snow = held(n_air=50)
    images = torch.cat([drawn(grain, is_snow, rng=rng) for _ in range(60)])
    is_snow = is_snow.expand(images.shape)
    expected = grain.covariance(GRAIN_LAGS, GRAIN_DISTANCES).detach()
    found = change_covariance(images, is_snow, GRAIN_LAGS, GRAIN_DISTANCES)
    # 60 images of 150 x 200 pixels, of which one in 500 is independent: 2 percent; allow three.
    assert_allclose(found, expected, atol=0.06 * float(expected.max()))
    # Skewness of 1,800,000 numbers, one in ten independent, is known to sqrt(6 / 180000).
    spread = float(images[is_snow].std() ** 3)
    skewness = float(third_moment(images, is_snow)) / spread
    assert_allclose(skewness, float(grain.third_moment().detach()) / spread, atol=0.024)
    assert abs(skewness) > 0.024
    # Air has no texture: 540,000 pixels, one in five independent, 0.5 percent; allow four. Filters
    # reach two rows up from snow and down from the edge.
    in_air = torch.zeros_like(is_snow)
    in_air[:, :, 2:48] = True
    grain.size.data.zero_()
    expected = grain.covariance(GRAIN_LAGS[:5], GRAIN_DISTANCES).detach()
    found = change_covariance(images, in_air, GRAIN_LAGS[:5], GRAIN_DISTANCES)
    assert_allclose(found, expected, atol=0.02 * float(expected.max()))


def test_covariance_of_changes_does_not_see_level_layers(rng):
    weights = [0.2, 0.6, 0.3]
    layer = 5 * np.sin(np.arange(SIZE[0]) / 3)[:, None]
    noise = convolve1d(rng.standard_normal(SIZE), weights, axis=0)
    expected = np.correlate(weights, weights, mode="full")[2:]
    image = torch.from_numpy(noise + layer)[None, None]
    found = change_covariance(image, held(), (0, 1, 2), (1, 7))
    # Half the square difference of 200 lines of 200 bins, about 1.5 of them independent: known to
    # 0.006; allow four.
    assert_allclose(found, [expected, expected], atol=0.024)


def test_it_learns_textures_that_are_not_its_own(rng):
    """Of speckle skewed as 12 looks are in dB, a texture, gain: to a tenth of the variance."""
    is_snow = held(n_air=50)
    snow = is_snow[0, 0].numpy()

    def observed():
        power = rng.gamma(12, size=SIZE) / 12
        speckle = convolve1d(10 * np.log10(power), [0.3, 0.9, 0.3], axis=0)
        texture = correlated(correlated(rng.standard_normal(SIZE), 4.0, axis=1), 4.0, axis=0)
        image = speckle + 0.6 * snow * texture + 0.3 * rng.standard_normal(SIZE[1])
        return torch.from_numpy(image / 20)[None, None].float()

    grain = Grain()
    initialise(grain, rng=rng)
    adam = torch.optim.Adam(grain.parameters(), lr=4e-3)
    many = torch.cat([observed() for _ in range(30)])
    for step in range(150):
        adam.zero_grad()
        grain.mismatch(many[step % len(many)][None], is_snow).backward()
        adam.step()
    is_snow = is_snow.expand(many.shape)
    found = change_covariance(many, is_snow, GRAIN_LAGS, GRAIN_DISTANCES)
    learnt = grain.covariance(GRAIN_LAGS, GRAIN_DISTANCES).detach()
    assert_allclose(learnt, found, atol=0.1 * float(found[0, 0]))
    third = float(third_moment(many, is_snow))
    assert_allclose(float(grain.third_moment().detach()), third, rtol=0.4)


def test_a_crop_without_snow_teaches_it_nothing_that_is_not_a_number(grain, rng):
    air = held(n_air=SIZE[0])
    grain.mismatch(drawn(grain, air, rng=rng), air).backward()
    assert all(torch.isfinite(parameter.grad).all() for parameter in grain.parameters())
