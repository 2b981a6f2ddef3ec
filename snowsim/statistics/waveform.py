"""Values by layer of the joint solution: peak powers, shapes, and waveforms about the layers."""

import numpy as np

from snowsim.phy.waveform import waveform_width
from snowsim.statistics.deblend import deblend
from snowsim.statistics.moments import mean_where
from snowsim.statistics.summaries import FIRST_ROW

LAGS = np.arange(-20, 61)  # of mean waveforms [bins below the pick]
SURE = 2.0  # standard errors that a mean power must reach


def deblended_waveform(groups, tracked_power, decay):
    """Variables by layer of the joint solution, and powers (group, layer).

    From `Groups`, mean power under the picks (layer,), 0 where there is none, and decay rates of
    eq. (2) (group, layer). A power below two standard errors, by its scatter between groups, is
    replaced by tracked power above noise, times the share that deblending leaves of the other
    layers: always positive, as only that can be rendered; such a layer is `substituted`.
    """
    fitted = deblend(groups, decay)
    powers = fitted.powers
    known = np.isfinite(powers)
    n = known.sum(axis=0)
    solved = np.nan_to_num(mean_where(known, powers, axis=0))
    squares = np.where(known, (powers - solved) ** 2, 0).sum(axis=0)
    # A single value is taken as its own scatter.
    variance_of_mean = np.where(n > 1, squares / np.maximum(n - 1, 1), solved**2)
    error = np.sqrt(variance_of_mean / np.maximum(n, 1))
    reliable = (n > 0) & (solved > SURE * error)
    above_noise = np.maximum(tracked_power - groups.noise_power, 0)
    seen = above_noise > 0
    both = reliable & seen
    share = np.median(solved[both] / above_noise[both]) if both.any() else 1.0
    stand_in = share * np.where(seen, above_noise, groups.noise_power)
    peak_power = bridged(np.where(reliable, solved, stand_in), tracked_power > 0)
    variables = {
        "peak_power": ("layer", peak_power),
        "decay_rate": ("layer", fitted.decay_rate),
        "width_bins": ("layer", waveform_width(fitted.variance, fitted.decay_rate)),
        "variance_bins2": ("layer", fitted.variance),
        "offset_bins": ("layer", fitted.offset),
        "substituted": ("layer", (~reliable).astype(np.int64)),
        "own_shape": ("layer", fitted.own_shape.astype(np.int64)),
        "mean_waveform": (("layer", "lag"), _mean_waveforms(groups)),
    }
    return variables, powers


def bridged(values, known):
    """Values by layer, unknown ones interpolated between neighbours, linearly in the logarithm."""
    held = np.flatnonzero(known)
    logarithm = np.log(np.maximum(values[held], 1e-300))
    between = np.interp(np.arange(known.size), held, logarithm)
    return np.where(known, values, np.exp(between))


def _mean_waveforms(groups):
    """Mean of averaged lines about each layer's row, (layer, lag), 0 where there is none."""
    n_rows = groups.power.shape[1]
    means = np.zeros((groups.present.shape[1], LAGS.size))
    for layer, present in enumerate(groups.present.T):
        held = np.flatnonzero(present)
        pick = np.rint(groups.position[held, layer].mean(axis=1)).astype(int)
        rows = pick[:, None] - FIRST_ROW + LAGS
        lines = groups.power[held[:, None], np.clip(rows, 0, n_rows - 1)]
        seen = (rows >= 0) & (rows < n_rows) & np.isfinite(lines)
        means[layer] = np.nan_to_num(mean_where(seen, lines.astype(float), axis=0))
    return means
