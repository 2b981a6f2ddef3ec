"""The recipe `paper`: pix2pix has the published sizes, loss, jitter and noise."""

import copy
from dataclasses import replace

import numpy as np
import pytest
import torch
from numpy.lib.stride_tricks import sliding_window_view
from numpy.testing import assert_allclose
from refusals import refusal
from toy_scenes import toy_scene
from trainings import trained

from snowsim.cgan import Training, networks_of, render
from snowsim.cgan.pix2pix import Generator, draw_batch, jittered, prepared, take_step
from snowsim.settings import CGAN

SMALL = replace(CGAN["paper"], width=3, depth=4, n_range_bins=32, n_range_lines=32)


def test_networks_have_the_published_numbers_of_weights():
    networks = networks_of(replace(CGAN["paper"], width=64))
    n_weights = [sum(p.numel() for p in network.parameters()) for network in networks]
    # As the authors' second code, in PyTorch, has them for one channel in and out.
    assert n_weights == [54_407_809, 2_764_609]


def test_an_update_follows_the_equation_of_the_paper(rng):
    training = Training(SMALL, seed=1)
    training.generator.double()
    training.discriminator.double()
    batch = draw_batch(training.generator, prepared(toy_scene(2), SMALL), SMALL, rng=rng)
    masks, observed, noise = batch["inputs"].double(), batch["image"].double(), batch["noise"]
    generator, discriminator = map(copy.deepcopy, (training.generator, training.discriminator))
    found = take_step(training, {"inputs": masks, "image": observed, "noise": noise})

    def step(network, loss):
        weights = list(network.parameters())
        gradients = torch.autograd.grad(loss, weights)
        for weight, gradient in zip(weights, gradients, strict=True):
            # Adam's first step, whatever its betas.
            weight.data -= SMALL.learning_rate * gradient / (gradient.abs() + 1e-8)

    def said(image):
        return torch.sigmoid(discriminator(masks, image))

    rendered = generator(masks, noise)
    on_real = -torch.log(said(observed)).mean()
    on_fake = -torch.log(1 - said(rendered)).mean()
    step(discriminator, (on_real + on_fake) / 2)
    # By the discriminator's new weights.
    adversarial = -torch.log(said(rendered)).mean()
    l1 = (observed - rendered).abs().mean()
    step(generator, adversarial + 100 * l1)
    expected = [loss.item() for loss in (on_real, on_fake, adversarial, l1)]
    # Rounding of float64.
    assert_allclose([loss.item() for loss in found.values()], expected, rtol=1e-12)
    close = {"rtol": 0, "atol": 1e-6 * SMALL.learning_rate}
    for ours, theirs in ((training.generator, generator), (training.discriminator, discriminator)):
        torch.testing.assert_close(ours.state_dict(), theirs.state_dict(), **close)


def test_jitter_cuts_every_window_of_the_enlarged_scene_and_mirrors_half_of_them(rng):
    # 32 x 286 / 256 is 36: a scene of this size is not resized, and has 5 x 5 windows.
    scene = toy_scene(1, 36, 36)
    pair = np.stack([2.0 * scene.mask() - 1, scene.image / 127.5 - 1])
    windows = sliding_window_view(pair, (32, 32), axis=(1, 2)).swapaxes(0, 2).reshape(25, 2, 32, 32)
    windows = np.concatenate([windows, windows[..., ::-1]])
    whole = prepared(scene, SMALL)
    drawn = (jittered(whole, SMALL, rng=rng)[:, 0].numpy() for _ in range(600))
    # In float32; of 50 windows in 600 draws one is missed with a probability of 3e-4.
    same = np.array([np.abs(windows - crop).max(axis=(1, 2, 3)) < 1e-6 for crop in drawn])
    assert (same.sum(axis=1) == 1).all()
    assert same.any(axis=0).all()


def test_three_stages_drop_out_from_the_innermost_on(rng):
    noise = Generator(width=1, depth=8).draw_noise((1, 1, 256, 256), rng=rng)
    shapes = {stage: tuple(factor.shape) for stage, factor in noise.items()}
    assert shapes == {7: (1, 8, 2, 2), 6: (1, 8, 4, 4), 5: (1, 8, 8, 8)}
    assert set(noise[5].unique().tolist()) == {0.0, 2.0}


def test_it_learns_at_a_constant_rate_and_renders_scenes_of_any_size(rng):
    settings = replace(SMALL, n_steps=40)
    training, losses = trained(settings, n_scenes=4)
    rates = {group["lr"] for group in training.optimisers["generator_adam"].param_groups}
    assert rates == {settings.learning_rate}
    assert losses[-1]["l1"] < losses[0]["l1"]
    image = render(training.generator, toy_scene(4, 150, 70), settings, rng=rng)
    assert (image.shape, image.dtype) == ((150, 70), np.uint8)


@pytest.mark.parametrize("sizes", [(None, 32), (32, 40)])
def test_sizes_that_the_networks_cannot_halve_are_refused(sizes):
    with refusal(r"pix2pix: .* multiples of 2\*\*4, got"):
        replace(SMALL, n_range_bins=sizes[0], n_range_lines=sizes[1])
