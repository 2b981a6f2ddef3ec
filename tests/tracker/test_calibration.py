"""Calibration: planted offsets and temperatures are found, and said is seen."""

import dataclasses

import numpy as np
import pytest
from numpy.testing import assert_allclose
from refusals import refusal
from scipy.special import expit
from toy_scenes import logits_at, toy_scenes

from snowsim.tracker import Ridges, calibrate, fit_logistic, reliability, ridges_of


def test_a_planted_offset_and_temperature_are_found(rng):
    logits = rng.normal(1, 3, 200_000)
    hits = rng.uniform(size=logits.size) < expit((logits - 1.7) / 1.3)
    offset, temperature = fit_logistic(Ridges(logits, hits))
    # Standard errors of logistic regression on as many points: below .01 each; allow four.
    assert_allclose([offset, temperature], [1.7, 1.3], atol=0.04)
    curve = reliability(expit((logits - offset) / temperature), hits)
    # A class of n pixels scatters by at most .5 / sqrt(n), n above 8,000.
    assert curve.n_pixels.min() > 8000
    assert curve.deviation < 4 * 0.5 / np.sqrt(8000)


def test_only_hits_or_none_still_give_finite_numbers():
    logits = np.linspace(-3, 3, 50)
    for hits in (np.ones(50, bool), np.zeros(50, bool)):
        assert np.isfinite(fit_logistic(Ridges(logits, hits))).all()


def test_reliability_counts_every_pixel_in_its_class():
    probability = np.array([0.05, 0.08, 0.95, 1.0])
    curve = reliability(probability, np.array([False, True, True, True]))
    assert curve.n_pixels.tolist() == [2, 0, 0, 0, 0, 0, 0, 0, 0, 2]
    assert_allclose(curve.probability[[0, 9]], [0.065, 0.975])
    assert_allclose(curve.hit_share[[0, 9]], [0.5, 1.0])
    assert np.isnan(curve.hit_share[1:9]).all()
    # .5 - .065, against .025 in the other.
    assert_allclose(curve.deviation, 0.435)


@pytest.mark.parametrize(("moved_bins", "share"), [(0, 1), (1.4, 1), (4, 0)])
def test_a_pick_within_two_bins_is_a_hit(moved_bins, share):
    scene = toy_scenes(1)[0]
    ridges = ridges_of([logits_at(scene, moved_bins)], [scene])
    # The ridge is found within half a pixel; where it fades at the border it may be lost.
    assert ridges.hits.size > 100
    strong = ridges.logits > 2
    assert_allclose(ridges.hits[strong].mean(), share, atol=0.02)


def test_scenes_with_nothing_to_pick_are_refused():
    scene = toy_scenes(1)[0]
    flat = np.full((scene.n_range_bins, scene.n_range_lines), -20.0)
    with refusal("picks to calibrate on must be a whole number of at least 1"):
        calibrate([flat], [scene])
    bare = dataclasses.replace(scene, layer_bins=scene.layer_bins[:0])
    ridges = ridges_of([logits_at(scene)], [bare])
    assert not ridges.hits.any()
