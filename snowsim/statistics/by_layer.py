"""Values by layer of either estimator: means over averaged lines, substitutes where there are none, mean waveforms."""

from dataclasses import dataclass

import numpy as np

from snowsim.phy.waveform import waveform_exact, waveform_peak, waveform_width
from snowsim.statistics.deblend import deblend
from snowsim.statistics.paper import nan_moments
from snowsim.statistics.summaries import FIRST_ROW

LAGS = np.arange(-20, 61)  # of mean waveforms [bins below the pick]


@dataclass(frozen=True)
class Measured:
    """What is read off averaged lines: tracked power with error and count (layer,), decay and width (group, layer)."""

    tracked_power: np.ndarray
    tracked_error: np.ndarray
    n_picks: np.ndarray
    decay: np.ndarray
    width: np.ndarray


def paper_values(measured):
    """Values by layer of the recipe as printed; its 1/e width stands for a variance, as in the paper."""
    decay, decay_error, no_decay = _layer_means(measured.decay[:, :-1])
    width, width_error, no_width = _layer_means(measured.width)
    values = {
        "peak_power": _bridged(
            measured.tracked_power, measured.tracked_error, measured.n_picks > 0
        ),
        "decay_rate": (np.append(decay, np.nan), np.append(decay_error, np.nan)),
        **dict.fromkeys(("width_bins", "variance_bins2"), (width, width_error)),
        "offset_bins": np.zeros((2, width.size)),
    }
    substituted = no_width | np.append(no_decay, False) | (measured.n_picks == 0)
    return _with_errors(values) | {"substituted": substituted.astype(np.int64)}


def deblended_values(measured, groups):
    """Values by layer of the joint solution, with mean waveforms; and powers (group, layer)."""
    shape, error, powers, power_error, own_shape, modelled = deblend(groups, measured.decay)
    decay, variance = np.exp(shape[:, 0]), np.exp(shape[:, 1])
    power, _, n_groups = nan_moments(powers)
    reliable = (n_groups > 0) & (power > 2 * power_error)
    above_noise = np.maximum(measured.tracked_power - groups.noise_power, 0)
    # Faint layers keep the share that deblending leaves of the others, always positive: only that
    # can be rendered.
    share = (
        np.median(power[reliable] / above_noise[reliable])
        if (reliable & (above_noise > 0)).any()
        else 1.0
    )
    floor = np.where(above_noise > 0, above_noise, measured.tracked_error + groups.noise_power)
    peak_power = _bridged(
        np.where(reliable, power, share * floor),
        np.where(reliable, power_error, np.maximum(power_error, share * floor)),
        measured.n_picks > 0,
    )
    width = waveform_width(variance, decay)
    width_error = np.hypot(
        (waveform_width(variance, decay * (1 + 1e-4)) - width) / 1e-4 * error[:, 0],
        (waveform_width(variance * (1 + 1e-4), decay) - width) / 1e-4 * error[:, 1],
    )
    observed, modelled = _mean_waveforms(groups, modelled)
    peak_offset, peak_value = waveform_peak(variance, decay)
    lag = LAGS - (shape[:, 2] - peak_offset)[:, None]
    alone = (
        peak_power[0][:, None]
        * waveform_exact(lag, variance[:, None], decay[:, None])
        / peak_value[:, None]
    )
    values = {
        "peak_power": peak_power,
        "decay_rate": (decay, decay * error[:, 0]),
        "width_bins": (width, width_error),
        "variance_bins2": (variance, variance * error[:, 1]),
        "offset_bins": (shape[:, 2], error[:, 2]),
    }
    return _with_errors(values) | {
        "substituted": (~reliable).astype(np.int64),
        "own_shape": own_shape.astype(np.int64),
        "mean_waveform": observed,
        "model_waveform": modelled,
        "layer_waveform": alone,
    }, powers


def _with_errors(values):
    """Values and their standard errors, each under a name of its own."""
    return {
        f"{name}{end}": v
        for name, both in values.items()
        for end, v in zip(("", "_standard_error"), both, strict=True)
    }


def _bridged(power, error, known):
    """Power and error, with unknown layers interpolated between their neighbours, linearly in the logarithm."""
    layers, held = np.arange(known.size), np.flatnonzero(known)
    return tuple(
        np.where(
            known, values, np.exp(np.interp(layers, held, np.log(np.maximum(values[held], 1e-300))))
        )
        for values in (power, error)
    )


def _layer_means(values):
    """Mean and standard error over groups, and which layers have none and take that of the layer above (or below)."""
    mean, error, n = nan_moments(values)
    held = np.flatnonzero(n > 0)
    if values.shape[1] and held.size == 0:
        msg = "decay rates and widths need power that falls to 1/e between two layers, no averaged line has that"
        raise ValueError(msg)
    above = np.maximum.accumulate(np.where(n > 0, np.arange(n.size), -1))
    source = np.where(above >= 0, above, held[0] if held.size else 0)
    return mean[source], error[source], n == 0


def _mean_waveforms(groups, model):
    """Mean of averaged lines about each layer's row, observed and modelled, two (layer, lag); 0 where there is none."""
    n_rows = groups.power.shape[1]
    observed, modelled = (np.zeros((groups.present.shape[1], LAGS.size)) for _ in range(2))
    for layer in range(len(observed)):
        held = np.flatnonzero(groups.present[:, layer])
        rows = (
            np.rint(groups.position[held, layer].mean(axis=1)).astype(int)[:, None]
            - FIRST_ROW
            + LAGS
        )
        inside = (rows >= 0) & (rows < n_rows)
        at = held[:, None], np.clip(rows, 0, n_rows - 1)
        # Observed and modelled over the same samples, so that the two can be compared.
        known = inside & np.isfinite(groups.power[at]) & np.isfinite(model[at])
        n = np.maximum(known.sum(axis=0), 1)
        for total, lines in ((observed, groups.power), (modelled, model)):
            total[layer] = np.where(known, lines[at], 0).sum(axis=0, dtype=float) / n
    return observed, modelled
