from dataclasses import replace

import numpy as np
import pytest
import torch
from numpy.testing import assert_allclose
from scipy.special import expit
from toy_scenes import toy_scene
from trainings import trained

from snowsim.tracker import Settings, balanced_cross_entropy, rate_factor, track

TINY = Settings(width=2, n_steps=6, n_range_bins=64, n_range_lines=48)


def test_the_loss_falls_and_the_fuse_separates_layers_from_background_on_an_unseen_scene():
    settings = replace(TINY, width=4, n_steps=200, learning_rate=5e-3)
    training, losses = trained(settings, n_scenes=8)
    fuse = [step["fuse"] for step in losses]
    assert np.mean(fuse[-20:]) < 0.4 * np.mean(fuse[:5])
    scene = toy_scene(99)
    fuse = track(training.network, scene.image)[5]
    on, off = fuse[scene.mask()], fuse[~scene.mask()]
    # The chance that a layer pixel outranks one of the background: 0.5 when nothing was learnt.
    ranks = np.searchsorted(np.sort(off), on)
    assert ranks.mean() / off.size > 0.95


@pytest.mark.parametrize("share", [None, 0.02])
def test_the_loss_is_the_textbook_sum(share, rng):
    masks = rng.random((3, 8, 9)) < 0.2
    logits = rng.normal(0, 3, (6, 3, 1, 8, 9))
    masks[2] = False
    probability = expit(logits[:, :, 0])
    positive = masks.mean(axis=(1, 2), keepdims=True) if share is None else share
    layer = (1 - positive) * masks * np.log(probability)
    ground = positive * ~masks * np.log(1 - probability)
    expected = -(layer + ground).sum(axis=(1, 2, 3)) / 3
    got = balanced_cross_entropy(
        torch.from_numpy(logits), torch.from_numpy(masks), layer_share=share
    )
    assert_allclose(got.numpy(), expected, rtol=1e-5)  # float32 sums of 72 terms


def test_the_rate_rises_over_a_tenth_of_the_steps_and_falls_to_zero():
    cycle = [rate_factor(replace(TINY, n_steps=1000), step) for step in range(1000)]
    assert_allclose(cycle[:100], np.arange(1, 101) / 100, rtol=1e-12)
    assert (np.diff(cycle[99:]) < 0).all()
    assert cycle[-1] == 0
