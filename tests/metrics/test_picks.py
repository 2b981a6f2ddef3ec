from itertools import combinations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from snowsim.echogram import check_layer_bins, layer_mask
from snowsim.metrics.edges import suppress
from snowsim.metrics.picks import match_picks, pick_layers


def test_picks_of_a_blurred_and_suppressed_map_lie_within_a_bin(layer_bins):
    rows = np.arange(320)[:, None]
    ridges = sum(np.exp(-0.5 * ((rows - layer) / 2) ** 2) for layer in layer_bins)
    edges = suppress(ridges.clip(0, 1))
    picks = pick_layers(edges, threshold=0.3)
    assert picks.shape == layer_bins.shape
    assert np.nanmax(np.abs(picks - layer_bins)) < 1
    assert np.isfinite(picks).mean() > 0.9


def test_gaps_are_bridged_up_to_their_limit_and_layers_are_picked_at_their_rounded_bins(layer_bins):
    mask = layer_mask(layer_bins, 320)
    mask[:, 40:60] = False
    bridged = pick_layers(mask, threshold=0.5, max_gap_lines=20)
    assert bridged.shape == layer_bins.shape
    assert np.isnan(bridged[:, 40:60]).all()
    broken = pick_layers(mask, threshold=0.5, max_gap_lines=19)
    assert broken.shape[0] == 2 * layer_bins.shape[0]
    check_layer_bins(broken)
    layer_bins[3, :50] = np.nan
    layer_bins[5, 60:] = np.nan
    picks = pick_layers(layer_mask(layer_bins, 320), threshold=0.5)
    assert_array_equal(picks, np.rint(layer_bins))


def test_picks_never_cross_whatever_the_map_and_specks_are_dropped(rng):
    for share in (0.01, 0.05, 0.3):
        picks = pick_layers((rng.random((80, 60)) < share) * 0.9, threshold=0.5, min_lines=1)
        check_layer_bins(picks)
        assert picks.shape[0] > 10
    edges = np.zeros((50, 60))
    edges[20] = 1
    edges[35, 10:29] = 1
    assert pick_layers(edges, threshold=0.5, min_lines=20).shape == (1, 60)
    assert pick_layers(edges, threshold=0.5, min_lines=19).shape == (2, 60)
    assert pick_layers(np.zeros((50, 60)), threshold=0.5).shape == (0, 60)


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


def test_picks_of_single_precision_are_those_of_its_values_in_double():
    edges = np.random.default_rng(0).random((60, 40), dtype=np.float32)
    picks = pick_layers(edges, threshold=0.3, min_lines=1)
    expected = pick_layers(edges.astype(float), threshold=0.3, min_lines=1)
    assert_array_equal(picks, expected)


@pytest.mark.parametrize(
    ("picks", "max_distance_bins", "message"),
    [
        ([[5.0, 5.0], [4.0, 6.0]], 10, "picks: layers must increase strictly"),
        ([[5.0]], 10, "picks cover 1 range lines, the layers 2"),
        ([[5.0, 5.0]], 0, "max_distance_bins must be finite, above 0, got 0"),
    ],
)
def test_picks_that_cannot_be_matched_are_refused(picks, max_distance_bins, message):
    with pytest.raises(ValueError, match=message):
        match_picks(picks, [[5.0, 5.0]], max_distance_bins=max_distance_bins)
