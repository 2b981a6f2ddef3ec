"""The closed loop says what came back, and how far it is off."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from planted import Alike

from evaluation.lib.closed_loop import (
    BOUNDS,
    COLUMNS,
    SPREADS,
    as_frame,
    compare,
    recovery_table,
    thinned,
)
from snowsim import statistics
from snowsim.statistics import estimate, merge, summarise
from snowsim.statistics.summaries import MINIMUM_BLOCKS


@pytest.fixture(scope="module")
def fitted(flight):
    dataset = statistics.fit(flight)
    # Four blocks are too few for zones of their own; here only the bookkeeping counts, so they are
    # taken as enough.
    return dataset.assign(n_samples=dataset["n_samples"] + MINIMUM_BLOCKS)


def of_quantity(table, quantity):
    """Rows of one quantity, there must be some."""
    rows = table[table["quantity"] == quantity]
    assert len(rows)
    return rows


def test_statistics_equal_themselves(fitted):
    table = compare(fitted, fitted)
    # Zero: this flight is not levelled, and is too short for spreads.
    not_levelled = {"surface_movement_bins", "surface_movement_length_m"}
    assert set(BOUNDS) - not_levelled <= set(table["quantity"])
    assert (table["error"] == 0).all()
    assert not set(compare(fitted, fitted, varies=False)["quantity"]) & set(SPREADS)


def test_errors_are_relative_or_in_bins_and_held_against_their_bounds(fitted):
    wider = fitted["width_bins"] + 1.5
    recovered = fitted.assign(peak_power=1.02 * fitted["peak_power"], width_bins=wider)
    table = compare(fitted, recovered)
    powers = of_quantity(table, "peak_power")
    # The factors come back to rounding.
    assert_allclose(powers["error"], 0.02, rtol=1e-10)
    assert powers["within"].all()
    widths = of_quantity(table, "width_bins")
    assert_allclose(widths["error"], 1.5, rtol=1e-10)
    assert set(widths["unit"]) == {"bins"}
    assert not widths["within"].any()


def test_what_was_no_measurement_is_left_out_and_other_numbers_of_layers_meet(fitted):
    no_shape = fitted.assign(substituted=fitted["substituted"] + (np.arange(5) == 4))
    assert 4 not in set(of_quantity(compare(fitted, no_shape), "decay_rate")["layer"])
    pooled = fitted.assign(n_samples=fitted["n_samples"] * 0)
    assert "thickness_mean_bins" not in set(compare(fitted, pooled)["quantity"])
    relative = of_quantity(compare(fitted, fitted), "relative_thickness_mean")
    assert 0 not in set(relative["slab"])
    shallow = fitted.isel(layer=slice(0, 3), slab=slice(0, 2))
    for table in (compare(fitted, shallow), compare(shallow, fitted)):
        assert set(of_quantity(table, "peak_power")["layer"]) == {0, 1, 2}
        assert set(of_quantity(table, "thickness_mean_bins")["slab"]) == {0, 1}
        assert (table["error"] == 0).all()


def test_planted_values_go_round_the_loop():
    planted = Alike()
    lengths = {"bin_size_s": 2.886e-10, "line_spacing_m": 5.47}
    frames = [as_frame(*planted.level(), index, **lengths) for index in range(5)]
    some = merge(thinned(summarise(*frame), 2) for frame in frames)
    assert some["n_groups"].values.tolist() == [6] * 5
    recovered = estimate(some)
    # The fit ends when steps fall below 1e-3.
    assert_allclose(recovered["peak_power"], planted.peak_power, rtol=2e-3)
    assert_allclose(recovered.attrs["bin_size_s"], 2.886e-10, rtol=1e-12)
    # Positions are made on the sphere that distances are measured on; degrees hold 1e-14 of 70.
    assert_allclose(recovered.attrs["line_spacing_m"], 5.47, rtol=1e-7)


def test_renders_too_poor_for_statistics_give_an_empty_table_and_say_why(fitted, flight, caplog):
    # Of every frame only the surface is picked: no block shows slab 0.
    bare = merge(
        summarise(echogram, layers.isel(layer=slice(0, 1)), where="bare")
        for echogram, layers in flight
    )
    table = recovery_table(bare, fitted, varies=True)
    assert table.empty
    assert list(table.columns) == COLUMNS
    reason = "zones need slab 0 picked in half of a block of 256 lines"
    assert f"from {bare.sizes['frame']} renders: {reason}" in caplog.text
