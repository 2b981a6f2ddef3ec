import numpy as np
import pytest
from made_up import made_up_frame
from numpy.testing import assert_allclose
from planted import Planted

from snowsim.statistics import estimate, summarise


def fitted(power, layer_bins):
    """Statistics of one frame, by the joint solution."""
    return estimate(summarise(*made_up_frame(power, layer_bins)))


def in_lines(of_groups):
    """Values (group, row) that stay over the 20 range lines of a group, (row, range_line)."""
    return np.repeat(of_groups, 20, axis=0).T


def test_layers_closer_than_their_width_are_distinguished(planted, rng):
    """A thin slab of 9 bins, less than a 1/e width."""
    moved = np.arange(5) * rng.standard_normal((60, 5))
    layer_bins = in_lines(np.array([50.2, 80, 89, 110, 150]) + moved)
    power = planted.power(layer_bins, 260)
    found = fitted(rng.gamma(5, power / 5), layer_bins)
    # Shapes are alike by a fifth, and tails of layers so crowded do not tell them apart: they share
    # one. Powers, known to 1 %, take up what it leaves.
    assert_allclose(found["decay_rate"], planted.decay_rate, rtol=0.25)
    assert_allclose(found["peak_power"], planted.peak_power, rtol=0.1)


def test_movement_within_a_group_is_no_variance(planted):
    # Without speckle, the mean of 20 lines whose layer moves by two bins: the Gaussian widens by
    # 4 bins^2, the fit does not.
    moved = np.resize(np.linspace(-1, 1, 20), 1280)
    layer_bins = np.stack([np.full(1280, 50.0), 94 + 2 * moved / moved.std()])
    found = fitted(planted.power(layer_bins, 220), layer_bins)
    # Positions are even within each half, not Gaussian: a fourth cumulant of -1.2 x 1 bins^4 beside
    # 12.5^2.
    assert_allclose(found["variance_bins2"], 12.5, rtol=4e-3)
    assert_allclose(found["decay_rate"], planted.decay_rate[:2], rtol=1e-3)
    assert_allclose(found["peak_power"], planted.peak_power[:2], rtol=1e-3)


@pytest.mark.parametrize("seed", [0, 1])
def test_crusts_that_nobody_picked_hardly_slow_the_decay(seed):
    """Slabs of 12 to 22 bins with 1.2 crusts each, of a median 6 % of the layer's power, patchy."""
    rng = np.random.default_rng(seed)
    slab = rng.uniform(12, 22, 11)
    pick = 50 + np.append(0, np.cumsum(slab)) + rng.uniform(-1, 1, (120, 1))
    layer = np.repeat(np.arange(11), rng.poisson(1.2, 11))
    crust = pick[:, layer] + slab[layer] * rng.uniform(0, 1, layer.size)
    of_crust = 0.9 * rng.standard_normal(layer.size)
    share = 0.06 * np.exp(of_crust + 0.6 * rng.standard_normal((120, layer.size)))
    fall = np.exp(-0.1 * np.arange(12))
    crusted = Planted()
    crusted.peak_power = in_lines(np.concatenate([fall + 0 * pick, share * fall[layer]], axis=1))
    crusted.decay_rate = np.full(len(crusted.peak_power), 0.1)
    crusted.variance_bins2 = np.full(len(crusted.peak_power), 0.6)
    crusted.noise_power = 1e-4
    position = in_lines(np.concatenate([pick, crust], axis=1))
    power = crusted.power(position, 330, align="gaussian")
    found = fitted(rng.gamma(5, power / 5), in_lines(pick))
    # Without echoes between picks, and with less weight on residuals of either sign, it is 0.086
    # and 0.090.
    assert_allclose(found["decay_rate"][-1], 0.1, rtol=0.08)


@pytest.mark.parametrize("estimator", ["deblended", "paper"])
def test_close_layers_picked_on_different_lines_do_not_stop_the_fit(planted, rng, estimator):
    # Both dip by 16 bins in each averaged line. The lower is picked on the first half of its lines
    # alone: its mean row lies two bins above that of the upper.
    dip = np.tile(np.linspace(0, 16, 20), 64)
    layer_bins = np.stack([np.full(1280, 50.0), 80 + dip, 82 + dip, 130 + dip, 170 + dip])
    power = planted.power(layer_bins, 260)
    layer_bins[2, dip > 8] = np.nan
    frame = made_up_frame(rng.gamma(5, power / 5), layer_bins)
    found = estimate(summarise(*frame), estimator=estimator)
    assert (found["peak_power"] > 0).all()
