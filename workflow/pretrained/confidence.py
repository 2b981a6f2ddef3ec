"""Confidence and threshold of picks, fitted where every layer is annotated."""

import dataclasses

import numpy as np
import pandas as pd
from scipy.optimize import minimize

from pretrained.scores import Calibrated, followed, pick_scores, pieces_of
from snowsim.limits import check_count
from snowsim.tracker import features, near_a_layer

# Probabilities at which picks are scored to choose the threshold.
THRESHOLDS = (0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5)
F_KNOWN_TO = 0.0025  # of the tuning flights' 320 scenes


def fit_confidence(logits, scenes, calibration):
    """Coefficients of `confidence` by which hits are most likely, (offset, near, far).

    A pick of scenes with every layer annotated is a hit if a layer lies within 2 rows of it;
    ValueError without a pick.
    """
    seen = [np.empty((2, 0))]
    hits = [np.empty(0, bool)]
    for each, scene in zip(logits, scenes, strict=True):
        for piece in pieces_of(each, calibration):
            seen.append(features(piece, each.shape[1]))
            hits.append(near_a_layer(piece.row, piece.line, scene))
    seen = np.concatenate(seen, axis=1)
    hits = np.concatenate(hits)
    check_count("picks to fit their confidence to", hits.size)
    terms = np.vstack([np.ones(hits.size), seen])
    sign = np.where(hits, -1.0, 1.0)

    def surprise(coefficients):
        return np.logaddexp(0, sign * (coefficients @ terms)).mean()

    # Where all are hits, or none, the best offset lies at infinity: limits keep it finite.
    found = minimize(surprise, np.zeros(3), method="L-BFGS-B", bounds=[(-10.0, 10.0)] * 3)
    return tuple(float(value) for value in found.x)


def pick_curve(logits, scenes, calibration):
    """Table of `pick_scores` by `threshold`, each with its own confidence, while any is picked.

    ValueError if nothing is picked at the least threshold.
    """
    rows = []
    for threshold in THRESHOLDS:
        at = dataclasses.replace(calibration, threshold=threshold)
        if rows and not any(pieces_of(each, at) for each in logits):
            break
        tracker = Calibrated(None, at, fit_confidence(logits, scenes, at))
        picks = [followed(each, tracker, each.shape) for each in logits]
        rows.append({"threshold": threshold} | pick_scores(picks, scenes))
    return pd.DataFrame(rows)


def threshold_of(curve):
    """Threshold of fewest false pieces among those of the best F."""
    best = curve[curve["f"] >= curve["f"].max() - F_KNOWN_TO]
    return float(best.loc[best["false_share"].idxmin(), "threshold"])
