"""What the shipped tracker is trained on: scenes of variants of the flight."""

import pytest
from numpy.testing import assert_array_equal
from runs import CONFIG

from lib.pretraining import scores_for_card, varied_scenes
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


def test_scores_of_the_card_are_those_of_the_shipped_tracker(tmp_path):
    table = tmp_path / "transfer.csv"
    names = "flight,tracker,ods,recall,precision,f,missed_share,false_share"
    table.write_text(f"{names}\na,universal,.81234,.5,.5,.5,.1,.2\na,rd,.7,.5,.5,.5,.1,.2\n")
    scores = scores_for_card({str(table): "digest"})
    assert [row["flight"] for row in scores] == ["a"]
    assert scores[0]["ods"] == 0.812
    assert scores_for_card({}) is None
