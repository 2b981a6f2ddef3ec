"""Calibration of a tracker on fully annotated scenes: offset, temperature and threshold."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize
from scipy.special import expit

from snowsim.limits import check_count
from snowsim.metrics.edges import match_counts, score, suppress, thresholds_of

WITHIN_BINS = 2.0  # distance to a layer within which a pick is a hit
LEAST_PROBABILITY = 0.02  # least probability of a pick before calibration
N_CLASSES = 10  # of the reliability curve
LIMITS = ((-10.0, 10.0), (-2.3, 2.3))  # of the offset and of the logarithm of the temperature


@dataclass(frozen=True)
class Calibration:
    """Map from logits of a network to probability, and scores on the scenes of calibration.

    Attributes
    ----------
    offset, temperature : float
        The probability of a layer is ``sigmoid((logit - offset) / temperature)``. The loss gives
        layers the same weight as background, so that logits are too high; the offset corrects this.
    threshold : float
        Probability with the best F on the scenes; see `snowsim.metrics.edges.score`.
    ods, ois, ap : float
        Scores on the scenes.
    deviation : float
        Largest difference between probability and share of hits; see `Reliability.deviation`.
    """

    offset: float
    temperature: float
    threshold: float
    ods: float
    ois: float
    ap: float
    deviation: float

    def probability(self, logits):
        """Probability of a layer from logits, an array of their shape."""
        return expit((np.asarray(logits, dtype=float) - self.offset) / self.temperature)


@dataclass(frozen=True, eq=False)
class Ridges:
    """Logits of pixels that may be picks, and whether each is a hit, both (pixel,)."""

    logits: np.ndarray
    hits: np.ndarray


@dataclass(frozen=True, eq=False)
class Reliability:
    """Mean probability, share of hits and number of pixels in classes of probability, (class,).

    Probability and share are NaN in a class without pixels.
    """

    probability: np.ndarray
    hit_share: np.ndarray
    n_pixels: np.ndarray

    @property
    def deviation(self):
        """Largest difference between both in classes with at least 1 % of the pixels."""
        filled = 100 * self.n_pixels >= self.n_pixels.sum()
        return float(np.abs(self.probability - self.hit_share)[filled].max())


def calibrate(logits, scenes):
    """`Calibration` of a network from its `fused_logits` of fully annotated scenes.

    ValueError if no pixel may be a pick.
    """
    ridges = ridges_of(logits, scenes)
    offset, temperature = fit_logistic(ridges)
    probability = [expit((each - offset) / temperature) for each in logits]
    scores = score(*edge_counts(probability, scenes))
    curve = reliability(expit((ridges.logits - offset) / temperature), ridges.hits)
    return Calibration(
        offset=offset,
        temperature=temperature,
        threshold=scores["ods_threshold"],
        ods=scores["ods"],
        ois=scores["ois"],
        ap=scores["ap"],
        deviation=curve.deviation,
    )


def fit_logits(logits, scenes):
    """Offset and temperature of `Calibration`, for edge scores that do not depend on either.

    Logits that are shifted and scaled give the same calibrated probability, so that the smoothing
    of `suppress` favours no sharp or blurred map. For that the ridges are those of logits of mean 0
    and standard deviation 1. `logits` and ValueError are those of `calibrate`.
    """
    pixels = np.concatenate([each.ravel() for each in logits]).astype(float)
    mean, deviation = pixels.mean(), pixels.std()
    standard = [(each - mean) / deviation for each in logits]
    offset, temperature = fit_logistic(ridges_of(standard, scenes, least_probability=0))
    return mean + deviation * offset, deviation * temperature


def edge_counts(probability, scenes):
    """Counts of matched edges in each scene's map of probability, and their common thresholds."""
    edges = [suppress(each, added_curvature=0) for each in probability]
    thresholds = thresholds_of(edges)
    counts = [
        match_counts(each, scene.mask(), thresholds)
        for each, scene in zip(edges, scenes, strict=True)
    ]
    return counts, thresholds


def ridges_of(logits, scenes, least_probability=LEAST_PROBABILITY):
    """`Ridges` in one output's logits (range_bin, range_line) of fully annotated scenes."""
    found = []
    near = []
    for each, scene in zip(logits, scenes, strict=True):
        edges = suppress(expit(each))
        row, line = np.nonzero((edges > 0) & (edges >= least_probability))
        found.append(each[row, line].astype(float))
        near.append(near_a_layer(row, line, scene))
    check_count("picks to calibrate on", sum(hits.size for hits in near))
    return Ridges(np.concatenate(found), np.concatenate(near))


def near_a_layer(bins, line, scene, within_bins=WITHIN_BINS):
    """Picks within `within_bins` range bins of a layer of the scene, bool (pick,)."""
    distance = np.abs(scene.layer_bins[:, line] - bins)
    nearest = np.where(np.isfinite(distance), distance, np.inf).min(axis=0, initial=np.inf)
    return nearest <= within_bins


def fit_logistic(ridges):
    """Offset and temperature T of ``sigmoid((logit - offset) / T)`` with the largest likelihood.

    Platt (1999), Advances in Large Margin Classifiers, 61-74.
    """
    sign = np.where(ridges.hits, -1.0, 1.0)

    def surprise(parameters):
        offset, log_temperature = parameters
        return np.logaddexp(0, sign * (ridges.logits - offset) * np.exp(-log_temperature)).mean()

    # Limits, because the best offset is infinite if all pixels are hits or none is.
    found = minimize(surprise, np.zeros(2), method="L-BFGS-B", bounds=LIMITS)
    offset, log_temperature = found.x
    return float(offset), float(np.exp(log_temperature))


def reliability(probability, hits):
    """`Reliability` of the probabilities of pixels, given which are hits, both (pixel,)."""
    number = np.minimum((probability * N_CLASSES).astype(int), N_CLASSES - 1)
    n_pixels = np.bincount(number, minlength=N_CLASSES)
    n_or_nan = np.where(n_pixels > 0, n_pixels, np.nan)
    mean_probability = np.bincount(number, weights=probability, minlength=N_CLASSES) / n_or_nan
    hit_share = np.bincount(number, weights=hits, minlength=N_CLASSES) / n_or_nan
    return Reliability(mean_probability, hit_share, n_pixels)
