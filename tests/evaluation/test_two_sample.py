"""The two-sample test, on planted answers."""

from functools import partial

import numpy as np
from numpy.testing import assert_allclose, assert_array_equal
from refusals import refusal

from evaluation.lib.two_sample import PATCH, accuracy, decisions, two_sample_table
from snowsim.echogram import Scene, to_uint8
from snowsim.seeding import random_stream

N_SCENES = 60
SHAPE = (146, 64)  # of two patches, one below the other


def speckled(rng, n_looks=16):
    """A scene of a surface and of snow without layers."""
    power = np.ones(SHAPE)
    power[50:] = 30
    image, *_ = to_uint8(power * rng.gamma(n_looks, 1 / n_looks, SHAPE))
    return Scene("scene", SHAPE[0], np.full((1, SHAPE[1]), 50.0), image)


def test_every_scene_is_classified_once_and_by_what_saw_none_of_it():
    one = np.arange(7).reshape(7, 1, 1, 1, 1) * np.ones((2, 3, PATCH, PATCH))
    other = one + 10

    def fit(patches, truth):
        numbers = patches[:, 0, 0]
        assert_array_equal(truth, numbers >= 10)
        return lambda of: np.isin(of[:, 0, 0], numbers)  # True would be a patch seen before

    right = decisions(one, other, n_splits=3, fit=fit)
    assert [side.shape for side in right] == [(7, 2, 3)] * 2
    # Nothing is recognised, which is the right answer for the class of False alone.
    assert right[0].all()
    assert not right[1].any()


def test_shares_come_back_by_scene_and_by_row_with_an_interval_over_scenes(rng):
    found, low, high = accuracy([np.repeat([0.0, 1.0], 50), np.full(100, 0.75)], rng=rng)
    assert found == 0.625
    # Half of the scatter of the share of 100 scenes, 0.05: an interval of 1.96 of these on either
    # side. 500 resamples know a percentile to 0.12 of the scatter; allow four of those.
    assert abs((high - low) / 2 - 1.96 * 0.025) < 4 * 0.12 * 0.025


def test_scenes_of_one_kind_are_not_distinguished_and_those_of_fewer_looks_are(rng):
    sets = {
        "observed": [speckled(rng) for _ in range(N_SCENES)],
        "phy": [speckled(rng) for _ in range(N_SCENES)],
        "cgan": [speckled(rng, n_looks=4) for _ in range(N_SCENES)],
    }
    stream = partial(random_stream, 1)
    table = two_sample_table(sets, n_splits=2, n_steps=40, stream=stream)
    whole = table[table["first_row"] < 0].set_index("scenes")
    # All patches of a scene may be decided alike, so scenes count: at worst a share of theirs
    # scatters by 0.5 / sqrt(n) about 0.5. Allow four of those: 0.18 and 0.26.
    for name, n_scenes in {"phy": 2 * N_SCENES, "observed": N_SCENES}.items():
        assert whole.loc[name, "n_scenes"] == n_scenes
        assert abs(whole.loc[name, "accuracy"] - 0.5) < 4 * 0.5 / np.sqrt(n_scenes)
    assert whole.loc["cgan", "accuracy"] > 0.95
    by_row = table[table["scenes"] == "cgan"].set_index("first_row")["accuracy"]
    assert_allclose(by_row[[18, 82]].mean(), by_row[-1])


def test_few_scenes_are_no_obstacle_and_ones_smaller_than_a_patch_are_refused(rng):
    scenes = [speckled(rng) for _ in range(2)]
    few = {"observed": scenes, "phy": scenes}
    table = two_sample_table(few, n_splits=5, n_steps=1, stream=partial(random_stream, 1))
    assert table.groupby("scenes")["accuracy"].count().to_dict() == {"observed": 0, "phy": 3}
    low = [Scene("low", 80, scene.layer_bins, scene.image[:80]) for scene in scenes]
    message = "expected scenes of 82 x 64 pixels or more, the smallest has 80 x 64"
    with refusal(message):
        two_sample_table({"observed": scenes, "phy": low}, n_splits=2, n_steps=1, stream=None)
