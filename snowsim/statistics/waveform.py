"""Values by layer of the joint solution: peak powers, shapes, and waveforms about the layers."""

import numpy as np
import pandas as pd

from snowsim.statistics.deblend import deblend
from snowsim.statistics.moments import known_mean
from snowsim.statistics.summaries import FIRST_ROW, rows_from

LAGS = np.arange(-20, 61)  # of mean waveforms [bins below the pick]
LEAST_ERRORS = 2.0  # standard errors that a mean power must reach


def deblended_waveform(groups, tracked_power, decay):
    """Variables by layer of the joint solution, and powers (group, layer).

    From `Groups`, mean power under the picks (layer,), 0 where there is none, and decay rates of
    eq. (2) (group, layer). A power below two standard errors, by its scatter between groups, is
    replaced by tracked power above noise, times the share that deblending leaves of the other
    layers: always positive, as only that can be rendered; such a layer is `substituted`.
    """
    variables, powers = deblend(groups, decay)
    by_layer = pd.DataFrame(powers)
    solved = by_layer.mean().to_numpy()
    # A single value has no error, and is not reliable.
    reliable = solved > LEAST_ERRORS * by_layer.sem().to_numpy()
    above_noise = np.maximum(tracked_power - groups.noise_power, 0)
    seen = above_noise > 0
    both = reliable & seen
    share = np.median(solved[both] / above_noise[both]) if both.any() else 1.0
    stand_in = share * np.where(seen, above_noise, groups.noise_power)
    peak_power = bridged(np.where(reliable, solved, stand_in), tracked_power > 0)
    variables |= {
        "peak_power": ("layer", peak_power),
        "substituted": ("layer", (~reliable).astype(np.int64)),
        "mean_waveform": (("layer", "lag"), _mean_waveforms(groups)),
    }
    return variables, powers


def bridged(values, known):
    """Values by layer, unknown ones interpolated between neighbours, linearly in the logarithm."""
    logarithm = pd.Series(np.log(np.where(known, values, np.nan)))
    return np.exp(logarithm.interpolate(limit_direction="both").to_numpy())


def _mean_waveforms(groups):
    """Mean of averaged lines about each layer's row, (layer, lag), 0 where there is none."""
    means = []
    for row, present in zip(groups.row.T, groups.present.T, strict=True):
        first = np.rint(row[present]).astype(int) - FIRST_ROW + LAGS[0]
        lines = rows_from(groups.power[present], first, LAGS.size)
        means.append(known_mean(lines.astype(float), axis=0))
    return np.nan_to_num(means)
