"""Measures of error: what they measure is known in other ways."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.special import gammainc
from scipy.stats import kstest

from lib.diagnostics.phy_alternatives import render_scatterers
from lib.diagnostics.phy_errors import (
    cube_below,
    cube_distance,
    largest_error_db,
    mean_of_looks_below,
    moving_distance,
    planted_scene,
    quantile_distance,
    scattered_mean_power,
)
from snowsim.echogram import check_layer_bins
from snowsim.phy import draw_speckle


@pytest.mark.parametrize(("n_layers", "n_range_bins"), [(1, 64), (15, 256), (80, 1024)])
def test_planted_layers_never_cross(n_layers, n_range_bins):
    layer_bins, parameters = planted_scene(n_layers, 128, n_range_bins)
    check_layer_bins(layer_bins)
    assert parameters["peak_power"].shape == (n_layers,)
    assert np.all(np.diff(parameters["peak_power"]) < 0)


def test_error_is_that_of_power_plus_noise():
    # 10 log10(2) at a pixel of twice the power, nothing where both vanish.
    assert_allclose(largest_error_db([3.0, 0.0], [1.0, 0.0], 1.0), 10 * np.log10(2))
    assert largest_error_db([0.0], [0.0], 0.0) == 0
    for broken in (np.nan, np.inf, -0.1):
        assert largest_error_db([broken], [0.0], 0.0) == np.inf
    assert largest_error_db([1e-3], [0.0], 0.0) == np.inf


def test_equal_looks_are_gamma():
    level = np.array([0.3, 0.9, 1.0, 1.8])
    # The transform is summed until it has fallen to 1e-7.
    assert_allclose(mean_of_looks_below(level, np.ones(12)), gammainc(12, 12 * level), atol=1e-7)
    assert moving_distance(np.ones(12)) < 1e-7


def test_two_looks_add_to_their_closed_form():
    # The mean of exponentials of mean 3 and 1 has F = 1 - (3 exp(-2x / 3) - exp(-2x)) / 2; phi falls as u^-2 only.
    level = np.array([0.2, 1.0, 5.0])
    expected = 1 - (3 * np.exp(-2 * level / 3) - np.exp(-2 * level)) / 2
    assert_allclose(mean_of_looks_below(level, [3.0, 1.0]), expected, atol=1e-6)


def test_distances_are_those_of_drawn_values(rng):
    n_values = 400_000
    ones, means = np.ones((400, 1000)), 10 ** -np.linspace(0, 2, 16)
    noise = 1.95 / np.sqrt(n_values)  # Kolmogorov: exceeded once in 1000
    cube = draw_speckle(ones, 10, method="cube", rng=rng).ravel()
    assert kstest(cube, lambda x: cube_below(x, 10)).statistic < noise
    assert abs(kstest(cube, lambda x: gammainc(10, 10 * x)).statistic - cube_distance(10)) < noise
    quantile = draw_speckle(ones, 16, method="quantile", rng=rng).ravel()
    assert kstest(quantile, lambda x: gammainc(16, 16 * x)).statistic < noise + quantile_distance(16)
    moving = np.broadcast_to(means[:, None, None], (16, 400, 1000))
    matched = draw_speckle(moving, 16, method="gamma", rng=rng).ravel()
    table = np.linspace(1e-4, matched.max(), 3000)
    literal = kstest(matched, lambda x: np.interp(x, table, mean_of_looks_below(table, means))).statistic
    # 1.4e-2 here, several times the noise.
    assert abs(literal - moving_distance(means)) < noise
    assert moving_distance(means) > 4 * noise


def test_scatterers_have_the_mean_that_is_stated(rng):
    layer_bins, parameters = planted_scene(2, 1, 64, n_looks=1e9)
    drawn = render_scatterers(layer_bins, parameters, 64, rng=rng, n_scatterers=200_000, align="peak")
    stated = scattered_mean_power(layer_bins, parameters, 64, align="peak")
    # A pixel sees at least 1 % of the scatterers of one layer, with exponential power: 3 % each; four of those.
    assert_allclose(drawn, stated, rtol=0.13)
    # Sinc-squared sidelobes of the whole layer where eq. (1) has nothing: 1 / (2 pi^2 x^2) of its energy on average.
    assert stated[0, 0] > 1.1 * parameters["noise_power"]
