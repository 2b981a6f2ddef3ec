"""The closed loop says what came back and why the rest did not."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from evaluation.lib import closed_loop
from evaluation.lib.closed_loop import (
    BOUNDS,
    COLUMNS,
    VARIES,
    as_frame,
    compare,
    summarise_loop,
    thinned,
)
from evaluation.lib.conventions import Convention
from evaluation.lib.figures.closed_loop import closed_loop as draw_closed_loop
from snowsim import statistics
from snowsim.statistics import estimate, merge, summarise


@pytest.fixture(scope="module")
def fitted(flight):
    dataset = statistics.fit(flight)
    # Four blocks are too few for zones of their own; here only the bookkeeping counts, so they are
    # taken as enough.
    return dataset.assign(source=dataset["source"] * 0, psd_source=dataset["psd_source"] * 0)


def spoiled(dataset, **factors):
    """A copy of a dataset with some variables multiplied."""
    return dataset.assign({name: dataset[name] * factor for name, factor in factors.items()})


def test_statistics_equal_themselves_and_other_zones_cannot_be_compared(fitted):
    table = compare(fitted, fitted)
    assert list(table.columns) == list(COLUMNS)
    # Zero: this flight is not levelled, has no texture, and is too short for spreads.
    assert set(table["quantity"]) >= set(BOUNDS) - {"surface_fraction", *VARIES}
    assert not set(compare(fitted, fitted, varies=False)["quantity"]) & set(VARIES)
    assert (table["error"] == 0).all()
    assert table["within"].all()
    assert (table["reason"] == "").all()
    assert closed_loop.largest_errors(table)["score"] == 0
    moved = fitted.assign(zone_edge_bins=fitted["zone_edge_bins"] + 1)
    with pytest.raises(ValueError, match="zone_edge_bins"):
        compare(fitted, moved)


def test_errors_are_in_the_unit_of_their_bound(fitted):
    recovered = spoiled(fitted, peak_power=1.02, thickness_psd=10**0.05).assign(
        width_bins=fitted["width_bins"] + 0.5
    )
    table = compare(fitted, recovered).set_index("quantity")
    # The factors come back to rounding.
    assert_allclose(table.loc["peak_power", "error"], 0.02, rtol=1e-10)
    assert_allclose(table.loc["thickness_psd", "error"], 0.5, rtol=1e-10)
    assert_allclose(table.loc["width_bins", "error"], 0.5, rtol=1e-10)
    assert table["within"].all()


def test_an_error_of_a_spectrum_is_its_bands_mean_density(fitted):
    density = fitted["thickness_psd"].copy()
    density[..., 3:9] *= 2  # the second band, 3 to 8 cycles per block
    table = compare(fitted, fitted.assign(thickness_psd=density))
    spectrum = table[table["quantity"] == "thickness_psd"]
    assert_allclose(spectrum.loc[spectrum["band"] == 1, "error"], 10 * np.log10(2), rtol=1e-10)
    assert (spectrum.loc[spectrum["band"] != 1, "error"] == 0).all()


def test_what_is_beyond_its_bound_has_a_reason(fitted):
    reasons = {}
    for factor in (1.04, 1.5):
        table = compare(
            fitted, spoiled(fitted, peak_power=factor, thickness_mean_bins=factor)
        ).set_index("quantity")
        assert not table.loc["peak_power", "within"].any()
        reasons[factor] = set(table.loc["peak_power", "reason"])
        if factor == 1.5:
            assert set(table.loc["thickness_mean_bins", "reason"]) == {"bias"}
    # Powers are known to half a per cent: 4 % are some of them sampling's beyond a bound of 3 %, 50
    # % are none.
    assert reasons[1.04] <= {"sampling", "bias"}
    assert reasons[1.5] == {"bias"}
    faint = fitted.assign(noise_power=fitted["noise_power"] * 1e3)
    table = compare(faint, spoiled(faint, decay_rate=2)).set_index("quantity")
    assert set(table.loc["decay_rate", "reason"]) == {"below the noise"}


def test_zones_drawn_evenly_are_the_reason_only_where_that_explains_the_error(fitted, rng):
    low, high = np.array([30.0, 40, 50, 60]), np.array([40.0, 50, 60, 90])
    first = rng.uniform(low, high, (100_000, 4))
    factor = 0.8 + 0.1 * rng.standard_normal(first.shape)
    cells = np.ones((4, 4))
    given = fitted.assign(
        zone_edge_bins=("edge", [*low, 90.0]),
        relative_thickness_mean=(("zone", "slab"), 0.8 * cells),
        relative_thickness_variance=(("zone", "slab"), 0.01 * cells),
    )
    drawn = {
        "mean_bins": (first * factor).mean(axis=0),
        "variance_bins2": (first * factor).var(axis=0),
    }
    for name, values in drawn.items():
        # 100,000 scenes know both to a per cent, far below the bounds.
        evenly = given.assign({f"thickness_{name}": (("zone", "slab"), values[:, None] * cells)})
        for true, reason in (
            (evenly, "zone drawn evenly"),
            (spoiled(evenly, **{f"thickness_{name}": 2}), "bias"),
        ):
            start = given.assign({f"thickness_{name}": fitted[f"thickness_{name}"] * 0 + 1})
            recovered = true.assign(
                {f"thickness_{name}_standard_error": fitted[f"thickness_{name}"] * 0}
            )
            table = compare(start, recovered).set_index("quantity")
            assert set(table.loc[f"thickness_{name}", "reason"]) == {reason}, name


def test_what_was_no_measurement_and_the_paper_s_deepest_decay_rate_are_left_out(fitted, flight):
    no_shape = fitted.assign(substituted=fitted["substituted"] + (np.arange(5) == 4))
    pooled = no_shape.assign(source=fitted["source"] + 1)
    table = compare(fitted, pooled)
    assert 4 not in set(table.loc[table["quantity"] == "decay_rate", "layer"])
    assert "thickness_mean_bins" not in set(table["quantity"])
    relative = compare(fitted, fitted)
    assert 0 not in set(relative.loc[relative["quantity"] == "relative_thickness_mean", "slab"])
    by_paper = statistics.fit(flight, estimator="paper")
    table = compare(by_paper, by_paper)
    assert sorted(table.loc[table["quantity"] == "decay_rate", "layer"]) == [0, 1, 2, 3]


def test_the_short_table_counts_what_the_long_one_holds(fitted):
    table = compare(fitted, spoiled(fitted, peak_power=1.5))
    short = summarise_loop(table).set_index("quantity")
    assert short.loc["peak_power", ["n", "n_within"]].to_list() == [5, 0]
    assert short.loc["peak_power", "reasons"] == "bias: 5"
    assert_allclose(short.loc["peak_power", ["median", "largest"]].astype(float), 0.5, rtol=1e-10)
    assert short.loc["decay_rate", "reasons"] == ""
    assert short.loc["peak_power", ["n_resolved", "n_resolved_within"]].to_list() == [5, 0]
    assert (short["n_resolved_within"] <= short[["n_resolved", "n_within"]].min(axis=1)).all()


def test_planted_values_go_round_the_loop(planted, rng):
    frames, bin_size_s = [], 2.886e-10
    for index in range(8):
        thickness = (
            44
            + 2 * rng.standard_normal((4, 1))
            + np.cumsum(0.1 * rng.standard_normal((4, 256)), axis=1)
        )
        layer_bins = 50 + np.concatenate([np.zeros((1, 256)), np.cumsum(thickness, axis=0)])
        power = rng.gamma(5, planted.power(layer_bins, 340) / 5)
        frames.append(
            as_frame(power, layer_bins, index, bin_size_s=bin_size_s, line_spacing_m=5.47)
        )
    whole = merge(summarise(*frame) for frame in frames)
    some = merge(thinned(summarise(*frame), 2) for frame in reversed(frames))
    assert [frame.power.shape[0] for frame in whole] == [12] * 8
    assert [frame.power.shape[0] for frame in some] == [6] * 8
    assert [frame.start_ns for frame in some] == [frame.start_ns for frame in whole]
    edges = np.linspace(30, 60, 5)
    for summary in (whole, some):
        recovered = estimate(summary, zone_edge_bins=edges)
        # 48 groups of 100 looks: a power to 2 %, a rate to 2.5 % by its own standard error; allow
        # three and four.
        assert_allclose(recovered["peak_power"], planted.peak_power, rtol=0.06)
        assert_allclose(recovered["decay_rate"], planted.decay_rate, rtol=0.1)
        assert_allclose(recovered.attrs["bin_size_s"], bin_size_s, rtol=1e-12)
        # Positions are made on the sphere that distances are measured on; degrees hold 1e-14 of 70.
        assert_allclose(recovered.attrs["line_spacing_m"], 5.47, rtol=1e-7)


def test_renders_too_poor_for_statistics_give_a_table_that_says_why(fitted, flight):
    # Of every frame only the surface is picked: no block shows slab 0.
    bare = merge(
        summarise(echogram, layers.isel(layer=slice(0, 1)), where="bare")
        for echogram, layers in flight
    )
    recovered, table = closed_loop.recover(bare, fitted, varies=True)
    reason = "zones need slab 0 picked in half of a block of 256 lines"
    assert recovered.attrs["not_recovered"].startswith(reason)
    assert recovered.attrs["n_frames"] == len(bare)
    assert np.isnan(recovered["peak_power"]).all()
    assert table["reason"].str.startswith(reason).all()
    assert set(compare(fitted, fitted)["quantity"]) == set(table["quantity"])
    assert not table["within"].any()
    summary = summarise_loop(table).set_index("quantity")
    assert (summary["n_within"] == 0).all()
    assert summary["reasons"].str.startswith(reason).all()
    convention = Convention("deblended", "none", "peak", "fitted")
    conventions = closed_loop.convention_table([(convention, table, 4)])
    assert np.isnan(conventions["score"].item())
    figure = draw_closed_loop(table, conventions, "bare renders")
    assert figure.axes
