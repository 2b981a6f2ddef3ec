"""A simulated layer has an interface and, below it, the peak of its echo: images show the echo."""

import numpy as np
import pytest
import xarray as xr
from numpy.testing import assert_allclose, assert_array_equal

from snowsim import Climate, simulate, statistics
from snowsim.alignment import (
    bin_size_s,
    cut_blocks,
    echo_twtt,
    flatten,
    join,
    layer_bins_of,
    range_bins,
    shifted,
)


def peaks_in_bins(echogram, layers):
    """Peaks of the echoes of simulated layers in range bins, (layer, range_line)."""
    twtt = echogram["twtt"].values
    return (layers["peak_twtt"].values - twtt[0]) / (twtt[1] - twtt[0])


@pytest.fixture(scope="module")
def simulated():
    """Echogram and layers of twenty years, 300 range lines; layers also tell their interfaces."""
    return simulate(Climate(accumulation_m=0.5), "snow-2-8", n_range_lines=300, rng=3)


def test_layers_of_simulate_lie_where_their_echoes_peak_in_all_that_is_made_of_a_frame(simulated):
    echogram, layers = simulated
    # Interfaces lie half a bin and more above.
    away = peaks_in_bins(echogram, layers) - range_bins(layers["twtt"].values, echogram)
    assert away.min() > 0.5
    joined, aligned = join(echogram, layers)
    assert_allclose(echo_twtt(aligned), layers["peak_twtt"], rtol=1e-12)
    # One pick per range line of a level frame: scenes hold range bins of their own first row on.
    (scene,), _ = cut_blocks(joined, aligned, name="s")
    found = scene.layer_bins * scene.notes["bin_size_s"] + scene.notes["first_twtt_s"]
    assert_allclose(found, echo_twtt(aligned)[:, :256], rtol=1e-12)
    # The same layers as picks that a person put on the peaks.
    picked = layers.assign(twtt=layers["peak_twtt"]).drop_vars("peak_twtt")
    assert statistics.fit([simulated]).equals(statistics.fit([(echogram, picked)]))


def test_levelled_layers_keep_the_distance_of_peak_and_interface(simulated):
    echogram, layers = simulated
    down = np.round(10 * np.sin(np.arange(300) / 30)).astype(int)
    moved = shifted(echogram, down)
    later = xr.DataArray(down * bin_size_s(echogram), dims="slow_time")
    names = ("twtt", "peak_twtt")
    tilted = layers.assign({name: layers[name] + later for name in names})
    level, made_level = flatten(moved, tilted)
    found = layer_bins_of(made_level, level) - range_bins(made_level["twtt"].values, level)
    expected = peaks_in_bins(echogram, layers) - range_bins(layers["twtt"].values, echogram)
    assert_allclose(found, expected, atol=1e-6)


def test_a_pick_that_was_taken_away_leaves_no_echo(simulated):
    echogram, layers = simulated
    twtt = layers["twtt"].copy()
    twtt[3, 100:] = np.nan
    found = layer_bins_of(layers.assign(twtt=twtt), echogram)
    assert_array_equal(np.isnan(found).sum(axis=1)[2:5], [0, 200, 0])
