from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from refusals import refusal
from scipy.ndimage import uniform_filter
from toy_scenes import toy_scene, with_echoes
from trainings import trained

from snowsim.cgan import Settings, Training, render, train_steps
from snowsim.cgan.measured import learning_rate

TINY = Settings(width=4, depth=4, n_steps=6, n_range_bins=64, n_range_lines=64)


@pytest.fixture(scope="module")
def learnt():
    return trained(replace(TINY, width=8, n_steps=150, learning_rate=2e-3), n_scenes=8)


def test_the_error_falls_and_layers_of_an_unseen_mask_come_out_brighter_than_the_ground(
    learnt, rng
):
    l1 = [losses["l1"] for losses in learnt[1]]
    # Untrained, the output is near mid-grey; the mean ground level would leave about 0.3.
    assert np.mean(l1[-20:]) < 0.5 * np.mean(l1[:5])
    scene = with_echoes(toy_scene(99))
    image = render(learnt[0].generator, scene, learnt[0].settings, rng=rng)
    on, off = image[scene.mask()].mean(), image[~scene.mask()].mean()
    truly = scene.image[scene.mask()].mean() - scene.image[~scene.mask()].mean()
    assert on - off > 0.5 * truly


def test_training_without_scenes_is_refused():
    with refusal("scenes to train on must"):
        next(train_steps(Training(TINY, seed=1), []))


def test_the_rate_is_constant_for_half_the_steps_then_falls_linearly_to_zero():
    settings = replace(TINY, n_steps=100, learning_rate=1.0)
    rates = [learning_rate(settings, step) for step in range(101)]
    assert rates[:51] == [1.0] * 51
    assert_allclose(rates[50:], np.linspace(1, 0, 51), atol=1e-15)


def test_scenes_of_mixed_sizes_train_whole():
    scenes = [toy_scene(1), toy_scene(2, 130), toy_scene(3, n_range_lines=48)]
    settings = replace(TINY, n_range_bins=None, n_range_lines=None, n_steps=3)
    for _, losses in train_steps(Training(settings, seed=1), scenes):
        assert np.isfinite(list(losses.values())).all()


def test_without_layers_a_trained_image_repeats_no_pattern_of_its_stages(learnt):
    """No checkerboard of transposed convolutions: power at periods of 2, 4, 8 as about them."""
    training, _ = learnt
    rng = np.random.default_rng(1)
    scene = with_echoes(toy_scene(5, 384, 192))
    image = render(training.generator, scene, training.settings, rng=rng)
    ground = image[-256:].astype(float)
    level = ground.mean(axis=1, keepdims=True)
    power = np.abs(np.fft.fft2(ground - level)) ** 2
    others = (49 * uniform_filter(power, 7, mode="wrap") - power) / 48
    # One of white noise is exponential about 1: the mean of 32 scatters by 0.18; transposed
    # convolutions had 296.
    assert (power / others)[::32, 24:97:24].mean() < 2
