"""Flights that the shipped tracker never saw: which they are, and how it is scored on them."""

import numpy as np
import pytest
import torch
from numpy.testing import assert_allclose
from refusals import refusal
from runs import CONFIG
from toy_scenes import logits_at, toy_scenes, with_ridges

from pretrained.confidence import (
    F_KNOWN_TO,
    THRESHOLDS,
    fit_confidence,
    pick_curve,
    threshold_of,
)
from pretrained.resizing import resized
from pretrained.scores import (
    Calibrated,
    followed,
    on_pixels,
    pick_scores,
    reliability_of,
    score_tracker,
)
from pretrained.transfer import check_flights, reference_of, scale_of
from snowsim.tracker import CONFIDENCE, Calibration, fused_logits

SURE = Calibration(0.0, 1.0, 0.5, 0.0, 0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("flights", "expected"),
    [
        ([{"name": "a", "seed": 1500}], "flight a: expected a seed from 1000 to 1999 for tuning"),
        ([{"name": "a", "seed": 1}, {"name": "a", "seed": 2}], "every name once, got a 2 times"),
        (
            [{"name": "a", "seed": 1, "reference": {"radar": {"band": 1}}}],
            r"flight a: .*radar.*: unknown key",
        ),
    ],
)
def test_flights_that_cannot_be_scored_are_refused(flights, expected):
    with refusal(expected):
        check_flights(CONFIG["pretrained"]["tuning"], flights, CONFIG)


def test_another_flight_differs_in_what_it_names_alone():
    flight = {"reference": {"radar": {"bin_size_s": 1.6e-10}}}
    found = reference_of(flight, CONFIG["reference"])
    assert found["radar"].pop("bin_size_s") == 1.6e-10
    expected = reference_of({}, CONFIG["reference"])
    assert expected["radar"].pop("bin_size_s") == 2.886e-10
    assert found == expected
    # Bins a little more than half as long: an image has that share of rows once resampled.
    reference = CONFIG["reference"]
    assert_allclose(scale_of(flight, reference), (1.6 / 2.886, 1))
    # Lines are averaged where they are closer, and never invented.
    closer, farther = ({"reference": {"radar": {"line_spacing_m": at}}} for at in (2.6, 8.0))
    assert_allclose(scale_of(closer, reference), (1, 2.6 / 5.2))
    assert_allclose(scale_of(farther, reference), (1, 1))


def picked(logits, coefficients):
    """Picks of maps of logits with the confidence of some coefficients."""
    tracker = Calibrated(None, SURE, coefficients)
    return [followed(each, tracker, each.shape) for each in logits]


def test_confidence_fitted_to_picks_says_how_many_of_them_hit(rng):
    scenes = toy_scenes(6)
    # Every third scene is picked five bins too low, at three quarters of the height.
    logits = []
    for number, scene in enumerate(scenes):
        wrong = number % 3 == 0
        logits.append(logits_at(scene, 5.0 * wrong) * (0.75 if wrong else 1))
    picks = picked(logits, fit_confidence(logits, scenes, SURE))
    sure = np.concatenate([each.sure[np.isfinite(each.bins)] for each in picks])
    # A logistic fit with an offset says, in the mean, what it was fitted to.
    assert_allclose(sure.mean(), 2 / 3, atol=0.1)
    curve = reliability_of(picks, scenes)
    assert curve.n_pixels.sum() == sure.size


def test_of_thresholds_with_good_picks_that_one_is_taken_with_fewest_false_pieces():
    scenes = toy_scenes(4)
    # Beside the layers stand ridges a third as high, ten bins lower, in every scene.
    logits = [np.maximum(logits_at(each), logits_at(each, 10.0) / 3) for each in scenes]
    curve = pick_curve(logits, scenes, SURE)
    assert len(curve) == len(THRESHOLDS)
    taken = curve.set_index("threshold").loc[threshold_of(curve)]
    assert taken["f"] >= curve["f"].max() - F_KNOWN_TO
    better = curve[curve["false_share"] < taken["false_share"]]
    assert (better["f"] < curve["f"].max() - F_KNOWN_TO).all()
    # Above the threshold at which nothing is picked any more, there is nothing to fit.
    faint = pick_curve([np.minimum(each, -1.0) for each in logits], scenes, SURE)
    assert 0 < len(faint) < len(THRESHOLDS)


def test_pieces_of_little_confidence_are_left_out():
    scenes = toy_scenes(6)
    # Beside the layers stand ridges a quarter as high, ten bins lower.
    logits = [np.maximum(logits_at(each), logits_at(each, 10.0) / 4) for each in scenes]
    of_all = pick_scores(picked(logits, (10.0, 0.0, 0.0)), scenes)
    of_likely = pick_scores(picked(logits, fit_confidence(logits, scenes, SURE)), scenes)
    assert of_all["false_share"] > 0.5
    assert of_likely["false_share"] < 0.1
    assert of_likely["missed_share"] < 0.1


class Brightness(torch.nn.Module):
    """A tracker whose logit is the image itself, in units of 1/127.5 about its middle."""

    def __init__(self):
        super().__init__()
        self.weight = torch.nn.Parameter(torch.zeros(1))

    @staticmethod
    def to_input(images):
        return torch.from_numpy(images.astype(np.float32))[:, None] / 127.5 - 1

    def forward(self, image):
        return torch.stack([image * 0, 4 * image])


def test_an_image_tracked_at_another_size_comes_back_on_its_own_pixels():
    row = np.arange(120)[:, None] + np.zeros((1, 60))
    image = np.rint(127 + 100 * np.sin(row / 8)).astype(np.uint8)
    at_its_own = fused_logits(Brightness(), resized(image, (1, 1)))
    smaller = fused_logits(Brightness(), resized(image, (0.55, 0.65)))
    resampled = on_pixels(smaller, image.shape)
    # Waves of 50 rows on bins of 1.8: averaging takes 1 % off, and rounding to grey 1/32.
    assert np.abs(resampled - at_its_own)[4:-4].max() < 0.15


def test_a_tracker_that_sees_the_layers_scores_well_in_every_way():
    scenes = list(map(with_ridges, toy_scenes(2)))
    scores = score_tracker(Calibrated(Brightness(), SURE, CONFIDENCE), scenes, (1, 1))
    assert scores["ods"] > 0.95
    assert scores["f"] > 0.9
    assert scores["missed_share"] == scores["false_share"] == 0
    assert 0 <= scores["deviation"] < 0.5
