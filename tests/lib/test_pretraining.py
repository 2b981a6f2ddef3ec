"""What the shipped tracker is trained on: scenes of variants, under bands that are no layers."""

import numpy as np
import pytest
from numpy.testing import assert_array_equal
from runs import CONFIG

from lib.pretraining import banded, scores_for_card, varied_scenes
from snowsim.front import REFERENCE
from snowsim.io.files import read_dataset
from snowsim.patches import check_trainable


@pytest.fixture(scope="module")
def flight():
    return read_dataset(REFERENCE)


def drawn(flight, variants, n_scenes):
    given = {"n_range_lines": 64, "phy": CONFIG["phy"], "seed": 1}
    return list(varied_scenes(flight, variants, n_scenes, **given))


def test_scenes_of_a_variant_do_not_depend_on_which_others_are_drawn(flight):
    together = drawn(flight, range(3), 2)
    names = [f"variant_{variant:03d}_{number:03d}" for variant in range(3) for number in range(2)]
    assert [scene.name for scene in together] == names
    for alone, scene in zip(drawn(flight, [2], 1), together[4:], strict=False):
        assert_array_equal(alone.image, scene.image)
        assert_array_equal(alone.layer_bins, scene.layer_bins)
    for scene in together:
        check_trainable(scene)


def decibels(scene):
    """Power of every pixel [dB]."""
    bottom_db = scene.noise_floor_db - 10
    return bottom_db + scene.image / 255 * (scene.maximum_db - bottom_db)


def test_bands_lie_across_the_image_and_leave_layers_where_they_are(flight):
    scene = drawn(flight, [0], 1)[0]
    n_brighter = 0
    for seed in range(20):
        # 1e4 looks: the same power as the mean.
        other = banded(scene, 1e4, rng=np.random.default_rng(seed))
        assert_array_equal(other.layer_bins, scene.layer_bins)
        assert other.image.shape == scene.image.shape
        change_db = decibels(other) - decibels(scene)
        # Power is added: where either is clipped nothing can be said, and rounding is half a level
        # of 0.3 dB in each.
        seen = (scene.image > 0) & (other.image > 0)
        assert change_db[seen].min() > -0.4
        n_brighter += (np.median(change_db, axis=1) > 1).any()
    # Bands are weak in many scenes and none in some: chance leaves a few of twenty.
    assert n_brighter >= 3


def test_scores_of_the_card_are_those_of_the_shipped_tracker(tmp_path):
    table = tmp_path / "transfer.csv"
    names = "flight,tracker,ods,recall,precision,f,missed_share,false_share"
    table.write_text(f"{names}\na,universal,.81234,.5,.5,.5,.1,.2\na,rd,.7,.5,.5,.5,.1,.2\n")
    scores = scores_for_card({str(table): "digest"})
    assert [row["flight"] for row in scores] == ["a"]
    assert scores[0]["ods"] == 0.812
    assert scores_for_card({}) is None
