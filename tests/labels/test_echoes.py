"""Echoes of layers: what they take from the statistics of a flight."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from planted_labels import planted
from refusals import refusal

from snowsim.echogram import Kind
from snowsim.labels import echoes_of_layers


def flat(n_layers):
    """Layers 20 bins apart on 4 range lines."""
    return np.repeat(50.0 + 20 * np.arange(n_layers)[:, None], 4, axis=1)


def test_a_scene_takes_the_uppermost_layers_and_deeper_ones_look_like_the_last_valid_one():
    variance = np.arange(11.0, 19.0)
    statistics = planted(variance_bins2=variance, decay_rate=[0.09, 0.07, *[np.nan] * 6])
    statistics = statistics.drop_vars("background_power")
    echoes = echoes_of_layers(flat(10), statistics)
    uppermost = np.minimum(np.arange(10), 7)
    power = statistics["peak_power"].values[uppermost]
    assert_array_equal(echoes.power, np.repeat(power[:, None], 4, axis=1))
    assert_array_equal(echoes.decay_rate, [0.09, *[0.07] * 9])
    assert_array_equal(echoes.variance_bins2, variance[uppermost])
    assert_array_equal(echoes.kind, Kind.LAYER)
    assert (echoes.noise_power, echoes.n_looks) == (1e-3, 1000)
    assert echoes.speckle_correlation is None
    # A shallow scene takes the uppermost layers. Speckle is correlated as measured, where it was.
    statistics["speckle_correlation"] = ("speckle_lag", [1.0, 0.1])
    shallow = echoes_of_layers(flat(2), statistics)
    assert_array_equal(shallow.power[:, 0], power[:2])
    assert_array_equal(shallow.speckle_correlation, [1, 0.1])


def test_the_background_lies_below_the_surface_and_has_its_own_power_and_fall():
    layer_bins = np.repeat([[50.0], [50.5], [90.0]], 8, axis=1)
    layer_bins[1, 4:] = np.nan
    echoes = echoes_of_layers(layer_bins, planted(background_power=[0.01, 0.0, 0.002]))
    assert (np.diff(echoes.bins[:4, :4], axis=0) > 0).all()
    assert_array_equal(np.flatnonzero(echoes.kind == Kind.BACKGROUND), [1, 2])
    assert_array_equal(echoes.bins[echoes.kind == Kind.LAYER], layer_bins)
    # Falls of no power have no row.
    assert_array_equal(echoes.power[1:3], np.repeat([[0.01], [0.002]], 8, axis=1))
    assert_allclose(1 / echoes.decay_rate[1:3], [30, 1000])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"peak_power": [np.nan] * 8}, "peak_power at layer 0 must be finite, above 0"),
        ({"noise_power": np.nan}, "need noise_power, all finite"),
    ],
)
def test_bad_statistics_are_refused(change, message):
    with refusal(message):
        echoes_of_layers(flat(3), planted(**change))
