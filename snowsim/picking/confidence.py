"""How sure a pick is, and how far off it may be.

The probability that a layer lies within 2 rows of a pick is a logistic function of the mean
log-odds of its chain near it and farther around. The coefficients are those of flights that no
score is reported of, and a card may bring its own.
"""

import numpy as np
from scipy.special import expit

NEAR_LINES = 8
FAR_LINES = 48
LARGEST = 3.0  # log-odds that count on a line
# Of picks as sure as that, so many rows hold nine tenths of the errors of those that have a layer.
SURE = (0.45, 0.55, 0.65, 0.75, 0.85, 0.95)
HALF_WIDTH_ROWS = (3.1, 2.8, 2.0, 1.5, 1.1, 0.9)


def features(piece, n_lines):
    """Mean log-odds of a piece within `NEAR_LINES` and `FAR_LINES` of every pick, (2, pick).

    Of all `n_lines` range lines, those without a candidate and those beyond the ends of the piece
    count as none for and none against.
    """
    first = piece.line[0]
    size = piece.line[-1] - first + 1
    excess = np.zeros(size + 1)
    excess[piece.line - first + 1] = np.clip(piece.excess, -LARGEST, LARGEST)
    total = np.cumsum(excess)
    means = []
    for reach in (NEAR_LINES, FAR_LINES):
        start = np.maximum(piece.line - reach, 0)
        stop = np.minimum(piece.line + reach + 1, n_lines)
        within = np.clip(np.array([start, stop]) - first, 0, size)
        means.append((total[within[1]] - total[within[0]]) / (stop - start))
    return np.array(means)


def confidence(piece, n_lines, coefficients):
    """Probability that a layer lies within 2 rows of each pick of a piece, (pick,)."""
    offset, near, far = coefficients
    of_near, of_far = features(piece, n_lines)
    return expit(offset + near * of_near + far * of_far)


def half_width_rows(sure):
    """Rows to either side of a pick that hold nine of ten layers, where there is one."""
    return np.interp(sure, SURE, HALF_WIDTH_ROWS)
