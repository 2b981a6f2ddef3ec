"""`method: pix2pix` equals the published code, written again in `published_pix2pix`."""

from dataclasses import replace

import numpy as np
import published_pix2pix
import pytest
import torch
from numpy.testing import assert_allclose
from toy_scenes import toy_scene

from snowsim.cgan import Settings, Training, render, train_steps
from snowsim.cgan.networks import PatchDiscriminator, initialise
from snowsim.cgan.published import PublishedGenerator, resized
from snowsim.seeding import random_stream

N_STEPS = 50
SEED = 7
SETTINGS = Settings(
    method="pix2pix",
    width=3,
    depth=5,
    n_strided=2,
    n_steps=N_STEPS,
    n_range_bins=32,
    n_range_lines=32,
    learning_rate=2e-4,
    dropout=0.5,
    precision="float32",
)
NAMES = ("discriminator_real", "discriminator_fake", "generator_adversarial", "l1")


def unlike_scenes():
    """Scenes that are resized down, up, and one side each."""
    return [toy_scene(1, 90, 61), toy_scene(2, 64, 20), toy_scene(3, 101, 36)]


@pytest.fixture
def in_float64():
    torch.set_default_dtype(torch.float64)
    yield
    torch.set_default_dtype(torch.float32)


def items(scenes):
    """What every step shows, by the training's random numbers and the other code."""
    shown = []
    channels = [24, 12, 6]  # of d1, d2, d3
    for step in range(N_STEPS):
        rng = random_stream(SEED, "cgan", "step", step)
        scene = scenes[rng.integers(len(scenes))]
        # 32 x 286 / 256 = 35.75: of 36 rows and lines a corner cuts 32.
        corner = [int(np.ceil(rng.uniform(0.01, 4))) for _ in range(2)]
        mirrored = rng.random() > 0.5
        pair = [
            published_pix2pix.jitter(picture, (36, 36), (32, 32), corner, mirrored)
            for picture in (scene.mask().astype(float), scene.image / 255)
        ]
        dropped = []
        for k, n in enumerate(channels, start=1):
            kept = rng.random((1, n, 2**k, 2**k)) >= 0.5
            dropped.append(torch.from_numpy(kept * 2.0))
        shown.append([*(torch.from_numpy(p)[None, None] for p in pair), dropped])
    return shown


def transcribed(training):
    """The other code's networks with the weights of a training."""
    generator = published_pix2pix.Generator(SETTINGS.width, SETTINGS.depth)
    with torch.no_grad():
        for ours, theirs in pairs_of_generators(training.generator, generator):
            theirs.copy_(ours)
    weights = [p.detach().clone() for p in training.discriminator.parameters()]
    return generator, published_pix2pix.discriminator(weights, SETTINGS.n_strided)


def pairs_of_generators(ours, theirs):
    """Parameters of both, those of equal role together."""
    n = len(ours.down)
    modules = []
    for k in range(n):
        modules.append((ours.down[k], getattr(theirs, f"e{k + 1}")))
        modules.append((ours.up[k], getattr(theirs, f"d{n - k}")))
    for k in range(n - 1):
        modules.append((ours.norm_down[k], getattr(theirs, f"e{k + 2}_norm")))
        modules.append((ours.norm_up[k], getattr(theirs, f"d{n - 1 - k}_norm")))
    for mine, other in modules:
        yield from zip(mine.parameters(), other.parameters(), strict=True)


