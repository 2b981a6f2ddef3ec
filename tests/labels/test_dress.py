"""Layers dressed with the powers of a flight: what they take from its statistics."""

import numpy as np
import pytest
import xarray as xr
from numpy.testing import assert_allclose, assert_array_equal
from refusals import refusal

from snowsim.constants import STATISTICS_CONTENT
from snowsim.echogram import Kind
from snowsim.labels import dress


@pytest.fixture
def statistics():
    return xr.Dataset(
        {
            "peak_power": ("layer", [1.0, 0.3, 0.2]),
            "decay_rate": ("layer", [0.09, 0.07, np.nan]),
            "variance_bins2": ("layer", [11.0, 12.0, 13.0]),
            "noise_power": 1e-3,
        },
        attrs={"content": STATISTICS_CONTENT, "n_looks": 100.0},
    )


def flat(n_layers, n_lines=4):
    """Layers 20 bins apart."""
    return np.repeat(50.0 + 20 * np.arange(n_layers)[:, None], n_lines, axis=1)


def test_a_scene_takes_the_uppermost_layers_and_deeper_ones_look_like_the_last_valid_one(
    statistics,
):
    echoes = dress(flat(5), statistics)
    assert_array_equal(echoes.power, np.repeat([[1], [0.3], [0.2], [0.2], [0.2]], 4, axis=1))
    assert_array_equal(echoes.decay_rate, [0.09, 0.07, 0.07, 0.07, 0.07])
    assert_array_equal(echoes.variance_bins2, [11, 12, 13, 13, 13])
    assert_array_equal(echoes.kind, [Kind.LAYER] * 5)
    assert echoes.noise_power == 1e-3
    assert echoes.n_looks == 100
    assert echoes.speckle_correlation is None
    # A shallow scene takes the uppermost layers. Speckle is correlated as measured, where it was.
    statistics["speckle_correlation"] = ("speckle_lag", [1.0, 0.1])
    shallow = dress(flat(2), statistics)
    assert_array_equal(shallow.power[:, 0], [1, 0.3])
    assert_array_equal(shallow.speckle_correlation, [1, 0.1])


def test_the_background_lies_below_the_surface_and_has_its_own_power_and_fall(statistics):
    layer_bins = np.repeat([[50.0], [50.5], [90.0]], 8, axis=1)
    layer_bins[1, 4:] = np.nan
    statistics["background_power"] = ("fall", [0.01, 0.0, 0.002])
    statistics["fall"] = ("fall", [30.0, 100.0, 1000.0])
    echoes = dress(layer_bins, statistics)
    assert (np.diff(echoes.bins[:4, :4], axis=0) > 0).all()
    assert_array_equal(np.flatnonzero(echoes.kind == Kind.BACKGROUND), [1, 2])
    assert_array_equal(echoes.bins[echoes.kind == Kind.LAYER], layer_bins)
    # Falls of no power have no row.
    assert_array_equal(echoes.power[1:3], np.repeat([[0.01], [0.002]], 8, axis=1))
    assert_allclose(1 / echoes.decay_rate[1:3], [30, 1000])


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("peak_power", ("layer", [np.nan, 1, 1]), "peak_power at layer 0 must be finite, above 0"),
        ("noise_power", np.nan, "need noise_power, all finite"),
    ],
)
def test_bad_statistics_are_refused(statistics, name, value, message):
    statistics[name] = value
    with refusal(message):
        dress(flat(3), statistics)
