import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from lib.completed_picks import completed
from snowsim.echogram import Scene
from snowsim.tracker import pick_layers


@pytest.fixture
def scene():
    """Three layers of 100 range lines in 120 rows; the second has picks on 40 lines alone."""
    layer_bins = np.repeat([[20.0], [50.0], [80.0]], 100, axis=1).astype(np.float32)
    layer_bins[1, 40:] = np.nan
    return Scene("planted", 120, layer_bins)


def followed(rows):
    """Layers that a tracker follows that is sure of some (row, first line, end)."""
    probability = np.zeros((120, 100))
    for row, first, last in rows:
        for distance, value in ((0, 0.9), (1, 0.5), (-1, 0.5)):
            probability[row + distance, first:last] = value
    return pick_layers(probability, threshold=0.3)


def test_layers_are_added_where_nobody_picked_and_picks_stay_where_they_are_right(scene):
    # The surface, what is left of the second layer, one that nobody picked, one in the air.
    found = followed([(20, 0, 100), (50, 0, 100), (65, 10, 90), (5, 0, 100)])
    found = completed(scene, found).layer_bins
    # By depth; the new piece of the second layer is a layer of its own, at the same depth.
    assert len(found) == 5
    # A tracker's bins are parabolas' vertices, in float32.
    assert_allclose(found[[0, 1, 4]], scene.layer_bins, atol=1e-3)
    lines = np.arange(100)
    assert_array_equal(np.isfinite(found[2]), lines >= 40)
    assert np.nanmax(np.abs(found[2] - 50)) < 0.5
    lines = np.flatnonzero(np.isfinite(found[3]))
    assert abs(lines[0] - 10) <= 1
    assert abs(lines[-1] - 89) <= 1
    assert np.abs(found[3, lines] - 65).max() < 0.5


def test_what_lies_beside_a_pick_or_is_short_is_no_layer_of_its_own(scene):
    found = followed([(83, 0, 100), (65, 10, 40), (95, 0, 12)])
    found = completed(scene, found).layer_bins
    assert len(found) == 4  # with the one of 30 lines
    nothing = completed(scene, followed([])).layer_bins
    assert_array_equal(nothing, scene.layer_bins)


def test_picks_move_to_the_layer_that_the_tracker_finds_near_them(scene):
    found = followed([(20, 0, 100), (53, 0, 30), (75, 0, 100)])
    found = completed(scene, found).layer_bins
    # Three bins off it moves; beyond where the tracker finds it, and five bins off, it stays.
    assert_allclose(found[1, 3:29], 53, atol=0.5)
    assert_array_equal(found[1, 31:40], 50)
    assert np.isnan(found[1, 40:]).all()
    deep = found[np.nanmean(found, axis=1) > 70]
    assert_allclose(np.nanmean(deep, axis=1), [75, 80], atol=0.1)
