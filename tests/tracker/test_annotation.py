import dataclasses

import numpy as np
import pytest
import torch
from numpy.testing import assert_array_equal
from toy_scenes import toy_scene

from snowsim.tracker import Settings, Training, TrainingSet, annotated_pixels, train_steps
from snowsim.tracker.loss import balanced_cross_entropy


@pytest.fixture
def picked():
    """A scene of two level layers, bins 20 and 50.

    The lower one is picked on lines 10 to 39 of 64.
    """
    complete = np.array([[20.0], [50.0]]) * np.ones(64)
    layer_bins = complete.copy()
    layer_bins[1, :10] = layer_bins[1, 40:] = np.nan
    return dataclasses.replace(toy_scene(1), layer_bins=layer_bins, complete_layer_bins=complete)


def test_gaps_and_all_below_the_deepest_pick_are_unknown_but_where_another_layer_is_picked(picked):
    known = annotated_pixels(picked, picked.layer_bins, 96)
    expected = np.ones((96, 64), dtype=bool)
    expected[59:] = False  # deeper than 50 + 8
    expected[42:59, :10] = expected[42:59, 40:] = False
    assert_array_equal(known, expected)
    # A scene without a complete annotation beside its own is complete itself.
    scene = dataclasses.replace(picked, complete_layer_bins=None)
    assert annotated_pixels(scene, scene.layer_bins, 96).all()
    picked.layer_bins[1, 10:40] = 25
    known = annotated_pixels(picked, picked.layer_bins, 96)
    assert known[20].all()
    assert not known[25, :10].any()


def test_unknown_pixels_neither_cost_nor_count(rng):
    masks = torch.from_numpy(rng.random((2, 8, 9)) < 0.2)
    logits = torch.from_numpy(rng.normal(0, 2, (6, 2, 1, 8, 9)).astype(np.float32))
    known = torch.ones(2, 8, 9, dtype=torch.bool)
    known[:, 5:] = False
    # The same as if the unknown rows were not there: sums of the same 45 terms.
    cut = balanced_cross_entropy(logits[..., :5, :], masks[:, :5])
    torch.testing.assert_close(balanced_cross_entropy(logits, masks, known), cut, rtol=1e-6, atol=0)


def test_masking_changes_the_training_of_partial_scenes_alone(picked):
    settings = Settings(width=2, n_steps=2, n_range_bins=64, n_range_lines=48)
    masked = dataclasses.replace(settings, mask_unannotated=True)

    def losses(scene, chosen):
        return [
            step for _, step in train_steps(Training(chosen, seed=1), TrainingSet([scene], seed=1))
        ]

    assert losses(picked, settings) != losses(picked, masked)
    complete = dataclasses.replace(
        picked, layer_bins=picked.complete_layer_bins, complete_layer_bins=None
    )
    assert losses(complete, settings) == losses(complete, masked)
