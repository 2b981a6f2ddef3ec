"""Scores of an evaluation do not depend on how probabilities are scaled; published ones do."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.ndimage import gaussian_filter
from scipy.special import expit, logit

from snowsim.echogram import layer_mask
from snowsim.metrics.edges import (
    METRICS,
    THRESHOLDS,
    match_counts,
    score,
    suppress,
    thresholds_of,
)


def draw_map(rng):
    """Probability as a network gives it, highest near .06, and the mask of seven layers."""
    lines = np.arange(128)
    steps = np.cumsum(rng.normal(0, 0.1, (7, 128)), axis=1)
    layers = 30 + 22 * np.arange(7)[:, None] + 5 * np.sin(lines / 25 + rng.uniform(0, 6)) + steps
    strength = gaussian_filter(rng.normal(0, 10, (7, 128)), (0, 12)) + rng.normal(0, 1, (7, 1))
    away = np.abs(np.arange(200)[:, None, None] - layers)
    noise = gaussian_filter(rng.normal(size=(200, 128)), (2.5, 10))
    ridges = (strength - (away / 1.5) ** 2).max(axis=1)
    log_odds = np.logaddexp(ridges, 2.5 / noise.std() * noise - 8) - 4
    return expit(log_odds), layer_mask(layers, 200)


def scores_of(maps, masks, *, as_published=False):
    """ODS, OIS and AP of maps, at thresholds that follow them or at the published ones."""
    edges = [suppress(each, **({} if as_published else {"added_curvature": 0})) for each in maps]
    thresholds = THRESHOLDS if as_published else thresholds_of(edges)
    counts = [match_counts(*image, thresholds) for image in zip(edges, masks, strict=True)]
    scores = score(counts, thresholds)
    return np.array([scores[metric] for metric in METRICS])


@pytest.fixture(scope="module")
def images():
    """Maps and masks of six images."""
    rng = np.random.default_rng(1)
    return tuple(zip(*(draw_map(rng) for _ in range(6)), strict=True))


@pytest.mark.parametrize(
    ("rescale", "most"),
    [
        (lambda p: p / 10, 0.005),
        (lambda p: expit(logit(p) + 4), 0.005),
        (lambda p: expit(logit(p) - 4), 0.005),
        # Suppression smooths, and a mean of squares is no square of a mean: a square sharpens
        # noise.
        (lambda p: p**2, 0.06),
    ],
    ids=["a tenth", "log-odds + 4", "log-odds - 4", "square"],
)
def test_rescaled_probabilities_have_the_same_scores(images, rescale, most):
    maps, masks = images
    rescaled = [rescale(each) for each in maps]
    assert_allclose(scores_of(rescaled, masks), scores_of(maps, masks), atol=most)
    published = [scores_of(each, masks, as_published=True) for each in (maps, rescaled)]
    assert np.abs(published[1] - published[0])[-1] > 0.1


def test_thresholds_never_count_what_was_suppressed_and_begin_with_few_pixels(images):
    edges = [suppress(each) for each in images[0]]
    thresholds = thresholds_of(edges)
    assert thresholds.shape == THRESHOLDS.shape
    assert thresholds[0] > 0
    values = np.unique(np.concatenate([each[each > 0] for each in edges]))
    # As many as k squared ten-thousandths, and the pixel of the threshold itself.
    reach = [(values >= each).mean() for each in thresholds[[-1, -10, -50]]]
    assert_allclose(reach, [1e-4, 1e-2, 0.25], atol=1.01 / values.size)
    # Maps of one level have one threshold, empty ones the published.
    assert set(thresholds_of([np.eye(9)])) == {1.0}
    # A level that most pixels share takes one place, not most of them.
    flat = np.where(edges[0] > 0, edges[0], thresholds[0] / 2)
    assert np.unique(thresholds_of([flat])).size > 90
    assert_array_equal(thresholds_of([np.zeros((9, 9))]), THRESHOLDS)
