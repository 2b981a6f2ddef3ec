"""The paper's estimators as printed.

Tracked-bin powers, eq. (2) decay rates and 1/e widths of averaged range lines.
"""

import numpy as np
from numba import njit

from snowsim.limits import check_count
from snowsim.statistics.moments import mean_where
from snowsim.statistics.summaries import FIRST_ROW
from snowsim.statistics.waveform import bridged

# The waveform's peak lies up to 6 bins below its Gaussian for variances of 10-15.
PEAK_REACH_BINS = 8
OPEN_END_BINS = 40  # how far below the last pick of a line a width is searched for


def paper_waveform(tracked_power, decay, width):
    """Variables by layer of the recipe as printed.

    From mean power under the picks (layer,), 0 where there is none, and `measure_groups`. The 1/e
    width stands for a variance, as in the paper. Eq. (2) needs a layer below: the deepest has no
    decay rate. A layer without values takes those of the one above (or below), and is
    `substituted`.
    """
    n_layers = tracked_power.size
    picked = tracked_power > 0
    substituted = ~picked
    means = []
    for values in (decay[:, :-1], width):
        known = np.isfinite(values)
        held = np.flatnonzero(known.any(axis=0))
        if values.shape[1]:
            check_count("averaged lines whose power falls to 1/e between two layers", held.size)
        nearest = np.searchsorted(held, np.arange(values.shape[1]), side="right") - 1
        source = held[np.maximum(nearest, 0)]
        means.append(mean_where(known, values, axis=0)[source])
        substituted[: values.shape[1]] |= ~known.any(axis=0)
    decay_rate, width_bins = means
    return {
        "peak_power": ("layer", bridged(tracked_power, picked)),
        "decay_rate": ("layer", np.append(decay_rate, np.nan)),
        "width_bins": ("layer", width_bins),
        "variance_bins2": ("layer", width_bins),
        "offset_bins": ("layer", np.zeros(n_layers)),
        "substituted": ("layer", substituted.astype(np.int64)),
    }


@njit(cache=True)
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
