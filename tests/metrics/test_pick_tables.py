"""Rows of picks pool to what the scores of a scene say, and planted errors come back by zone and depth."""

import numpy as np
import pandas as pd
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from snowsim.constants import SPEED_OF_LIGHT_M_S
from snowsim.metrics.pick_tables import layer_rows, pool_picks, snow_per_bin_m, zone_of
from snowsim.metrics.picks import score_picks


def draw_scene(rng, n_layers=8, n_lines=60):
    """Level layers 25 bins apart, some range lines absent, and noisy picks of all but one, with one false layer."""
    layer_bins = 50 + 25 * np.arange(n_layers)[:, None] + rng.uniform(-2, 2, (n_layers, n_lines))
    layer_bins[rng.random(layer_bins.shape) < 0.1] = np.nan
    picks = layer_bins + rng.normal(0, 1.5, layer_bins.shape)
    picks[5] = np.nan
    picks[rng.random(picks.shape) < 0.2] = np.nan
    return np.vstack([picks, np.full(n_lines, 400.0)]), layer_bins


def test_one_scene_pools_to_its_scores(rng):
    picks, layer_bins = draw_scene(rng)
    pooled = pool_picks(layer_rows(picks, layer_bins).assign(all=1), ["all"], bin_size_m=0.03).iloc[0]
    scores = score_picks(picks, layer_bins, bin_size_m=0.03)
    for name in set(pooled.index) & set(scores):
        assert_allclose(pooled[name], scores[name], err_msg=name)
    assert pooled["n_missed_layers"] == pooled["n_false_layers"] == 1
    assert_allclose(pooled["share_found"], scores["n_found"] / scores["n_true"])


def test_scenes_pool_by_pixel_and_not_by_scene(rng):
    truth = np.array([[50.0], [80.0]]) * np.ones(100)
    short = truth.copy()
    short[:, 10:] = np.nan
    rows = pd.concat([layer_rows(truth + 1, truth), layer_rows(short + 2, short)]).assign(set="a")
    pooled = pool_picks(rows, ["set"], bin_size_m=0.03).iloc[0]
    assert_allclose(pooled["mean_absolute_error_bins"], (200 * 1 + 20 * 2) / 220)
    assert_allclose(pooled["bias_m"], (200 * 1 + 20 * 2) / 220 * 0.03)
    assert pooled["thickness_mean_absolute_error_bins"] == 0


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
    truth = np.array([[50.0], [80.0]]) * np.ones(40)
    pooled = pool_picks(layer_rows(np.empty((0, 40)), truth).assign(a=1), ["a"], bin_size_m=0.03).iloc[0]
    assert np.isnan(pooled["mean_absolute_error_bins"])
    assert (pooled["share_found"], pooled["n_missed_layers"]) == (0, 2)


def test_zones_are_the_flight_s_quartiles_open_at_both_ends():
    edges = [10, 13, 16, 20, 30]
    assert_array_equal(zone_of([5, 10, 12.9, 13, 18, 20, 99, np.nan], edges), [0, 0, 0, 1, 2, 3, 3, -1])


def test_a_bin_of_snow_is_thinner_than_a_bin_of_air():
    assert_allclose(snow_per_bin_m(2.886e-10, 0), SPEED_OF_LIGHT_M_S * 2.886e-10 / 2)
    # 4.33 cm in air (2012 product); index 1.2873 at 340 kg m-3.
    assert_allclose(snow_per_bin_m(2.886e-10, 340), 0.0433 / 1.2873, rtol=2e-3)


def test_bad_input_is_refused():
    with pytest.raises(ValueError, match="expected the snow surface"):
        layer_rows(np.ones((1, 4)), np.array([[np.nan] * 4, [9.0] * 4]))
    with pytest.raises(ValueError, match="expected rows of picks"):
        pool_picks(layer_rows(np.ones((1, 4)), np.ones((1, 4))).iloc[:0], ["layer"], bin_size_m=0.03)
