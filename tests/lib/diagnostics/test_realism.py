"""Numbers of the flight that stand beside published ones, on planted answers."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from lib.diagnostics.realism import falling_length, layer_spread_db, visibility


@pytest.mark.parametrize("length", [3.0, 18.0])
def test_an_exponential_falls_to_1_e_at_its_length(length):
    # On a straight line between lags: off by at most 1 / (8 length) of a lag.
    assert_allclose(falling_length(np.exp(-np.arange(60) / length)), length, atol=1 / (8 * length))


def test_a_steady_fall_is_no_spread_of_layers_and_a_zigzag_is():
    fall = 10 ** (-np.arange(12) / 10)
    assert_allclose(layer_spread_db(fall), 0, atol=1e-7)
    # Levels of +1 and -1 dB in turn: second differences of 4 dB.
    zigzag = fall * 10 ** (0.1 * (-1.0) ** np.arange(12))
    assert_allclose(layer_spread_db(zigzag), 4 / np.sqrt(6), rtol=1e-6)
    assert np.isnan(layer_spread_db(fall[:4]))


def test_a_planted_rise_over_the_snow_comes_back_whatever_the_fall_with_depth():
    layer_bins = np.array([50.0, 90, 130, 170])[:, None] * np.ones(256)
    power = np.repeat(10 ** (-0.02 * np.arange(220.0))[:, None], 256, axis=1)
    power[[90, 130]] *= 4
    depth, rise_db = visibility(power, layer_bins)
    assert_allclose(depth, [40, 80])
    assert_allclose(rise_db, 10 * np.log10(4), rtol=1e-9)
