"""The published recipe equals the published code, written again in `published_code`."""

from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
import published_code
import pytest
import torch
import yaml
from numpy.testing import assert_allclose
from refusals import refusal
from snakemake.utils import update_config
from toy_scenes import toy_scene, toy_scenes

from lib.configuration import filled
from lib.tracker_training import compose
from snowsim.tracker import (
    OUTPUTS,
    Settings,
    Training,
    TrainingSet,
    copy_shown,
    published_settings,
    train_steps,
)

CONFIG = Path(__file__).parents[2] / "config"
SCALES = (1.0, 0.75, 0.5, 0.25, 0.6, 0.35)
# Rates and decay that let 60 gradients of a network of width 4 move every weight far beyond
# rounding.
RECIPE = published_settings(
    60,
    width=4,
    n_accumulated=10,
    n_steps_per_tenth=2,
    scales=SCALES,
    learning_rate=1e-5,
    weight_decay=20,
)


def unlike_scenes():
    """Two scenes of sizes that 16 does not divide, the second without a layer."""
    first, second = toy_scene(1, 101, 71), toy_scene(2, 83, 57)
    return [first, replace(second, layer_bins=np.full_like(second.layer_bins, np.nan))]


def items_of_epochs(scenes, draws, seed):
    """What `RECIPE` shows, epoch by epoch, made by the other code."""
    transforms = [*SCALES, "fliplr"]
    items = []
    for position in range(RECIPE.n_steps):
        draw, copy = copy_shown(position, len(scenes), len(transforms), seed)
        scene = scenes[draws.source(draw)[1]]
        contour = np.uint8(255) * scene.mask()
        items.append(published_code.copy_of(scene.image, contour, transforms[copy]))
    return [items[first : first + 14] for first in range(0, RECIPE.n_steps, 14)]


@pytest.mark.parametrize("step_by_epoch", [False, True])
def test_losses_and_weights_equal_those_of_the_published_code(step_by_epoch):
    scenes, seed = unlike_scenes(), 5
    recipe = replace(RECIPE, n_epochs_per_tenth=2 if step_by_epoch else None)
    draws = TrainingSet(scenes, seed=seed)
    training = Training(recipe, seed=seed)
    net = published_code.Net(4)
    with torch.no_grad():
        for ours, theirs in zip(training.network.parameters(), net.parameters(), strict=True):
            theirs.copy_(ours)
    before = [p.clone() for p in net.parameters()]
    found = [losses for _, losses in train_steps(training, draws)]
    epochs = items_of_epochs(scenes, draws, seed)
    assert [len(items) for items in epochs] == [14, 14, 14, 14, 4]
    expected = published_code.train(
        net,
        epochs,
        lr=RECIPE.learning_rate,
        decay=RECIPE.weight_decay,
        momentum=0.9,
        itersize=10,
        stepsize=2,
        step_by_epoch=step_by_epoch,
    )
    n_pixels = np.array([image.numel() for items in epochs for image, _ in items])
    got = np.array([[losses[name] for name in OUTPUTS] for losses in found]) * n_pixels[:, None]
    # Float32 sums over up to 7e3 pixels in another order: 20 times their 6e-8.
    assert_allclose(got, expected, rtol=1.2e-6)
    assert (np.array(expected) == 0).any()
    named = training.network.named_parameters()
    for (name, ours), theirs, start in zip(named, net.parameters(), before, strict=True):
        # Every weight has moved by several times its own rounding, most by 1e4 times; it agrees to
        # a bit or two.
        moved = (theirs - start).abs().max().item()
        atol = 2 * torch.finfo().eps * start.abs().max().item() + 1e-5 * moved
        assert moved > 5 * atol, name
        assert_allclose(ours.detach(), theirs.detach(), rtol=0, atol=atol, err_msg=name)


def test_an_epoch_shows_every_copy_of_its_scenes_once():
    n, n_copies = 6, published_settings(1).n_copies
    assert n_copies == 5
    second_epoch = range(n * n_copies, 2 * n * n_copies)
    shown = [copy_shown(position, n, n_copies, seed=1) for position in second_epoch]
    assert sorted(shown) == list(product(range(n, 2 * n), range(n_copies)))
    assert shown != sorted(shown)


def test_first_weights_follow_the_law_of_pytorch_s():
    network = Training(published_settings(1, width=32), seed=1).network
    published = published_code.Net(32)
    for ours, theirs in zip(network.parameters(), published.parameters(), strict=True):
        n = ours.numel()
        if n > 1000:
            # Uniform: the sd of n values' sd about its mean is sqrt(.2 / n) of it; allow five of
            # each of two samples.
            assert_allclose(ours.detach().std(), theirs.detach().std(), rtol=10 * np.sqrt(0.2 / n))
            assert_allclose(ours.detach().abs().max(), theirs.detach().abs().max(), rtol=20 / n)


def test_the_paper_s_configuration_is_the_published_recipe():
    config = yaml.safe_load((CONFIG / "config.yaml").read_text())
    update_config(config, yaml.safe_load((CONFIG / "paper.yaml").read_text()))
    tracker = filled(config)["tracker"]
    settings = tracker["training"]
    assert Settings(**settings) == published_settings(settings["n_steps"])
    sets = 2 * [range(1500)]
    n_epochs = tracker["n_epochs"]
    _, chosen = compose(range(2360), sets, Settings(**settings), n_epochs, 1, 1500 / 2360)
    # 15 epochs of five copies of 2360 real scenes and 1500 of every added set.
    assert chosen.n_steps == 402_000


def test_the_published_recipe_refuses_crops():
    with refusal("published: expected batch_size 1 and no crop"):
        Training(published_settings(10, width=2, n_range_bins=64), seed=1)


def test_an_epoch_too_short_for_an_update_is_refused():
    training = Training(published_settings(10, width=2), seed=1)
    with refusal("gradients of an epoch must .* at least 10, got 5"):
        next(train_steps(training, TrainingSet(toy_scenes(1), seed=1)))
