"""Layers of two years after a smooth shift: what was planted is found, chance is what it is."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from runs import parsed
from snakemake.exceptions import WorkflowError

from evaluation.lib import repeat_pass
from evaluation.lib.figures import repeat_pass as figures
from evaluation.lib.pictures import read_greenland

N_COLUMNS = 30
SPACING = 12.0


def drawn_layers(rng, n_layers=16, depth=200.0):
    """Layers (layer, column) at random levels, folded the more the deeper they lie."""
    level = np.sort(rng.uniform(5, depth, n_layers))
    wave = np.sin(np.linspace(0, 5, N_COLUMNS))
    return level[:, None] * (1 + 0.03 * wave)


def planted_shift():
    """A smooth shift about half a spacing deep, tilted and bent (column,)."""
    along = np.linspace(-1, 1, N_COLUMNS)
    return 6 + 1.5 * along - 0.8 * (3 * along**2 - 1) / 2


def test_planted_layers_are_found_in_the_other_year_and_the_shift_comes_back(rng):
    earlier = drawn_layers(rng)
    later = earlier + planted_shift()
    later[3, :20] = np.nan  # a layer picked in part is found; that of the other year is not
    spacing = repeat_pass.median_spacing(earlier, later)
    comparison = repeat_pass.compare(earlier, later, spacing)
    assert comparison.later.layers.all()
    assert comparison.earlier.layers[np.arange(16) != 3].all()
    # Each coefficient lies within half a step of the grid: 1/36 and twice 1/18 of a spacing.
    assert_allclose(comparison.shift, planted_shift(), atol=spacing * (1 / 36 + 2 / 18))


def test_layers_that_only_one_year_has_are_not_found_and_have_no_say_in_the_shift(rng):
    level = 20.0 * np.arange(1, 11)
    earlier = np.repeat(level[:, None], N_COLUMNS, axis=1)
    later = earlier + planted_shift()
    # Two more in the later year, halfway between others: at 10 rows from both, a third is 6.7.
    new = later[[2, 6]] + 10
    both = np.concatenate([later, new])
    comparison = repeat_pass.compare(earlier, both, spacing=20.0)
    assert comparison.earlier.layers.all()
    assert list(comparison.later.layers) == [True] * 10 + [False] * 2
    assert comparison.earlier.share == 1
    assert comparison.later.share == pytest.approx(10 / 12)


def test_planted_layers_are_found_more_often_than_after_random_shifts(rng):
    earlier = drawn_layers(rng)
    later = earlier + planted_shift()
    spacing = repeat_pass.median_spacing(earlier, later)
    comparison = repeat_pass.compare(earlier, later, spacing)
    controls = repeat_pass.control(earlier, later, spacing, 100, rng=rng)
    table = repeat_pass.repeat_table(comparison, controls, spacing)
    assert list(table["layers_of"]) == ["earlier", "later"]
    assert (table["share"] > table["control_high"]).all()
    assert (table["draws_as_high"] == 0).all()
    assert (table["n_draws"] == 100).all()
    assert (table["distance_rows"] < table["control_distance_rows"]).all()


def test_random_layers_are_found_no_more_often_than_after_random_shifts(rng):
    excess = []
    for _ in range(30):
        earlier = drawn_layers(rng)
        later = drawn_layers(rng)
        spacing = repeat_pass.median_spacing(earlier, later)
        found = repeat_pass.compare(earlier, later, spacing).earlier.share
        controls = repeat_pass.control(earlier, later, spacing, 20, rng=rng)
        excess.append(found - np.mean([each.earlier.share for each in controls]))
    # Four standard errors of 30 pairs of years.
    assert abs(np.mean(excess)) < 4 * np.std(excess) / np.sqrt(30)


def test_the_control_moves_layers_together_farther_than_any_shift_tried_and_keeps_their_folds(rng):
    rows = drawn_layers(rng)
    folds = repeat_pass.fold(rows)
    depth = rows.mean(axis=1).max() + 1
    moved = repeat_pass.moved_around(rows, 70.0, depth, folds)
    level = moved.mean(axis=1)
    assert_allclose(level, (rows.mean(axis=1) + 70) % depth)
    # Drawn folds are the same share of every level: so they are after the move.
    assert_allclose(moved / level[:, None], rows / rows.mean(axis=1)[:, None])


def test_years_without_layers_have_no_share_and_no_control(rng):
    some = drawn_layers(rng)
    none = np.empty((0, N_COLUMNS))
    for earlier, later in ((some, none), (none, some), (none, none)):
        spacing = repeat_pass.median_spacing(earlier, later)
        comparison = repeat_pass.compare(earlier, later, spacing)
        controls = repeat_pass.control(earlier, later, spacing, 5, rng=rng)
        table = repeat_pass.repeat_table(comparison, controls, spacing)
        assert controls == []
        assert (table["n_found"] == 0).all()
        assert table["control"].isna().all()
        assert list(table["n_layers"]) == [len(earlier), len(later)]
        assert list(table["share"].isna()) == [len(earlier) == 0, len(later) == 0]


def test_two_layers_leave_no_room_for_a_control():
    level = np.array([[10.0], [30.0]])
    rows = np.tile(level, N_COLUMNS)
    assert repeat_pass.control(rows, rows, 20.0, 5, rng=np.random.default_rng(1)) == []


def test_what_is_picked_in_a_picture_comes_back_in_its_own_rows_and_columns():
    bin_s = 3e-10
    echogram = repeat_pass.as_echogram(np.zeros((80, 5)), bin_s)
    # The surface, a layer sloping from row 10 to 14, a layer without a pick.
    sloping = np.linspace(10, 14, echogram.sizes["slow_time"])
    rows = np.stack([0 * sloping, sloping, np.nan * sloping])
    surface = echogram["Surface"].values
    layers = echogram[["Surface"]].assign(twtt=(("layer", "slow_time"), surface + bin_s * rows))
    # A column's nearest range line lies at most half a line off, of 255 over 4 rows.
    found = repeat_pass.picked_rows(layers, bin_s, 5)
    assert_allclose(found, [[10, 11, 12, 13, 14]], atol=0.51 * 4 / 255)


def test_the_picture_that_is_written_holds_both_years(rng):
    years = drawn_layers(rng, n_layers=3), drawn_layers(rng, n_layers=5)
    comparison = repeat_pass.compare(*years, SPACING)
    pictures = dict.fromkeys(("2011", "2012"), np.zeros((9, N_COLUMNS)))
    written = repeat_pass.picks_dataset(pictures, years, comparison)
    assert np.isfinite(written["row"]).any("column").sum("layer").values.tolist() == [3, 5]
    found = written["found"].sum("layer").values.tolist()
    assert found == [comparison.earlier.layers.sum(), comparison.later.layers.sum()]


def test_layers_of_the_real_pictures_are_found_in_both_years(shared_data):
    pytest.importorskip("onnxruntime")
    from match_repeat_pass import tracked

    from snowsim import Tracker

    tracker = Tracker.from_pretrained("universal")
    pictures = read_greenland(shared_data / "snow_radar")
    later, earlier = (tracked(tracker, means_db) for means_db in pictures.values())
    spacing = repeat_pass.median_spacing(earlier, later)
    comparison = repeat_pass.compare(earlier, later, spacing)
    rng = np.random.default_rng(1)
    controls = repeat_pass.control(earlier, later, spacing, 50, rng=rng)
    table = repeat_pass.repeat_table(comparison, controls, spacing)
    assert (table["n_layers"] >= 10).all()
    assert (table["share"] > table["control_high"]).all()


def test_without_real_pictures_the_target_is_refused_in_a_line_and_the_default_run_is_not(tmp_path):
    planned = parsed(tmp_path, targets=["all"])
    assert "match_repeat_pass" not in {job.rule.name for job in planned.dag.jobs}
    with pytest.raises(WorkflowError, match=r"real_snow_radar: expected a folder .*, got null"):
        parsed(tmp_path, targets=["repeat_pass"])


def test_the_figure_names_both_kinds_of_layers_and_has_both_years(rng):
    years = drawn_layers(rng, n_layers=6), drawn_layers(rng, n_layers=6)
    comparison = repeat_pass.compare(*years, SPACING)
    pictures = {year: rng.normal(-25, 1, (260, N_COLUMNS)) for year in ("2011", "2012")}
    written = repeat_pass.picks_dataset(pictures, years, comparison)
    first, second = figures.repeat_pass(written).axes
    assert (first.get_title(), second.get_title()) == ("2011", "2012")
    labels = [text.get_text() for text in second.get_legend().get_texts()]
    assert labels == ["in both years", "in this year alone"]
