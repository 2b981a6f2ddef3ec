"""The paper's estimators as printed: tracked-bin powers, eq. (2) decay rates and 1/e widths of averaged range lines."""

import numpy as np
from numba import njit

from snowsim.statistics.summaries import FIRST_ROW, GROUP_LINES

PEAK_REACH_BINS = (
    8  # the waveform's peak lies up to 6 bins below its Gaussian for variances of 10-15
)
OPEN_END_BINS = 40  # how far below the last pick of a line a width is searched for


def is_present(n_picks):
    """Groups in which a layer counts: picked in at least half of the lines, bool (group, layer)."""
    return 2 * n_picks >= GROUP_LINES


def tracked_moments(summary, n_layers):
    """Mean power under the picks of each layer, its standard error, and the number of picks, three (layer,).

    The error is that of the mean over groups: lines of one group share their fading.
    """
    lines = [frame.tracked_power[:n_layers].astype(float) for frame in summary]
    total, count = np.zeros(n_layers), np.zeros(n_layers, dtype=int)
    for power in lines:
        known = np.isfinite(power)
        total[: len(power)] += np.where(known, power, 0).sum(axis=1)
        count[: len(power)] += known.sum(axis=1)
    mean = total / np.maximum(count, 1)
    squares, groups = np.zeros(n_layers), np.zeros(n_layers, dtype=int)
    for power in lines:
        for first in range(0, power.shape[1], GROUP_LINES):
            part = power[:, first : first + GROUP_LINES]
            known = np.isfinite(part)
            n = known.sum(axis=1)
            squares[: len(power)] += (
                np.where(known, part - mean[: len(power), None], 0).sum(axis=1) ** 2
            )
            groups[: len(power)] += n > 0
    # Ratio estimator: the residual sums of the groups are the independent terms.
    spread = np.sqrt(squares * groups / np.maximum(groups - 1, 1)) / np.maximum(count, 1)
    return mean, spread, count


def nan_moments(values):
    """Mean over groups, its standard error, and the number of values, by layer; 0 where there is none."""
    known = np.isfinite(values)
    n = known.sum(axis=0)
    mean = np.where(known, values, 0).sum(axis=0) / np.maximum(n, 1)
    squares = np.where(known, (values - mean) ** 2, 0).sum(axis=0)
    # A single value is taken as its own scatter.
    deviation = np.where(n > 1, np.sqrt(squares / np.maximum(n - 1, 1)), np.abs(mean))
    return mean, deviation / np.sqrt(np.maximum(n, 1)), n


def measure_groups(power, position, present):
    """Decay rate [per bin] and 1/e width from the peak [bins] of every layer in every averaged line, (group, layer).

    From averaged lines (group, row), rows of layers below the surface and whether they are present,
    (group, layer). Yari et al. (2021), eq. (2): ``alpha = -log(P_min / P_peak) / b`` with `b` bins
    from the peak, the largest value within `PEAK_REACH_BINS` of the layer and half way to its
    neighbours, to the minimum before the next layer; NaN where either layer is absent or no minimum
    lies between. The 1/e crossing is interpolated linearly; NaN where the power does not fall so
    far before the minimum.
    """
    return _measure(power, position, present, FIRST_ROW, PEAK_REACH_BINS, OPEN_END_BINS)


@njit(cache=True)
def _measure(power, position, present, first_row, reach, open_end):
    n_groups, n_layers = position.shape
    n_rows = power.shape[1]
    decay_rate = np.full((n_groups, n_layers), np.nan)
    width = np.full((n_groups, n_layers), np.nan)
    for group in range(n_groups):
        line = power[group]
        for layer in range(n_layers):
            if not present[group, layer]:
                continue
            here = int(np.rint(position[group, layer])) - first_row
            closed = layer + 1 < n_layers and present[group, layer + 1]
            end = here + open_end
            if closed:
                end = int(np.rint(position[group, layer + 1])) - first_row
            start = here - reach
            if layer > 0 and present[group, layer - 1]:
                above = int(np.rint(position[group, layer - 1])) - first_row
                start = max(start, here - (here - above) // 2)
            end = min(end, n_rows - 1)
            peak = _largest(line, max(start, 0), min(here + reach, here + (end - here) // 2))
            if peak < 0:
                continue
            lowest = _smallest(line, peak, end)
            if closed and lowest > peak and 0 < line[lowest] < line[peak]:
                decay_rate[group, layer] = -np.log(line[lowest] / line[peak]) / (lowest - peak)
            target = line[peak] / np.e
            for row in range(peak + 1, lowest + 1):
                if line[row] <= target:
                    width[group, layer] = (
                        row - peak - (target - line[row]) / (line[row - 1] - line[row])
                    )
                    break
    return decay_rate, width


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
