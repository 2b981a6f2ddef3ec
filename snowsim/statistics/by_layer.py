"""Values by layer of either estimator.

Means over averaged lines, substitutes where there are none, mean waveforms.
"""

import numpy as np

from snowsim.limits import check_count
from snowsim.phy.waveform import waveform_exact, waveform_width
from snowsim.statistics.deblend import deblend
from snowsim.statistics.lines import describe
from snowsim.statistics.moments import Moments, mean_where, nan_moments
from snowsim.statistics.summaries import FIRST_ROW

LAGS = np.arange(-20, 61)  # of mean waveforms [bins below the pick]
SMALL_CHANGE = 1e-4  # of decay rate and variance, relative, for the slope of the width


def paper_values(tracked, decay, width):
    """Values by layer of the recipe as printed.

    Its 1/e width stands for a variance, as in the paper.

    From `Tracked` power, and decay rates and widths (group, layer).
    """
    picked = tracked.n_picks > 0
    # Eq. (2) needs a layer below: the deepest has no decay rate.
    decay = _with_substitutes(decay[:, :-1])
    width = _with_substitutes(width)
    substituted = (width.n == 0) | np.append(decay.n == 0, False) | ~picked
    return {
        "peak_power": _bridged(tracked.power, picked),
        "peak_power_standard_error": _bridged(tracked.standard_error, picked),
        "decay_rate": np.append(decay.mean, np.nan),
        "decay_rate_standard_error": np.append(decay.standard_error, np.nan),
        "width_bins": width.mean,
        "width_bins_standard_error": width.standard_error,
        "variance_bins2": width.mean,
        "variance_bins2_standard_error": width.standard_error,
        "offset_bins": np.zeros(picked.size),
        "offset_bins_standard_error": np.zeros(picked.size),
        "substituted": substituted.astype(np.int64),
    }


def deblended_values(tracked, decay, groups):
    """Values by layer of the joint solution, with mean waveforms; and powers (group, layer)."""
    fitted = deblend(groups, decay)
    waveform = describe(fitted.shape)
    decay_error, variance_error, offset_error = fitted.shape_error.T
    power, power_error, reliable = _visible_powers(fitted, tracked, groups.noise_power)
    picked = tracked.n_picks > 0
    power = _bridged(power, picked)
    width, width_error = _widths(waveform, decay_error, variance_error)
    observed, modelled = _mean_waveforms(groups, fitted.modelled)
    lag = LAGS - (waveform.offset - waveform.peak)[:, None]
    alone = waveform_exact(lag, waveform.variance[:, None], waveform.decay[:, None])
    values = {
        "peak_power": power,
        "peak_power_standard_error": _bridged(power_error, picked),
        "decay_rate": waveform.decay,
        "decay_rate_standard_error": waveform.decay * decay_error,
        "width_bins": width,
        "width_bins_standard_error": width_error,
        "variance_bins2": waveform.variance,
        "variance_bins2_standard_error": waveform.variance * variance_error,
        "offset_bins": waveform.offset,
        "offset_bins_standard_error": offset_error,
        "substituted": (~reliable).astype(np.int64),
        "own_shape": fitted.own_shape.astype(np.int64),
        "mean_waveform": observed,
        "model_waveform": modelled,
        "layer_waveform": power[:, None] * alone / waveform.height[:, None],
    }
    return values, fitted.powers


def _visible_powers(fitted, tracked, noise_power):
    """Peak powers, their standard errors, and where they are the solution's own, three (layer,).

    Powers below two standard errors are replaced by tracked power above noise, times the share
    that deblending leaves of the other layers: always positive, as only that can be rendered.
    """
    solved = nan_moments(fitted.powers)
    reliable = (solved.n > 0) & (solved.mean > 2 * fitted.power_error)
    above_noise = np.maximum(tracked.power - noise_power, 0)
    seen = above_noise > 0
    share = 1.0
    if (reliable & seen).any():
        share = np.median(solved.mean[reliable] / above_noise[reliable])
    stand_in = share * np.where(seen, above_noise, tracked.standard_error + noise_power)
    power = np.where(reliable, solved.mean, stand_in)
    error = np.where(reliable, fitted.power_error, np.maximum(fitted.power_error, stand_in))
    return power, error, reliable


def _widths(waveform, decay_error, variance_error):
    """Widths and their standard errors, from those of log decay rate and log variance."""
    variance, decay = waveform.variance, waveform.decay
    width = waveform_width(variance, decay)
    by_decay = waveform_width(variance, decay * (1 + SMALL_CHANGE)) - width
    by_variance = waveform_width(variance * (1 + SMALL_CHANGE), decay) - width
    of_decay = by_decay / SMALL_CHANGE * decay_error
    of_variance = by_variance / SMALL_CHANGE * variance_error
    return width, np.hypot(of_decay, of_variance)


def _bridged(values, known):
    """Values by layer, unknown ones interpolated between neighbours, linearly in the logarithm."""
    held = np.flatnonzero(known)
    logarithm = np.log(np.maximum(values[held], 1e-300))
    between = np.interp(np.arange(known.size), held, logarithm)
    return np.where(known, values, np.exp(between))


def _with_substitutes(values):
    """`Moments` by layer; one without values takes those of the one above (or below), n stays 0."""
    own = nan_moments(values)
    held = np.flatnonzero(own.n)
    if own.n.size:
        check_count("averaged lines whose power falls to 1/e between two layers", held.size)
    nearest = np.searchsorted(held, np.arange(own.n.size), side="right") - 1
    source = held[np.maximum(nearest, 0)]
    return Moments(own.mean[source], own.standard_error[source], own.n)


def _mean_waveforms(groups, modelled):
    """Mean of averaged lines about each layer's row, observed and modelled, two (layer, lag).

    They are 0 where there is none.
    """
    n_rows = groups.power.shape[1]
    means = np.zeros((2, groups.present.shape[1], LAGS.size))
    for layer, present in enumerate(groups.present.T):
        held = np.flatnonzero(present)
        pick = np.rint(groups.position[held, layer].mean(axis=1)).astype(int)
        rows = pick[:, None] - FIRST_ROW + LAGS
        inside = (rows >= 0) & (rows < n_rows)
        at = held[:, None], np.clip(rows, 0, n_rows - 1)
        lines = np.array([groups.power[at], modelled[at]])
        # Observed and modelled over the same samples, so that the two can be compared.
        known = inside & np.isfinite(lines).all(axis=0)
        for total, part in zip(means[:, layer], lines, strict=True):
            total[:] = np.nan_to_num(mean_where(known, part, axis=0))
    return means
