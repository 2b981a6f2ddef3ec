"""Training of the conditional GAN learns, repeats to the byte and resumes to the byte."""

from dataclasses import asdict, replace

import numpy as np
import pytest
import torch
from numpy.testing import assert_allclose
from toy_scenes import toy_scene, toy_scenes

from snowsim.cgan import Settings, Training, render, settle_statistics, train_steps, trained_generator
from snowsim.cgan.train import learning_rate
from snowsim.io.models import read_model, write_model

TINY = Settings(width=4, depth=4, n_strided=2, n_steps=6, n_range_bins=64, n_range_lines=64)


def trained(settings, scenes, seed=1):
    training = Training(settings, seed=seed)
    losses = [losses for _, losses in train_steps(training, scenes)]
    return training, losses


def same(a, b):
    """Whether two nested states hold the same bits."""
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(same(a[key], b[key]) for key in a)
    return torch.equal(a, b)


@pytest.fixture(scope="module")
def learnt():
    settings = replace(TINY, width=8, n_steps=150, learning_rate=2e-3)
    training, losses = trained(settings, toy_scenes(8))
    settle_statistics(training, toy_scenes(8))
    return training, losses


def test_the_mean_absolute_error_falls(learnt):
    l1 = [losses["l1"] for losses in learnt[1]]
    # Untrained, the output is near mid-grey; the mean ground level would leave about 0.3.
    assert np.mean(l1[-20:]) < 0.5 * np.mean(l1[:5])


def test_layers_of_an_unseen_mask_come_out_brighter_than_the_ground(learnt, rng):
    scene = toy_scene(99)
    image = render(learnt[0].generator, scene.mask(), rng=rng)
    on, off = image[scene.mask()].mean(), image[~scene.mask()].mean()
    truly = scene.image[scene.mask()].mean() - scene.image[~scene.mask()].mean()
    assert on - off > 0.5 * truly


def test_the_same_seed_gives_the_same_bytes_and_another_seed_does_not():
    scenes = toy_scenes(3)
    first, again, other = (trained(TINY, scenes, seed)[0].state() for seed in (1, 1, 2))
    assert same(first, again)
    assert not same(first, other)


@pytest.mark.parametrize("n_before", [1, 4])
def test_a_resumed_training_equals_an_uninterrupted_one_to_the_byte(n_before, tmp_path):
    scenes = toy_scenes(3)
    whole, losses = trained(TINY, scenes)
    broken = Training(TINY, seed=1)
    for step, _ in train_steps(broken, scenes):
        if step == n_before:
            settle_statistics(broken, scenes)  # a look at the generator in between leaves no trace
            write_model(tmp_path / "state.safetensors", broken.state(), {"step": step, "settings": asdict(TINY)})
            break
    state, metadata = read_model(tmp_path / "state.safetensors", expected={"settings": asdict(TINY)})
    resumed = Training(TINY, seed=1)
    resumed.restore(state, metadata["step"])
    assert [later for _, later in train_steps(resumed, scenes)] == losses[n_before:]
    settle_statistics(whole, scenes)
    settle_statistics(resumed, scenes)
    for name, training in (("whole", whole), ("resumed", resumed)):
        write_model(tmp_path / f"{name}.safetensors", training.state(), {"step": training.step})
    assert (tmp_path / "whole.safetensors").read_bytes() == (tmp_path / "resumed.safetensors").read_bytes()


def test_each_scene_is_seen_once_before_any_is_seen_again():
    class Watched(list):
        def __getitem__(self, item):
            seen.append(item)
            return super().__getitem__(item)

    seen = []
    for _ in train_steps(Training(TINY, seed=1), Watched(toy_scenes(6))):
        pass
    assert sorted(seen) == list(range(6))


def test_the_rate_is_constant_for_half_the_steps_then_falls_linearly_to_zero():
    settings = replace(TINY, n_steps=100, learning_rate=1.0)
    rates = [learning_rate(settings, step) for step in range(101)]
    assert rates[:51] == [1.0] * 51
    assert_allclose(rates[50:], np.linspace(1, 0, 51), atol=1e-15)


@pytest.mark.parametrize("change", [{"adversarial": "lsgan"}, {"precision": "float32"}, {"batch_size": 2}])
def test_every_variant_takes_finite_steps(change):
    settings = replace(TINY, n_steps=2, **change)
    steps = list(train_steps(Training(settings, seed=1), toy_scenes(2)))
    assert len(steps) == 2
    for _, losses in steps:
        assert set(losses) == {"discriminator_real", "discriminator_fake", "generator_adversarial", "l1"}
        assert np.isfinite(list(losses.values())).all()


def test_a_training_that_diverges_says_so():
    settings = replace(TINY, n_steps=50, learning_rate=1e30)
    with pytest.raises(FloatingPointError, match="diverged at step"):
        list(train_steps(Training(settings, seed=1), toy_scenes(2)))


def test_a_state_of_other_settings_is_refused_in_one_line():
    state = Training(replace(TINY, width=5), seed=1).state()
    with pytest.raises(ValueError, match=r"generator: expected .* of shape .*, got .*: other settings") as error:
        Training(TINY, seed=1).restore(state, 1)
    assert "\n" not in str(error.value)
    with pytest.raises(ValueError, match="generator: expected"):
        trained_generator({}, TINY)
    adam = trained(TINY, toy_scenes(1))[0].state()
    del adam["generator_adam"][0]
    with pytest.raises(ValueError, match="generator_adam: expected moments of"):
        Training(TINY, seed=1).restore(adam, 1)


NO_LAYER = np.full((4, 64), np.nan)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"layer_bins": NO_LAYER}, "scene toy 1: mask without layers"),
        ({"image": np.full((96, 64), 9, np.uint8)}, "scene toy 1: image without contrast, every pixel is 9"),
        ({"image": np.zeros((96, 70), np.uint8)}, r"scene toy 1: expected a uint8 image of shape \(96, 64\)"),
        ({"image": None}, "scene toy 1: .* got no image"),
    ],
)
def test_a_scene_that_cannot_be_trained_on_is_named_in_one_line(change, words):
    with pytest.raises(ValueError, match=words) as error:
        list(train_steps(Training(TINY, seed=1), [replace(toy_scene(1), **change)]))
    assert "\n" not in str(error.value)


def test_scenes_of_mixed_sizes_train_whole_and_in_batches_of_their_common_part():
    scenes = [toy_scene(1, n_range_bins=96), toy_scene(2, n_range_bins=130), toy_scene(3, n_range_lines=48)]
    for batch_size in (1, 2):
        settings = replace(TINY, n_range_bins=None, n_range_lines=None, batch_size=batch_size, n_steps=3)
        assert all(
            np.isfinite(list(losses.values())).all() for _, losses in train_steps(Training(settings, seed=1), scenes)
        )


def test_training_without_scenes_is_refused():
    with pytest.raises(ValueError, match="at least one scene"):
        next(train_steps(Training(TINY, seed=1), []))


@pytest.mark.parametrize(
    "change",
    [{"n_steps": 0}, {"dropout": 1.0}, {"adversarial": "hinge"}, {"precision": "int8"}, {"learning_rate": 0.0}],
)
def test_settings_out_of_range_are_refused(change):
    with pytest.raises(ValueError, match=next(iter(change))):
        replace(TINY, **change)
