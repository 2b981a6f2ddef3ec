"""Row of the surface along track: a slow error, and what levelling in whole bins leaves."""

import numpy as np

from snowsim.constants import BLOCK_LINES
from snowsim.statistics.moments import mean_where

# Of the steps that whole-bin levelling makes, above which a product is taken to do so.
LEVELLED_SHARE = 0.5
LEVELLED_CHANGE = 1 / 6  # [bins^2] mean square change of what it leaves, uniform within a bin
LAGS = 2 ** np.arange(8)  # [range lines]
LENGTHS = 2 ** np.arange(-1, 10.01, 0.125)  # [range lines] of the slow error


def surface_statistics(summary):
    """Three numbers of the surface's row, name to (dimensions, values).

    A product levels the aircraft's movement m in whole bins, which leaves ``m - round(m)``; a slow
    error comes on top, of standard deviation `surface_error_bins` and Gaussian correlation
    ``exp(-(h / surface_error_length_m)^2)``. `surface_movement_bins` is the r.m.s. of m from one
    range line to the next, 0 where a product does not level in whole bins.
    """
    whole = []
    for frame in summary:
        n_blocks = frame.surface_bins.size // BLOCK_LINES
        whole.append(frame.surface_bins[: n_blocks * BLOCK_LINES])
    rows = np.concatenate(whole).astype(float).reshape(-1, BLOCK_LINES)
    movement = _movement(rows[np.isfinite(rows).all(axis=1)])
    steps = [rows[:, lag:] - rows[:, :-lag] for lag in LAGS]
    change = np.array([mean_where(np.isfinite(step), step**2, axis=None) for step in steps])
    left = LEVELLED_CHANGE * (movement > 0)
    deviation, length_lines = _slow_error(change, left)
    spacing_m = float(np.median([frame.line_spacing_m for frame in summary]))
    return {
        "surface_error_bins": ((), deviation),
        "surface_error_length_m": ((), length_lines * spacing_m),
        "surface_movement_bins": ((), movement),
    }


def _slow_error(change, left):
    """Deviation and length of an error that changes by `change` (lag,), less what levelling left.

    By least squares of relative residuals; the length is one of `LENGTHS`.
    """
    known = np.flatnonzero(change > 0)
    if known.size == 0:
        return 0.0, 1.0
    measured = change[known]
    shape = 2 * (1 - np.exp(-((LAGS[known] / LENGTHS[:, None]) ** 2))) / measured
    target = 1 - left / measured
    product = np.maximum((shape * target).sum(axis=1), 0)
    square = (shape**2).sum(axis=1)
    best = (product**2 / square).argmax()
    return np.sqrt(product[best] / square[best]), LENGTHS[best]


def _movement(rows):
    """R.m.s. movement between range lines that was levelled in whole bins; 0 if none was.

    Increments of the movement change by less than half a bin per line: they are those of the row
    (block, range_line) less whole bins, and rounding such a movement makes as many steps.
    """
    step = np.diff(rows, axis=1)
    if step.size == 0:
        return 0.0
    first = step[:, :1] - np.rint(step[:, :1])
    bend = np.diff(step, axis=1)
    change = np.cumsum(bend - np.rint(bend), axis=1)
    movement = np.concatenate([first, first + change], axis=1)
    # Moving every line by whole bins does not change the fraction.
    movement -= np.rint(movement.mean(axis=1, keepdims=True))
    n_steps = np.abs(np.rint(step - movement)).sum()
    rms = np.sqrt((movement**2).mean())
    levelled = n_steps > LEVELLED_SHARE * np.sqrt(2 / np.pi) * rms * movement.size
    return rms if levelled else 0.0
