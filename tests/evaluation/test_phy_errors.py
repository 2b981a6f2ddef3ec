"""Measures of error, and the best fit of eq. (1): what they give is known in other ways."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.special import gammainc
from scipy.stats import ks_2samp, kstest

from evaluation.lib import phy_errors
from evaluation.lib.phy_alternatives import draw_moving_speckle, render_scatterers
from snowsim.echogram import check_layer_bins
from snowsim.phy import draw_speckle
from snowsim.phy.waveform import waveform_exact


@pytest.mark.parametrize(("n_layers", "n_range_bins"), [(1, 64), (15, 256), (80, 1024)])
def test_planted_layers_never_cross(n_layers, n_range_bins):
    layer_bins, parameters = phy_errors.planted_scene(n_layers, 128, n_range_bins)
    check_layer_bins(layer_bins)
    assert parameters["peak_power"].shape == (n_layers,)
    assert np.all(np.diff(parameters["peak_power"]) < 0)


def test_error_is_that_of_power_plus_noise():
    # Twice the power at a pixel, nothing where both vanish.
    error_db = phy_errors.largest_error_db([3.0, 0.0], [1.0, 0.0], 1.0)
    assert_allclose(error_db, 10 * np.log10(2))
    assert phy_errors.largest_error_db([0.0], [0.0], 0.0) == 0
    for broken in (np.nan, np.inf, -0.1):
        assert phy_errors.largest_error_db([broken], [0.0], 0.0) == np.inf
    assert phy_errors.largest_error_db([1e-3], [0.0], 0.0) == np.inf


def test_equal_looks_are_gamma_and_two_unlike_ones_their_closed_form():
    level = np.array([0.3, 0.9, 1.0, 1.8])
    # The transform is summed until it has fallen to 1e-7.
    below = phy_errors.mean_of_looks_below(level, np.ones(12))
    assert_allclose(below, gammainc(12, 12 * level), atol=1e-7)
    assert phy_errors.moving_distance(np.ones(12)) < 1e-7
    # The mean of exponentials of mean 3 and 1 has F = 1 - (3 exp(-2x / 3) - exp(-2x)) / 2; phi
    # falls as u^-2 only.
    level = np.array([0.2, 1.0, 5.0])
    expected = 1 - (3 * np.exp(-2 * level / 3) - np.exp(-2 * level)) / 2
    below = phy_errors.mean_of_looks_below(level, [3.0, 1.0])
    assert_allclose(below, expected, atol=1e-6)


def test_distances_are_those_of_drawn_values(rng):
    n_values = 400_000
    ones = np.ones((400, 1000))
    means = 10 ** -np.linspace(0, 2, 16)
    noise = 1.95 / np.sqrt(n_values)  # Kolmogorov: exceeded once in 1000
    cube = draw_speckle(ones, 10, method="cube", rng=rng).ravel()
    assert kstest(cube, lambda x: phy_errors.cube_below(x, 10)).statistic < noise
    from_gamma = kstest(cube, lambda x: gammainc(10, 10 * x)).statistic
    assert abs(from_gamma - phy_errors.cube_distance(10)) < noise
    quantile = draw_speckle(ones, 16, method="quantile", rng=rng).ravel()
    from_gamma = kstest(quantile, lambda x: gammainc(16, 16 * x)).statistic
    assert from_gamma < noise + phy_errors.quantile_distance(16)
    moving = np.broadcast_to(means[:, None, None], (16, 400, 1000))
    matched = draw_moving_speckle(moving, method="gamma", rng=rng).ravel()
    table = np.linspace(1e-4, matched.max(), 3000)
    summed = phy_errors.mean_of_looks_below(table, means)
    from_sum = kstest(matched, lambda x: np.interp(x, table, summed)).statistic
    # 1.4e-2 here, several times the noise.
    assert abs(from_sum - phy_errors.moving_distance(means)) < noise
    assert phy_errors.moving_distance(means) > 4 * noise


def test_moving_geometry_keeps_mean_and_variance_of_the_sum_of_looks_and_a_still_one_is_exact(rng):
    # A layer that leaves a pixel during the looks: means fall from 1 to 0.05.
    means = np.geomspace(1, 0.05, 20)[:, None, None] * np.ones((20, 400, 500))
    summed = draw_moving_speckle(means, method="looks", rng=rng)
    matched = draw_moving_speckle(means, method="gamma", rng=rng)
    of_pixel = means[:, 0, 0]
    expected_variance = (of_pixel**2).sum() / 20**2
    for power in (summed, matched):
        # Known to 1 / sqrt(200_000) of a deviation, and about 2 sqrt(2 / 200_000): allow five of
        # those.
        assert_allclose(power.mean(), of_pixel.mean(), rtol=5e-3)
        assert_allclose(power.var(), expected_variance, rtol=0.03)
    # Not the same distribution, but close: their distribution functions are 1.0e-2 apart here.
    assert ks_2samp(summed.ravel(), matched.ravel(), method="asymp").statistic < 0.02
    mean_power = rng.uniform(0.1, 1, (30, 40))
    looks = np.broadcast_to(mean_power, (12, 30, 40))
    still = draw_moving_speckle(looks, method="gamma", rng=np.random.default_rng(5))
    # Equal means give a shape of 12, to rounding; the gamma draw depends on it smoothly.
    exact = draw_speckle(mean_power, 12, method="gamma", rng=np.random.default_rng(5))
    assert_allclose(still, exact, rtol=1e-9)


def test_scatterers_have_the_mean_that_is_stated(rng):
    layer_bins, parameters = phy_errors.planted_scene(2, 1, 64, n_looks=1e9)
    drawn = render_scatterers(layer_bins, parameters, 64, rng=rng, n_scatterers=200_000)
    stated = phy_errors.scattered_mean_power(layer_bins, parameters, 64)
    # A pixel sees at least 1 % of the scatterers of one layer, with exponential power: 3 % each;
    # four of those.
    assert_allclose(drawn, stated, rtol=0.13)
    # Sinc-squared sidelobes of the whole layer where eq. (1) has nothing: 1 / (2 pi^2 x^2) of its
    # energy on average.
    assert stated[0, 0] > 1.1 * parameters["noise_power"]


@pytest.mark.parametrize(("variance", "decay"), [(12.0, 0.05), (2.0, 0.09), (0.5, 0.2)])
def test_a_waveform_of_eq_1_is_found_again(variance, decay):
    x = np.arange(-20, 150, 0.25)
    echo = 0.3 * waveform_exact(x - 4.0, variance, decay)
    fit = phy_errors.fit_waveform(x, echo, 20.0)
    # Least squares stop at 1e-12 of the cost; the parameters' errors are its square root.
    assert fit.rms_db < 1e-4
    assert_allclose(fit.variance_bins2, variance, rtol=1e-3)
    assert_allclose(fit.decay_rate, decay, rtol=1e-3)
    assert_allclose(fit.amplitude, 0.3, rtol=1e-3)
    assert_allclose(fit.offset_bins, 4.0, atol=1e-3)


def test_two_decays_are_no_waveform_of_eq_1_and_the_error_says_by_how_much():
    x = np.arange(0, 200, 0.5)
    level_db = np.where(x < 50, -0.2 * x, -10 - 0.1 * (x - 50))
    fit = phy_errors.fit_waveform(x, 10 ** (level_db / 10), 20.0)
    # Beyond its Gaussian eq. (1) is a straight line in decibels: the best line is what it can do,
    # and hardly more.
    tail = x[:300]
    tail_db = level_db[:300]
    line_db = np.polyval(np.polyfit(tail, tail_db, 1), tail)
    assert_allclose(fit.rms_db, np.sqrt(np.mean((line_db - tail_db) ** 2)), rtol=0.05)
    assert fit.largest_db > fit.rms_db
    one = waveform_exact(tail - fit.offset_bins, fit.variance_bins2, fit.decay_rate)
    error_db = 10 * np.log10(fit.amplitude * one) - tail_db
    assert_allclose(np.sqrt(np.mean(error_db**2)), fit.rms_db, rtol=0.02)
    assert_allclose(fit.n_bins, 150, atol=1)


@pytest.mark.parametrize(
    ("power", "message"),
    [
        (np.ones(10), "has no end"),
        (np.array([1.0, 0.5, *[0.0] * 8]), "six samples"),
        (np.array([1.0, -0.5, *[0.0] * 8]), "not negative"),
        (np.ones(4), "shapes"),
    ],
)
def test_what_has_no_tail_is_refused(power, message):
    with pytest.raises(ValueError, match=message):
        phy_errors.fit_waveform(np.arange(10), power, 20.0)
