import dataclasses
from collections import Counter

import numpy as np
import pytest
from refusals import refusal
from toy_scenes import toy_scenes

from snowsim.tracker import Completed, TrainingSet


class Numbered(list):
    """A sequence of so many scenes that counts what was read."""

    def __init__(self, name, n):
        super().__init__((name, item) for item in range(n))
        self.read = Counter()

    def __getitem__(self, item):
        self.read[item] += 1
        return super().__getitem__(item)


def first(scenes, n):
    return [scenes.source(position) for position in range(n)]


def test_fewer_real_scenes_keep_the_share_and_still_use_all_of_the_added_sets():
    scenes = TrainingSet(
        Numbered("real", 118), [Numbered("phy", 1500), Numbered("cgan", 1500)], seed=1
    )
    assert scenes.n_per_epoch == 118 + 75 + 75
    drawn = first(scenes, 20 * scenes.n_per_epoch)
    for epoch in range(20):
        of_epoch = drawn[epoch * scenes.n_per_epoch : (epoch + 1) * scenes.n_per_epoch]
        assert Counter(number for number, _ in of_epoch) == {0: 118, 1: 75, 2: 75}
        assert len(set(of_epoch)) == len(of_epoch)
    for number in (1, 2):
        # 20 epochs of 75 are all 1500, each once.
        assert sorted(scene for which, scene in drawn if which == number) == list(range(1500))


def test_the_order_depends_on_the_seed_alone_scenes_are_read_when_drawn_and_real_ones_once():
    real, added = Numbered("real", 6), Numbered("added", 100)
    scenes, again, other = (
        TrainingSet(real, [added], added_per_real=0.5, seed=seed) for seed in (1, 1, 2)
    )
    assert first(scenes, 200) == first(again, 200) != first(other, 200)
    assert not real.read
    shown = [scenes[position] for position in range(5 * scenes.n_per_epoch)]
    drawn = first(scenes, 5 * scenes.n_per_epoch)
    expected = [(which == 1, number) for which, number in drawn]
    assert [(name == "added", number) for name, number in shown] == expected
    assert set(real.read.values()) == {1}
    assert sum(added.read.values()) == 15


@pytest.mark.parametrize(
    ("real", "added", "words"),
    [(5, [3, 0], "scenes of a set must"), (1, [9], "added scenes an ep")],
)
def test_sets_without_scenes_are_refused(real, added, words):
    with refusal(words):
        TrainingSet(
            Numbered("real", real), [Numbered("a", n) for n in added], added_per_real=0.4, seed=1
        )


def test_completed_scenes_show_every_layer():
    part, whole = toy_scenes(2)
    part = dataclasses.replace(part, complete_layer_bins=part.layer_bins.copy())
    part.layer_bins[2:] = np.nan
    completed = Completed([part, whole])
    assert len(completed) == 2
    assert np.isfinite(completed[0].layer_bins).all()
    assert completed[0].complete_layer_bins is None
    assert completed[1] is whole
