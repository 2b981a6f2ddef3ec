"""The paper's estimators as printed.

Tracked-bin powers, eq. (2) decay rates and 1/e widths of averaged range lines.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit

from snowsim.statistics.summaries import FIRST_ROW, GROUP_LINES

# The waveform's peak lies up to 6 bins below its Gaussian for variances of 10-15.
PEAK_REACH_BINS = 8
OPEN_END_BINS = 40  # how far below the last pick of a line a width is searched for


def is_present(n_picks):
    """Groups in which a layer counts: picked in at least half of the lines, bool (group, layer)."""
    return 2 * n_picks >= GROUP_LINES


@dataclass(frozen=True)
class Tracked:
    """Mean power under the picks, its standard error, and the number of picks, three (layer,)."""

    power: np.ndarray
    standard_error: np.ndarray
    n_picks: np.ndarray


def tracked_moments(summary, n_layers):
    """`Tracked` power of a flight.

    The error is that of the mean over groups: lines of one group share their fading.
    """
    lines = [frame.tracked_power[:n_layers].astype(float) for frame in summary]
    total = np.zeros(n_layers)
    n_picks = np.zeros(n_layers, dtype=int)
    for power in lines:
        total[: len(power)] += np.nansum(power, axis=1)
        n_picks[: len(power)] += np.isfinite(power).sum(axis=1)
    mean = total / np.maximum(n_picks, 1)
    squares = np.zeros(n_layers)
    n_groups = np.zeros(n_layers, dtype=int)
    for power in lines:
        residual = power - mean[: len(power), None]
        for first in range(0, power.shape[1], GROUP_LINES):
            group = residual[:, first : first + GROUP_LINES]
            squares[: len(power)] += np.nansum(group, axis=1) ** 2
            n_groups[: len(power)] += np.isfinite(group).any(axis=1)
    # Ratio estimator: the residual sums of the groups are the independent terms.
    spread = np.sqrt(squares * n_groups / np.maximum(n_groups - 1, 1))
    return Tracked(mean, spread / np.maximum(n_picks, 1), n_picks)


def measure_groups(power, position, present):
    """Decay rate [per bin] and 1/e width from the peak [bins], two (group, layer).

    Of every layer in every averaged line.
    From averaged lines (group, row), rows of layers below the surface and whether they are present,
    (group, layer). Yari et al. (2021), eq. (2): ``alpha = -log(P_min / P_peak) / b`` with `b` bins
    from the peak, the largest value within `PEAK_REACH_BINS` of the layer and half way to its
    neighbours, to the minimum before the next layer; NaN where either layer is absent or no minimum
    lies between. The 1/e crossing is interpolated linearly; NaN where the power does not fall so
    far before the minimum.
    """
    return _measure(power, position, present)


@njit(cache=True)
def _measure(power, position, present):
    n_groups, n_layers = position.shape
    decay_rate = np.full(position.shape, np.nan)
    width = np.full(position.shape, np.nan)
    for group in range(n_groups):
        line = power[group]
        for layer in range(n_layers):
            if not present[group, layer]:
                continue
            here = int(np.rint(position[group, layer])) - FIRST_ROW
            closed = layer + 1 < n_layers and present[group, layer + 1]
            end = here + OPEN_END_BINS
            if closed:
                end = int(np.rint(position[group, layer + 1])) - FIRST_ROW
            start = here - PEAK_REACH_BINS
            if layer > 0 and present[group, layer - 1]:
                above = int(np.rint(position[group, layer - 1])) - FIRST_ROW
                start = max(start, here - (here - above) // 2)
            end = min(end, line.size - 1)
            stop = min(here + PEAK_REACH_BINS, here + (end - here) // 2)
            peak = _largest(line, max(start, 0), stop)
            if peak < 0:
                continue
            lowest = _smallest(line, peak, end)
            if closed and lowest > peak and 0 < line[lowest] < line[peak]:
                decay_rate[group, layer] = -np.log(line[lowest] / line[peak]) / (lowest - peak)
            width[group, layer] = _width(line, peak, lowest)
    return decay_rate, width


@njit(cache=True)
def _width(line, peak, lowest):
    """Rows from the peak to 1/e of it, NaN where the power does not fall so far."""
    target = line[peak] / np.e
    for row in range(peak + 1, lowest + 1):
        if line[row] <= target:
            beyond = (target - line[row]) / (line[row - 1] - line[row])
            return row - peak - beyond
    return np.nan


@njit(cache=True)
def _largest(line, first, last):
    best = -1
    for row in range(first, last + 1):
        if not np.isnan(line[row]) and (best < 0 or line[row] > line[best]):
            best = row
    return best


@njit(cache=True)
def _smallest(line, first, last):
    best = first
    for row in range(first, last + 1):
        if line[row] < line[best]:
            best = row
    return best
