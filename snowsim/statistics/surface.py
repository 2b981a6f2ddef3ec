"""Row of the surface along track: a slow error, and what levelling in whole bins leaves."""

import numpy as np

from snowsim.statistics.moments import known_mean
from snowsim.statistics.relief import LAGS, TINY
from snowsim.statistics.summaries import in_blocks

# Of the steps that whole-bin levelling makes, above which a product is taken to do so.
LEVELLED_SHARE = 0.5
LEVELLED_CHANGE = 1 / 6  # [bins^2] mean square change of what it leaves, uniform within a bin
LENGTHS = 2 ** np.arange(-1, 10.01, 0.125)  # [range lines] of the slow error


def surface_statistics(summary):
    """Four numbers of the surface's row, name to (dimensions, values).

    A product levels the aircraft's height m in whole bins, which leaves ``m - round(m)``; a slow
    error comes on top, of standard deviation `surface_error_bins` and Gaussian correlation
    ``exp(-(h / surface_error_length_m)^2)``. `surface_movement_bins` is the r.m.s. change of m from
    one range line to the next, and this change has a Gaussian correlation, too, of
    `surface_movement_length_m`; both are 0 where a product does not level in whole bins. The error
    is that of least squares of relative residuals; its length is one of `LENGTHS`.
    """
    rows = in_blocks(summary, "surface_bins")
    movement, n_lines = _movement(rows[np.isfinite(rows).all(axis=1)])
    spacing_m = np.median(summary["line_spacing_m"])
    change = np.array([known_mean((rows[:, lag:] - rows[:, :-lag]) ** 2) for lag in LAGS])
    told = change > 0
    shape = 2 * (1 - np.exp(-((LAGS[told] / LENGTHS[:, None]) ** 2))) / change[told]
    target = 1 - LEVELLED_CHANGE * (movement > 0) / change[told]
    square = np.maximum((shape**2).sum(axis=1), TINY)
    variance = np.maximum((shape * target).sum(axis=1), 0) / square
    best = (variance**2 * square).argmax()
    return {
        "surface_error_bins": ((), np.sqrt(variance[best])),
        "surface_error_length_m": ((), LENGTHS[best] * spacing_m),
        "surface_movement_bins": ((), movement),
        "surface_movement_length_m": ((), n_lines * spacing_m),
    }


def _movement(rows):
    """R.m.s. movement between range lines that was levelled in whole bins, and its length [lines].

    Zeros if none was. Movement changes by less than half a bin per line: it is that of the row
    (block, range_line) less whole bins, and rounding such a height makes as many steps. Its length
    is where its autocorrelation falls to 1/e.
    """
    step = np.diff(rows, axis=1)
    if step.size == 0:
        return 0.0, 0
    first = step[:, :1] - np.rint(step[:, :1])
    bend = np.diff(step, axis=1)
    change = np.cumsum(bend - np.rint(bend), axis=1)
    movement = np.concatenate([first, first + change], axis=1)
    # Moving every line by whole bins does not change the fraction.
    movement -= np.rint(movement.mean(axis=1, keepdims=True))
    n_steps = np.abs(np.rint(step - movement)).sum()
    rms = np.sqrt((movement**2).mean())
    if n_steps <= LEVELLED_SHARE * np.sqrt(2 / np.pi) * rms * movement.size:
        return 0.0, 0
    for lag in range(1, movement.shape[1]):
        if (movement[:, lag:] * movement[:, :-lag]).mean() * np.e < rms**2:
            break
    return rms, lag
