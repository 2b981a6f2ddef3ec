from dataclasses import replace

import numpy as np
import pytest
import torch
from numpy.testing import assert_allclose
from toy_scenes import toy_scene
from trainings import trained

from snowsim.tracker import OUTPUTS, Settings, Training, published_settings, track
from snowsim.tracker.loss import balanced_cross_entropy
from snowsim.tracker.published import published_rate
from snowsim.tracker.train import rate_factor

TINY = Settings(width=2, n_steps=6, n_range_bins=64, n_range_lines=48)


@pytest.fixture(scope="module")
def learnt():
    return trained(replace(TINY, width=4, n_steps=200, learning_rate=5e-3), n_scenes=8)


def test_the_loss_falls_and_the_fuse_separates_layers_from_background_on_an_unseen_scene(learnt):
    losses = {name: [step[name] for step in learnt[1]] for name in OUTPUTS}
    for name in ("side_1", "side_2", "side_3", "side_4", "fuse"):
        at_first = np.mean(losses[name][:5])
        assert np.mean(losses[name][-20:]) < 0.8 * at_first, name
    at_first = np.mean(losses["fuse"][:5])
    assert np.mean(losses["fuse"][-20:]) < 0.4 * at_first
    scene = toy_scene(99)
    fuse = track(learnt[0].network, scene.image)[5]
    on, off = fuse[scene.mask()], fuse[~scene.mask()]
    # The chance that a layer pixel outranks one of the background: 0.5 when nothing was learnt.
    ranks = np.searchsorted(np.sort(off), on)
    assert ranks.mean() / off.size > 0.95


@pytest.mark.parametrize("share", [None, 0.02])
def test_the_loss_is_the_textbook_sum(share, rng):
    masks = rng.random((3, 8, 9)) < 0.2
    logits = rng.normal(0, 3, (6, 3, 1, 8, 9))
    expected = np.zeros(6)
    masks[2] = False
    for output in range(6):
        for mask, logit in zip(masks, logits[output, :, 0], strict=True):
            probability = 1 / (1 + np.exp(-logit))
            weight = ((~mask).mean(), mask.mean()) if share is None else (1 - share, share)
            expected[output] -= weight[0] * np.log(probability[mask]).sum() / 3
            expected[output] -= weight[1] * np.log(1 - probability[~mask]).sum() / 3
    got = balanced_cross_entropy(
        torch.from_numpy(logits), torch.from_numpy(masks), layer_share=share
    )
    assert_allclose(got.numpy(), expected, rtol=1e-5)  # float32 sums of 72 terms


def test_published_rates_are_multiplied_as_in_the_published_code():
    training = Training(published_settings(n_steps=6, width=2, n_accumulated=4), seed=1)
    groups = {
        id(parameter): group
        for group in training._optimiser.param_groups
        for parameter in group["params"]
    }
    of_each = {
        name: groups[id(parameter)] for name, parameter in training.network.named_parameters()
    }
    rates = {name: (group["lr"], group["weight_decay"]) for name, group in of_each.items()}
    assert rates["stages.0.0.weight"] == (1e-6, 2e-4)
    assert rates["stages.0.0.bias"] == (2e-6, 0)
    assert rates["stages.4.2.weight"][0] == pytest.approx(1e-4)
    assert rates["stages.4.2.bias"] == pytest.approx((2e-4, 2e-4))  # its key is misspelt there
    assert rates["sides.3.weight"][0] == pytest.approx(1e-8)
    assert rates["fuse.bias"][0] == pytest.approx(2e-9)


def test_schedules_are_the_stated_ones():
    steps = published_settings(n_steps=300_000)
    rates = [published_rate(steps, update, epoch=14) for update in (0, 9_999, 10_000, 20_000)]
    assert rates == pytest.approx([1, 1, 0.1, 0.01])
    by_epoch = replace(steps, n_epochs_per_tenth=3)
    rates = [published_rate(by_epoch, 20_000, epoch) for epoch in (0, 2, 3, 6)]
    assert rates == pytest.approx([1, 1, 0.1, 0.01])
    cycle = [rate_factor(replace(TINY, n_steps=1000), step) for step in range(1000)]
    assert_allclose(cycle[:100], np.arange(1, 101) / 100, rtol=1e-12)
    assert (np.diff(cycle[99:]) < 0).all()
    assert cycle[-1] == 0
