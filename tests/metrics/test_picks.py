from itertools import combinations

import numpy as np
import pandas as pd
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from refusals import refusal

from snowsim.constants import SPEED_OF_LIGHT_M_S
from snowsim.echogram import zone_of
from snowsim.metrics.picks import layer_rows, match_picks, pool_picks, snow_per_bin_m


def best_saving(true, found, reach):
    """Most that any order-keeping assignment saves, by enumeration."""
    best = 0.0
    for n in range(1, min(len(true), len(found)) + 1):
        for layers in combinations(range(len(true)), n):
            for picks in combinations(range(len(found)), n):
                distance = np.abs(true[list(layers)] - found[list(picks)])
                if (distance < reach).all():
                    best = max(best, (reach - distance).sum())
    return best


def test_assignment_is_the_best_of_all_that_keep_the_order(rng):
    for _ in range(60):
        true, found = (np.sort(rng.uniform(0, 40, rng.integers(1, 6))) for _ in range(2))
        error, used = match_picks(found[:, None], true[:, None], max_distance_bins=8)
        kept = np.isfinite(error)
        assert kept.sum() == used.sum()
        assert_allclose((8 - np.abs(error[kept])).sum(), best_saving(true, found, 8), atol=1e-9)


@pytest.mark.parametrize(
    ("picks", "message"),
    [
        ([[5.0, 5.0], [4.0, 6.0]], "picks: layers must increase strictly"),
        ([[5.0]], "picks cover 1 range lines, the layers 2"),
    ],
)
def test_picks_that_cannot_be_matched_are_refused(picks, message):
    with refusal(message):
        match_picks(picks, [[5.0, 5.0]])


def pooled(*rows):
    """Errors of tables of scenes."""
    return pool_picks(pd.concat(rows).assign(all=1), ["all"], bin_size_m=0.03).iloc[0]


def test_missed_and_false_layers_are_counted(layer_bins):
    picks = np.vstack([layer_bins, np.full((1, 120), 300.0)])  # 300 lies below every layer's reach
    picks[4] = np.nan
    picks[6, :61] = np.nan
    picks[7, :60] = np.nan
    rows = layer_rows(picks, layer_bins)
    scores = pooled(rows)
    assert scores["n_layers"] == 8
    assert scores["n_missed_layers"] == 2  # the absent one and the one with 59 of 120 range lines
    assert scores["n_false_layers"] == 1
    assert_allclose(scores["share_found"], (8 * 120 - 120 - 61 - 60) / (8 * 120))
    assert rows["n_picks"].sum() == 120
    assert scores["mean_absolute_error_bins"] == 0
    # A slab counts where both of its bounds have a pick: three whole slabs above layer 4, one below
    # it, one in part.
    assert rows["n_thickness"].sum() == 3 * 120 + 59 + 59


@pytest.mark.parametrize(("off_bins", "n_within"), [(-2.0, 9), (2.0, 9), (2.001, 0)])
def test_an_error_of_the_limit_itself_is_within_it(off_bins, n_within):
    layer_bins = np.repeat([[20.0], [40.0], [64.0]], 3, axis=1)  # sums are exact
    rows = layer_rows(layer_bins + off_bins, layer_bins, within_bins=2.0)
    assert rows["n_within"].sum() == n_within


def test_scenes_pool_by_pixel_and_not_by_scene():
    truth = np.array([[50.0], [80.0]]) * np.ones(100)
    short = truth.copy()
    short[:, 10:] = np.nan
    both = pooled(layer_rows(truth + 1, truth), layer_rows(short + 2, short))
    mean_bins = (200 * 1 + 20 * 2) / 220
    assert_allclose(both["mean_absolute_error_bins"], mean_bins)
    assert_allclose(both["bias_m"], mean_bins * 0.03)
    assert both["thickness_mean_absolute_error_bins"] == 0


def test_errors_stay_with_the_depth_they_were_planted_at():
    truth = np.array([[50.0], [80.0], [110.0]]) * np.ones(40)
    picks = truth + np.array([[0.0], [1.0], [3.0]])
    rows = layer_rows(picks, truth)
    assert_array_equal(rows["layer"], [0, 1, 2])
    assert_allclose(rows["depth_bins"], [0, 30, 60])
    assert_allclose(rows["absolute_error"] / rows["n_found"], [0, 1, 3])
    assert_allclose(rows["thickness_error"], [0, 40, 80])
    assert_array_equal(rows["n_within"], [40, 40, 0])


def test_groups_without_picks_are_nan_and_miss_their_layers():
    scores = pooled(layer_rows(np.empty((0, 40)), np.array([[50.0], [80.0]]) * np.ones(40)))
    assert np.isnan(scores["mean_absolute_error_bins"])
    assert (scores["share_found"], scores["n_found"], scores["n_missed_layers"]) == (0, 0, 2)


def test_zones_are_quartiles_open_at_both_ends_and_a_bin_of_snow_is_thinner_than_of_air():
    edges = [10, 13, 16, 20, 30]
    thickness_bins = [5, 10, 12.9, 13, 18, 20, 99, np.nan]
    assert_array_equal(zone_of(thickness_bins, edges), [0, 0, 0, 1, 2, 3, 3, -1])
    assert_allclose(snow_per_bin_m(2.886e-10, 0), SPEED_OF_LIGHT_M_S * 2.886e-10 / 2)
    # 4.33 cm in air (2012 product); index 1.2873 at 340 kg m-3.
    assert_allclose(snow_per_bin_m(2.886e-10, 340), 0.0433 / 1.2873, rtol=2e-3)
