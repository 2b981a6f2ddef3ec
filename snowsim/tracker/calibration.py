"""How sure a tracker may be: two numbers and a threshold, fitted on fully annotated scenes."""

from dataclasses import dataclass

import numpy as np
import torch
from scipy.optimize import minimize
from scipy.special import expit

from snowsim.metrics.edges import THRESHOLDS, match_counts, score, suppress
from snowsim.tracker.network import check_image

WITHIN_BINS = 2.0  # of a layer a pick is a hit
LEAST_PROBABILITY = 0.02  # of a pixel that may be a pick, before calibration
N_CLASSES = 10  # of the reliability curve
# Of the offset, and of the logarithm of the temperature.
LIMITS = (-10.0, 10.0)
LOG_LIMITS = (-2.3, 2.3)


@dataclass(frozen=True, eq=False)
class Calibration:
    """What scenes say of a network; probabilities are ``sigmoid((logit - offset) / temperature)``.

    Attributes
    ----------
    offset, temperature : float
        The loss makes layers weigh as much as background, so that logits are too high: the offset
        takes that back.
    threshold : float
        Of the probability, with the best F of the scenes, `snowsim.metrics.edges.score`.
    scores : dict
        Its `ods`, `ois` and `ap`.
    said, seen : ndarray, (class,)
        Mean probability of the pixels that may be picks, in even classes, and the share of them
        within `WITHIN_BINS` of a layer; NaN in a class without pixels.
    n_pixels : ndarray of int, (class,)
    """

    offset: float
    temperature: float
    threshold: float
    scores: dict
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


def calibrate(network, scenes):
    """`Calibration` of a network on scenes whose every layer is annotated.

    All are held, 0.6 MB each. ValueError if there is no scene, or nothing that may be a pick.
    """
    scenes = [scenes[place] for place in range(len(scenes))]
    logits = [fused_logits(network, scene.image) for scene in scenes]
    found = [ridge_hits(each, scene.layer_bins) for each, scene in zip(logits, scenes, strict=True)]
    if not found or not sum(hits.size for _, hits in found):
        msg = f"expected picks to calibrate on, {len(found)} scenes have none"
        raise ValueError(msg)
    ridges = np.concatenate([ridge for ridge, _ in found])
    hits = np.concatenate([hits for _, hits in found])
    offset, temperature = fit_logistic(ridges, hits)
    counts = [
        match_counts(suppress(expit((each - offset) / temperature)), scene.mask(), THRESHOLDS)
        for each, scene in zip(logits, scenes, strict=True)
    ]
    scores = score(counts, THRESHOLDS)
    said, seen, n_pixels = reliability(expit((ridges - offset) / temperature), hits)
    return Calibration(
        offset=offset,
        temperature=temperature,
        threshold=float(scores["ods_threshold"]),
        scores={name: float(scores[name]) for name in ("ods", "ois", "ap")},
        said=said,
        seen=seen,
        n_pixels=n_pixels,
    )


def ridge_hits(logits, layer_bins, *, within_bins=WITHIN_BINS):
    """Logits of pixels that may be picks, and whether each lies near a layer, both (pixel,).

    Pixels are those of the ridges of the probability of `logits` (range_bin, range_line);
    `layer_bins` (layer, range_line) has every layer.
    """
    row, line = np.nonzero(suppress(expit(logits)) >= LEAST_PROBABILITY)
    distance = np.abs(layer_bins[:, line] - row)
    nearest = np.where(np.isfinite(distance), distance, np.inf).min(axis=0, initial=np.inf)
    return logits[row, line], nearest <= within_bins


def fit_logistic(logits, hits):
    """Offset and temperature by which ``sigmoid((logit - offset) / T)`` makes hits most likely.

    Platt (1999), Advances in Large Margin Classifiers, 61-74.
    """
    sign = np.where(hits, -1.0, 1.0)
    logits = logits.astype(float)

    def surprise(parameters):
        offset, log_temperature = parameters
        return np.logaddexp(0, sign * (logits - offset) * np.exp(-log_temperature)).mean()

    # Where all are hits, or none, the best offset lies at infinity: limits keep it finite.
    found = minimize(surprise, np.zeros(2), method="L-BFGS-B", bounds=[LIMITS, LOG_LIMITS])
    offset, log_temperature = found.x
    return float(offset), float(np.exp(log_temperature))


def reliability(probability, hits):
    """Mean probability, share of hits and number of pixels in even classes, (class,) each."""
    place = np.minimum((probability * N_CLASSES).astype(int), N_CLASSES - 1)
    n_pixels = np.bincount(place, minlength=N_CLASSES)
    some = np.where(n_pixels > 0, n_pixels, np.nan)
    said = np.bincount(place, weights=probability, minlength=N_CLASSES) / some
    seen = np.bincount(place, weights=hits, minlength=N_CLASSES) / some
    return said, seen, n_pixels
