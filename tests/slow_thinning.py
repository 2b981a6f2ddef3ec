"""Thinning of binary maps written down as published, slowly."""

import numpy as np

# Neighbours x1 to x8 of a pixel, anticlockwise from the right: Guo & Hall (1989), algorithm A1.
STEPS = [(0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0), (1, 1)]


def thin_slowly(mask, *, early):
    """Map thinned to lines of one pixel, half-step by half-step.

    With `early` it stops after the first half-step that removes nothing, as py-bsds500 does; else
    after two of them, as scikit-image does.
    """
    mask = np.array(mask, dtype=bool)
    n_idle = half = 0
    while n_idle < (1 if early else 2):
        framed = np.pad(mask, 1)
        n_rows, n_lines = mask.shape
        x = [framed[1 + i : 1 + i + n_rows, 1 + j : 1 + j + n_lines] for i, j in STEPS]
        crossings = sum(~x[k] & (x[k + 1] | x[(k + 2) % 8]) for k in range(0, 8, 2))
        ahead = sum((x[k] | x[k + 1]).astype(int) for k in range(0, 8, 2))
        behind = sum((x[k + 1] | x[(k + 2) % 8]).astype(int) for k in range(0, 8, 2))
        fewest = np.minimum(ahead, behind)
        keeps = [(x[1] | x[2] | ~x[7]) & x[0], (x[5] | x[6] | ~x[3]) & x[4]][half]
        falls = mask & (crossings == 1) & (fewest >= 2) & (fewest <= 3) & ~keeps
        mask &= ~falls
        n_idle = 0 if falls.any() else n_idle + 1
        half = 1 - half
    return mask
