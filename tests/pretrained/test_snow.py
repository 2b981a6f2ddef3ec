"""Accumulation by picks against that of true horizons, and the baseline."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from toy_scenes import toy_scenes

from pretrained.scores import Picks, followed, pick_scores
from pretrained.snow import (
    UNTRAINED,
    Snow,
    baseline_logits,
    ridge_logits,
    scored_snow,
    snow_of_climate,
)

pytestmark = pytest.mark.filterwarnings("ignore:layers. snow of:UserWarning")


@pytest.fixture(scope="module")
def snows():
    """Two scenes of twenty annual layers, whose masses are known."""
    return snow_of_climate(0.4, 1, 2)


def true_picks(scene):
    below = scene.layer_bins[1:]
    return Picks(below, np.full(below.shape, 0.9))


def test_true_horizons_give_the_mass_that_was_simulated(snows):
    found = scored_snow("climate", snows, "true", true_picks)
    assert found["f"] > 0.95  # all but the surface, which is not among them
    # The climate's mean of .4 is not that of these years, on which density depends: some per cent.
    assert abs(found["bias"]) < 0.02
    assert found["inside"] > 0.9
    assert found["given"] > 0.9
    # Without known masses the truth is converted as the picks are.
    converted = scored_snow("c", [Snow(s.scene, s.bin_s) for s in snows], "true", true_picks)
    # A table of 500 depths is interpolated.
    assert_allclose(converted["bias"], 0, atol=1e-6)
    assert converted["inside"] == 1


def test_horizons_that_are_missed_are_counted_or_flagged(snows):
    def missing(scene):
        picks = true_picks(scene)
        return Picks(np.delete(picks.bins, [4, 9], 0), np.delete(picks.sure, [4, 9], 0))

    found = scored_snow("climate", snows, "missing", missing)
    assert found["given"] > 0.9
    assert found["wrong"] < 0.15
    assert abs(found["bias"]) < 0.03


@pytest.mark.parametrize("logits_of", [baseline_logits, ridge_logits])
def test_picks_without_training_are_the_bright_rows(logits_of):
    scenes = toy_scenes(2)
    picks = [followed(logits_of(s.image), UNTRAINED, s.image.shape) for s in scenes]
    assert pick_scores(picks, scenes)["f"] > 0.5


def test_without_two_picks_on_a_line_there_is_no_accumulation(snows):
    def nothing(scene):
        empty = np.empty((0, scene.layer_bins.shape[1]))
        return Picks(empty, empty)

    found = scored_snow("climate", snows, "nothing", nothing)
    assert found["given"] == 0
