"""Scores of an evaluation do not depend on how probabilities are scaled."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.ndimage import gaussian_filter
from scipy.special import expit, logit

from snowsim.metrics.edges import THRESHOLDS, match_counts, suppress, thresholds_of


@pytest.fixture(scope="module")
def maps():
    """Smooth probabilities of four images."""
    noise = np.random.default_rng(1).random((4, 120, 128))
    return [gaussian_filter(each, (1.5, 6)) for each in noise]


@pytest.mark.parametrize(
    "rescale", [np.sqrt, np.square, lambda p: p / 10, lambda p: expit(4 + logit(p))]
)
def test_every_rising_function_of_edges_leaves_all_counts_as_they_are(maps, rescale, rng):
    edges = [suppress(each, added_curvature=0) for each in maps]
    rescaled = [rescale(each) for each in edges]
    for before, after in zip(edges, rescaled, strict=True):
        truth = rng.random(before.shape) < 0.05
        expected = match_counts(before, truth, thresholds_of(edges))
        found = match_counts(after, truth, thresholds_of(rescaled))
        for name, counts in expected.items():
            assert_array_equal(found[name], counts)


def test_thresholds_never_count_what_was_suppressed_and_begin_with_few_pixels(maps):
    edges = [suppress(each) for each in maps]
    thresholds = thresholds_of(edges)
    assert thresholds[0] > 0
    values = np.unique(np.concatenate([each[each > 0] for each in edges]))
    # As many as k squared ten-thousandths, and the pixel of the threshold itself.
    reach = [(values >= each).mean() for each in thresholds[[-1, -10, -50]]]
    assert_allclose(reach, [1e-4, 1e-2, 0.25], atol=1.01 / values.size)
    # A level that most pixels share takes one place, not most of them.
    flat = np.where(edges[0] > 0, edges[0], thresholds[0] / 2)
    assert np.unique(thresholds_of([flat])).size > 90
    # Empty maps have the published ones.
    assert_array_equal(thresholds_of([np.zeros((9, 9))]), THRESHOLDS)
