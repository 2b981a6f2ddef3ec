"""How sure a tracker may be: two numbers and a threshold, fitted on fully annotated scenes."""

from dataclasses import dataclass

import numpy as np
import torch
from scipy.optimize import minimize
from scipy.special import expit

from snowsim.limits import check_count
from snowsim.metrics.edges import THRESHOLDS, match_counts, score, suppress
from snowsim.tracker.network import check_image

WITHIN_BINS = 2.0  # of a layer a pick is a hit
LEAST_PROBABILITY = 0.02  # of a pixel that may be a pick, before calibration
N_CLASSES = 10  # of the reliability curve
# Of the offset, and of the logarithm of the temperature.
LIMITS = (-10.0, 10.0)
LOG_LIMITS = (-2.3, 2.3)


@dataclass(frozen=True)
class Calibration:
    """What annotated scenes say of a network: probabilities, a threshold, and what they are worth.

    Attributes
    ----------
    offset, temperature : float
        The probability of a layer is ``sigmoid((logit - offset) / temperature)``. The loss makes
        layers weigh as much as background, so that logits are too high: the offset takes that back.
    threshold : float
        Of the probability, with the best F of the scenes, `snowsim.metrics.edges.score`.
    ods, ois, ap : float
        Its scores.
    deviation : float
        Largest difference of the reliability curve, `Reliability.deviation`.
    """

    offset: float
    temperature: float
    threshold: float
    ods: float
    ois: float
    ap: float
    deviation: float

    def probability(self, logits):
        """Probability of a layer, of logits of any shape."""
        return expit((np.asarray(logits, dtype=float) - self.offset) / self.temperature)


@dataclass(frozen=True, eq=False)
class Ridges:
    """Pixels that may be picks: their logits, and whether each lies near a layer, both (pixel,)."""

    logits: np.ndarray
    hits: np.ndarray


@dataclass(frozen=True, eq=False)
class Reliability:
    """Mean probability, share of hits and number of pixels in even classes, (class,) each.

    NaN in a class without pixels.
    """

    said: np.ndarray
    seen: np.ndarray
    n_pixels: np.ndarray

    @property
    def deviation(self):
        """Largest difference of what is said and seen, in classes of a hundredth of the pixels."""
        filled = 100 * self.n_pixels >= self.n_pixels.sum()
        return float(np.abs(self.said - self.seen)[filled].max())


def fused_logits(network, image):
    """Fused logits of an image of uint8, float32 (range_bin, range_line), without calibration."""
    check_image(image)
    device = next(network.parameters()).device
    with torch.inference_mode():
        logits = network(network.to_input(image[None]).to(device))[-1]
        return logits[0, 0].float().cpu().numpy()


def calibrate(logits, scenes):
    """`Calibration` of a network by its `fused_logits` of scenes whose every layer is annotated.

    ValueError if there is no scene, or nothing that may be a pick.
    """
    ridges = ridges_of(logits, scenes)
    offset, temperature = fit_logistic(ridges)
    probability = [expit((each - offset) / temperature) for each in logits]
    scores = edge_scores(probability, scenes)
    curve = reliability(expit((ridges.logits - offset) / temperature), ridges.hits)
    return Calibration(
        offset=offset,
        temperature=temperature,
        threshold=float(scores["ods_threshold"]),
        ods=float(scores["ods"]),
        ois=float(scores["ois"]),
        ap=float(scores["ap"]),
        deviation=curve.deviation,
    )


def edge_scores(probability, scenes):
    """`snowsim.metrics.edges.score` of fused maps of probability of some scenes."""
    counts = [
        match_counts(suppress(each), scene.mask(), THRESHOLDS, where=scene.name)
        for each, scene in zip(probability, scenes, strict=True)
    ]
    return score(counts, THRESHOLDS)


def ridges_of(logits, scenes, *, within_bins=WITHIN_BINS):
    """`Ridges` of the fused logits (range_bin, range_line) of scenes with every layer annotated."""
    found = []
    near = []
    for each, scene in zip(logits, scenes, strict=True):
        row, line = np.nonzero(suppress(expit(each)) >= LEAST_PROBABILITY)
        distance = np.abs(scene.layer_bins[:, line] - row)
        nearest = np.where(np.isfinite(distance), distance, np.inf).min(axis=0, initial=np.inf)
        found.append(each[row, line].astype(float))
        near.append(nearest <= within_bins)
    check_count("picks to calibrate on", sum(hits.size for hits in near))
    return Ridges(np.concatenate(found), np.concatenate(near))


def fit_logistic(ridges):
    """Offset and temperature by which ``sigmoid((logit - offset) / T)`` makes hits most likely.

    Platt (1999), Advances in Large Margin Classifiers, 61-74.
    """
    sign = np.where(ridges.hits, -1.0, 1.0)

    def surprise(parameters):
        offset, log_temperature = parameters
        return np.logaddexp(0, sign * (ridges.logits - offset) * np.exp(-log_temperature)).mean()

    # Where all are hits, or none, the best offset lies at infinity: limits keep it finite.
    found = minimize(surprise, np.zeros(2), method="L-BFGS-B", bounds=[LIMITS, LOG_LIMITS])
    offset, log_temperature = found.x
    return float(offset), float(np.exp(log_temperature))


def reliability(probability, hits):
    """`Reliability` of the probabilities of some pixels, (pixel,), given which are hits."""
    place = np.minimum((probability * N_CLASSES).astype(int), N_CLASSES - 1)
    n_pixels = np.bincount(place, minlength=N_CLASSES)
    some = np.where(n_pixels > 0, n_pixels, np.nan)
    said = np.bincount(place, weights=probability, minlength=N_CLASSES) / some
    seen = np.bincount(place, weights=hits, minlength=N_CLASSES) / some
    return Reliability(said, seen, n_pixels)
