"""The detectors of a collapsed training catch every planted failure, and pass what is healthy."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from numpy.testing import assert_allclose
from toy_scenes import toy_scene, toy_scenes
from trainings import begun

from lib import cgan_health as health
from lib.cgan_health import checkerboard, faults, measure_losses, measure_renders
from snowsim.cgan import Settings, Training, render

PIX2PIX = {"method": "pix2pix", "dropout": 0.5}
SIZE = {"width": 8, "depth": 4, "n_strided": 2, "n_range_bins": 64, "n_range_lines": 64}
SETTINGS = Settings(**PIX2PIX, **SIZE, learning_rate=1e-3, n_steps=240)


def image_of(mask, rng):
    """A healthy image: layers with tails, speckle that changes from draw to draw."""
    tail = np.exp(-np.arange(20) / 5)

    def with_tails(column):
        return np.convolve(column, tail)[: column.size]

    level = 60.0 + 120 * np.apply_along_axis(with_tails, 0, mask)
    speckle = 6 * rng.standard_normal(mask.shape)
    return np.minimum(level, 220) + speckle


def measured(make, monkeypatch):
    """Health of renders in grey levels by `make(mask, rng)` in place of a generator's."""
    monkeypatch.setattr(
        health, "render", lambda generator, scene, settings, *, rng: make(scene.mask(), rng)
    )
    scenes = [
        toy_scene(number, n_range_bins=256, n_range_lines=192, n_layers=10) for number in range(4)
    ]
    return measure_renders(None, scenes, SETTINGS, seed=1)


def without_draws(mask, rng):
    return image_of(mask, np.random.default_rng(1))


@pytest.mark.parametrize(("make", "dropout"), [(image_of, 0.5), (without_draws, 0.0)])
def test_a_healthy_image_has_no_fault_and_without_dropout_equal_draws_are_none(
    make, dropout, monkeypatch
):
    assert faults(measured(make, monkeypatch), dropout=dropout) == []


def no_finite(mask, rng):
    raise FloatingPointError


