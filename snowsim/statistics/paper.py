"""The paper's estimators as printed.

Tracked-bin powers, eq. (2) decay rates and 1/e widths of averaged range lines.
"""

import numpy as np
import pandas as pd

from snowsim.limits import check_count
from snowsim.statistics.moments import known_mean
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
    picked = tracked_power > 0
    means = pd.DataFrame({"decay": known_mean(decay, axis=0), "width": known_mean(width, axis=0)})
    if len(means) > 1:
        what = "averaged lines whose power falls to 1/e between two layers"
        check_count(what, np.isfinite(decay).sum())
    unknown = means.isna()
    unknown.iloc[-1, 0] = False
    nearest = means.ffill().bfill()
    nearest.iloc[-1, 0] = np.nan
    substituted = ~picked | unknown.any(axis=1)
    return {
        "peak_power": ("layer", bridged(tracked_power, picked)),
        "decay_rate": ("layer", nearest["decay"].to_numpy()),
        "width_bins": ("layer", nearest["width"].to_numpy()),
        "variance_bins2": ("layer", nearest["width"].to_numpy()),
        "offset_bins": ("layer", np.zeros(len(means))),
        "substituted": ("layer", substituted.astype(np.int64)),
    }


def measure_groups(groups):
    """Decay rate [per bin] and 1/e width from the peak [bins], two (group, layer).

    Of every layer in every averaged line of `Groups`. Yari et al. (2021), eq. (2): ``alpha =
    -log(P_min / P_peak) / b`` with `b` bins from the peak, the largest value within
    `PEAK_REACH_BINS` of the layer and half way to its neighbours, to the minimum before the next
    layer; NaN where either layer is absent or no minimum lies between. The 1/e crossing is
    interpolated linearly; NaN where the power does not fall so far before the minimum.
    """
    present = groups.present
    decay_rate = np.full(present.shape, np.nan)
    width = np.full(present.shape, np.nan)
    rows = np.where(present, np.rint(groups.row) - FIRST_ROW, np.nan)
    above = np.diff(rows, prepend=np.nan)
    below = np.diff(rows, append=np.nan)
    start = np.maximum(rows - np.fmin(PEAK_REACH_BINS, above // 2), 0)
    end = rows + np.where(np.isfinite(below), below, OPEN_END_BINS)
    end = np.minimum(end, groups.power.shape[1] - 1)
    middle = rows + np.minimum(PEAK_REACH_BINS, (end - rows) // 2)
    bounds = np.stack([start, middle, end], axis=2)
    for group, layer in np.argwhere(present):
        line = groups.power[group]
        first, last, end = bounds[group, layer].astype(int)
        window = line[first : last + 1]
        if not np.isfinite(window).any():
            continue
        peak = first + np.nanargmax(window)
        fall = line[peak : end + 1]
        lowest = np.nanargmin(fall)
        if np.isfinite(below[group, layer]) and 0 < fall[lowest] < fall[0]:
            decay_rate[group, layer] = -np.log(fall[lowest] / fall[0]) / lowest
        target = fall[0] / np.e
        reached = np.flatnonzero(fall[: lowest + 1] <= target)
        if reached.size:
            at = reached[0]
            width[group, layer] = at - (target - fall[at]) / (fall[at - 1] - fall[at])
    return decay_rate, width