@pytest.mark.usefixtures("in_float64")
def test_losses_and_weights_of_50_updates_equal_those_of_the_published_code():
    scenes = unlike_scenes()
    training = Training(SETTINGS, seed=SEED)
    generator, discriminator = transcribed(training)
    n_weights = sum(p.numel() for p in generator.parameters())
    assert n_weights == sum(p.numel() for p in training.generator.parameters())
    found = [losses for _, losses in train_steps(training, scenes)]
    expected = published_pix2pix.train(
        generator, discriminator, items(scenes), lr=SETTINGS.learning_rate, l1_weight=100.0
    )
    got = [[losses[name] for name in NAMES] for losses in found]
    # Rounding, 2e-16, that 50 steps of Adam enlarge.
    assert_allclose(got, expected, rtol=1e-8)
    pairs = list(pairs_of_generators(training.generator, generator))
    theirs = [p for layer in discriminator for p in layer.parameters]
    pairs += zip(training.discriminator.parameters(), theirs, strict=True)
    largest_step = SETTINGS.learning_rate * np.sqrt(N_STEPS)
    for ours, other in pairs:
        # Of a bias that is normalised away the gradient is rounding: Adam's next step is of any
        # sign, and no image depends on it.
        is_bias_of_convolution = ours.ndim == 1 and ours.abs().max() < 0.1 * largest_step
        if not is_bias_of_convolution:
            assert_allclose(ours.detach(), other.detach(), rtol=0, atol=1e-6 * largest_step)


@pytest.mark.parametrize("size", [(9, 13), (40, 7), (5, 50), (17, 11)])
def test_images_are_resized_as_in_torch(size, rng):
    picture = rng.random((17, 11))
    expected = published_pix2pix.scale(picture, *size)
    assert_allclose(resized(picture, *size), expected, rtol=1e-12)


def test_networks_of_the_published_size_have_the_published_numbers_of_weights():
    generator = PublishedGenerator(width=64, depth=8)
    assert sum(p.numel() for p in generator.parameters()) == 54_414_337
    # Without biases before a normalisation and norm of the innermost: 2497 + 3008 and 1024 less,
    # and one that the port has.
    biases = [*generator.down, *generator.up]
    n_biases = sum(convolution.bias.numel() for convolution in biases)
    n_innermost = sum(p.numel() for p in generator.norm_down[-1].parameters())
    assert 54_414_337 - n_biases - n_innermost + 1 == 54_407_809
    discriminator = PatchDiscriminator(64, has_biases=True)
    assert sum(p.numel() for p in discriminator.parameters()) == 2_765_505


def test_first_weights_follow_the_published_law(rng):
    generator = PublishedGenerator(width=16, depth=6)
    initialise(generator, rng=rng)
    weights = generator.down[4].weight.detach().numpy()
    # 262144 normal draws: the spread is known to 0.02 / sqrt(2 n); allow four of those.
    assert_allclose(weights.std(), 0.02, rtol=4 / np.sqrt(2 * weights.size))
    gains = torch.cat([norm.weight for norm in [*generator.norm_down, *generator.norm_up]])
    assert_allclose(gains.detach().mean(), 1, atol=4 * 0.02 / np.sqrt(gains.numel()))
    assert all((convolution.bias == 0).all() for convolution in generator.down)


def test_three_stages_drop_out_from_the_innermost_on_at_the_published_depth(rng):
    noise = PublishedGenerator(width=1, depth=8).draw_noise(np.zeros((1, 256, 256)), rng=rng)
    assert {stage: tuple(factor.shape) for stage, factor in noise.items()} == {
        7: (1, 8, 2, 2),
        6: (1, 8, 4, 4),
        5: (1, 8, 8, 8),
    }
    values = torch.cat([factor.flatten() for factor in noise.values()])
    assert set(values.tolist()) == {0.0, 2.0}


def test_the_rate_never_falls_and_an_image_keeps_the_size_of_its_scene(rng):
    training = Training(replace(SETTINGS, n_steps=3), seed=1)
    for _ in train_steps(training, unlike_scenes()):
        rates = {group["lr"] for group in training.optimisers["generator_adam"].param_groups}
        assert rates == {SETTINGS.learning_rate}
    image = render(training.generator, toy_scene(4, 150, 70), SETTINGS, rng=rng)
    assert (image.shape, image.dtype) == ((150, 70), np.uint8)


@pytest.mark.parametrize("sizes", [(None, 32), (32, 48)])
def test_sizes_that_the_networks_cannot_halve_are_refused(sizes):
    with pytest.raises(ValueError, match=r"pix2pix: .* multiples of 2\*\*5, got"):
        replace(SETTINGS, n_range_bins=sizes[0], n_range_lines=sizes[1])