def chequers(shape, period):
    """One grey level up and down, in squares of half a period."""
    return (-1.0) ** (np.indices(shape) // (period // 2)).sum(axis=0)


@pytest.mark.parametrize(
    ("make", "fault"),
    [
        (lambda mask, rng: image_of(np.indices(mask.shape)[0] % 25 == 20, rng), "mask ignored"),
        (lambda mask, rng: 100 + 6 * rng.standard_normal(mask.shape), "mask ignored"),
        (without_draws, "dropout ignored"),
        (lambda mask, rng: 255 - image_of(mask, rng), "nothing learnt"),
        (no_finite, "values that are not finite"),
        (lambda mask, rng: image_of(mask, rng) + 5 * chequers(mask.shape, 2), "checkerboard"),
        (lambda mask, rng: image_of(mask, rng) + 5 * chequers(mask.shape, 4), "checkerboard"),
        (lambda mask, rng: image_of(mask, rng) + 5 * chequers(mask.shape, 8), "checkerboard"),
    ],
)
def test_a_planted_failure_of_the_generator_is_named(make, fault, monkeypatch):
    found = faults(measured(make, monkeypatch), dropout=0.5)
    assert fault in [phrase.split(":")[0] for phrase in found]


@pytest.mark.parametrize(
    ("share", "fault"),
    [
        (0.05, "discriminator saturated"),
        (0.7, None),
        (0.993, None),
        (1.0, "discriminator idle"),
        (3.0, "discriminator idle"),
    ],
)
def test_a_planted_failure_of_the_discriminator_is_named(share, fault):
    loss = share * health.UNDECIDED
    early = [
        {"discriminator_real": 9.0, "discriminator_fake": 9.0}
    ] * 50  # before the window: counts no more
    late = [
        {"discriminator_real": 0.5 * loss, "discriminator_fake": 1.5 * loss}
    ] * health.WINDOW_STEPS
    numbers = measure_losses(early + late)
    assert_allclose(numbers["discriminator_ratio"], share, rtol=1e-12)
    assert [found.split(":")[0] for found in faults(numbers, dropout=0.5)] == (
        [fault] if fault else []
    )


def test_a_discriminator_may_be_idle_early_but_not_saturated():
    assert faults({"discriminator_ratio": 1.0}, dropout=0.5, early=True) == []
    assert faults({"discriminator_ratio": 0.05}, dropout=0.5, early=True)


def test_a_checkerboard_of_one_grey_level_measures_one_and_edges_and_speckle_make_none(rng):
    # Whole grey levels up and down by one: the median of each phase is exact, its spread is the
    # amplitude.
    flat = np.full((64, 48), 100.0)
    for period in (2, 4, 8):
        assert_allclose(checkerboard(flat + chequers(flat.shape, period)), 1, rtol=1e-12)
    assert checkerboard(flat) == 0
    image = np.where(np.arange(320)[:, None] < 50, 60.0, 160.0) + 7 * rng.standard_normal(
        (320, 256)
    )
    # Medians of 1280 cells scatter by 7 sqrt(pi / 2 / 1280) = 0.25; the largest of three spreads is
    # below twice that.
    assert checkerboard(image) < 0.5


def test_one_scene_is_too_few():
    with pytest.raises(ValueError, match="two or more scenes, got 1"):
        measure_renders(None, toy_scenes(1), SETTINGS, seed=1)


def test_weights_that_are_not_finite_are_named():
    settings = replace(SETTINGS, width=2)
    training = Training(settings, seed=1)
    with torch.no_grad():
        training.generator.up[0].weight.fill_(torch.nan)
    with pytest.raises(FloatingPointError, match="not finite"):
        render(training.generator, toy_scenes(1)[0], settings, rng=np.random.default_rng(1))
    numbers = measure_renders(training.generator, toy_scenes(2), settings, seed=1)
    assert faults(numbers, dropout=0.5) == ["values that are not finite"]


def trained_faults(settings, seed, *, freeze_discriminator=False):
    """Train on toy scenes and examine half way and at the end: faults, numbers."""
    training, steps = begun(settings, seed, n_scenes=24)
    unseen = toy_scenes(28)[24:]
    if freeze_discriminator:
        training.optimisers["discriminator_adam"].step = lambda: None
    losses, found, examined = [], [], []
    try:
        for step, step_losses in steps:
            losses.append(step_losses)
            if step in (settings.n_steps // 2, settings.n_steps):
                numbers = measure_losses(losses) | measure_renders(
                    training.generator, unseen, settings, seed=seed
                )
                found += faults(numbers, dropout=settings.dropout)
                examined.append(numbers)
    except FloatingPointError as error:
        found.append(f"values that are not finite: {error}")
    return found, examined


@pytest.mark.study
@pytest.mark.parametrize("seed", range(400, 410))
def test_ten_unseen_healthy_trainings_have_no_fault(seed):
    found, numbers = trained_faults(SETTINGS, seed)
    assert found == [], numbers


@pytest.mark.study
def test_rates_a_hundred_times_too_high_are_found():
    settings = replace(SETTINGS, learning_rate=100 * SETTINGS.learning_rate)
    examined = {seed: trained_faults(settings, seed) for seed in (200, *range(400, 410))}
    missed = {seed: numbers for seed, (found, numbers) in examined.items() if not found}
    # One of eleven is not found, which one depends on the processor: it errs by 0.74 to 0.78 of the
    # contrast, but answers to the mask.
    assert len(missed) <= 1, missed


@pytest.mark.study
@pytest.mark.parametrize("seed", [200, 201])
def test_a_frozen_discriminator_is_found(seed):
    found, numbers = trained_faults(SETTINGS, seed, freeze_discriminator=True)
    assert [fault for fault in found if fault.startswith("discriminator")], numbers
