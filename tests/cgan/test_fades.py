"""Fades that all snow of a scene shares: planted ones are measured, slabs' own changes are not."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from snowsim.cgan.fades import FALL_BINS, LENGTH_LINES, SLAB_BINS, draw_fades, fade_spread
from snowsim.cgan.grain import correlated
from snowsim.echogram import Scene

N_LINES = 256
SPREAD = 4.0  # grey levels
SURFACE = np.full(N_LINES, 50.0)


def scenes(n, *, common, own, rng):
    """Scenes with speckle of 8 grey levels; fades of all snow, and of slabs by themselves."""
    for number in range(n):
        image = 120 + 8 * rng.standard_normal((300, N_LINES))
        image += draw_fades(SURFACE, 300, common, rng=rng)
        for top in range(50, 300, SLAB_BINS):
            white = rng.standard_normal((1, N_LINES))
            image[top : top + SLAB_BINS] += own * correlated(white, LENGTH_LINES, axis=1)
        image = np.rint(np.clip(image, 0, 255)).astype(np.uint8)
        yield Scene(f"scene {number}", 300, SURFACE[None], image)


@pytest.mark.parametrize("own", [0.0, SPREAD])
def test_planted_fades_are_measured_whatever_slabs_do_by_themselves(own, rng):
    found = fade_spread(scenes(400, common=SPREAD, own=own, rng=rng))
    # A scene holds about one independent value: the variance's relative error is sqrt(2 / 400), 7
    # %, and with changes of slabs twice that; half of it in the spread, three times for 99 %.
    assert_allclose(found, SPREAD, rtol=0.11 if own == 0 else 0.22)


def test_without_fades_there_are_none(rng):
    # A root: of a variance with an error of sqrt(1 / 400) of that of the slabs' own.
    assert fade_spread(scenes(400, common=0.0, own=SPREAD, rng=rng)) < 0.4 * SPREAD
    low = Scene("low", 100, SURFACE[None], np.zeros((100, N_LINES), dtype=np.uint8))
    narrow = Scene("narrow", 300, SURFACE[None, :40], np.zeros((300, 40), dtype=np.uint8))
    assert fade_spread([low, narrow]) == 0.0


def test_draws_have_the_spread_about_their_mean_and_the_correlation_and_fall_with_depth(rng):
    drawn = np.array([draw_fades(SURFACE, 351, SPREAD, rng=rng) for _ in range(2000)])
    assert (drawn[:, :50] == 0).all()
    assert_allclose(drawn[:, 350], np.exp(-300 / FALL_BINS) * drawn[:, 50], rtol=1e-6)
    drawn = drawn[:, 50]
    assert_allclose(drawn.mean(axis=1), 0, atol=1e-6 * SPREAD)
    lags = np.abs(np.arange(N_LINES)[:, None] - np.arange(N_LINES))
    covariance = SPREAD**2 * np.exp(-lags / LENGTH_LINES)
    of_mean = covariance.mean(axis=0)
    expected = covariance - of_mean - of_mean[:, None] + of_mean.mean()
    found = drawn.T @ drawn / len(drawn)
    # Relative errors of covariances are below sqrt(2 / 2000) of the variance: five times.
    assert_allclose(found, expected, atol=0.16 * expected.max())


def test_nothing_fades_where_the_surface_is_not_known(rng):
    surface = np.where(np.arange(N_LINES) < 9, np.nan, 50.0)
    drawn = draw_fades(surface, 100, SPREAD, rng=rng)
    assert (drawn[:, :9] == 0).all()
    assert (drawn[50:, 9:] != 0).all()
