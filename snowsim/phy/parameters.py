"""Input of eq. (1): a scene's layers and their parameters, checked once."""

from dataclasses import dataclass

import numpy as np

from snowsim.echogram import check_choice, check_layer_bins
from snowsim.phy.waveform import waveform_peak

NORMALISE = ("peak", "none")
ALIGN = ("peak", "gaussian")

# Rounding of the closed form [dB]: `waveform_exact` to 1e-12, amplitudes and sums to a few more.
EXACT_BOUND_DB = 1e-11


@dataclass(frozen=True)
class Waveforms:
    """One scene's layers as the terms of eq. (1), ``P_s = sum_l amplitude_l w_l(x - centre_l)``.

    `centre_bins` (layer, range_line) are centres of the Gaussians, NaN where the layer is absent.
    By layer: `amplitude` [power per bin], `variance_bins2` and `decay_rate` [per bin] of the
    waveform, how far it peaks below its centre, `peak_offset_bins`, and its power there,
    `peak_power`. `n_range_bins` is the height of the window. If powers vary along track, those by
    layer are the largest, and `line_share` (layer, range_line) is the share of that, 0 to 1.
    """

    centre_bins: np.ndarray
    amplitude: np.ndarray
    variance_bins2: np.ndarray
    decay_rate: np.ndarray
    peak_offset_bins: np.ndarray
    peak_power: np.ndarray
    n_range_bins: int
    line_share: np.ndarray | None = None

    @property
    def shape(self):
        """(range_bin, range_line) of the window."""
        return self.n_range_bins, self.centre_bins.shape[1]


def checked_waveforms(
    layer_bins, peak_power, variance_bins2, decay_rate, n_range_bins, normalise, align
):
    """`Waveforms` from the arguments of `mean_power`.

    ValueError with name, value and position for values of wrong shape or sign, layers that cross,
    unknown options, and powers whose sum overflows.
    """
    layer_bins = np.asarray(layer_bins, dtype=float)
    check_layer_bins(layer_bins)
    check_choice("normalise", normalise, NORMALISE)
    check_choice("align", align, ALIGN)
    n_layers = layer_bins.shape[0]
    line_share = None
    if np.ndim(peak_power) == 2:
        peak_power, line_share = _largest_and_share(peak_power, layer_bins)
    peak_power = _per_layer("peak_power", peak_power, n_layers)
    variance_bins2 = _per_layer("variance_bins2", variance_bins2, n_layers)
    decay_rate = _per_layer("decay_rate", decay_rate, n_layers)
    offset_bins, unit_peak = waveform_peak(variance_bins2, decay_rate)
    with np.errstate(over="ignore"):
        amplitude = peak_power / unit_peak if normalise == "peak" else peak_power
        reached = amplitude * unit_peak
        total = amplitude.sum() + reached.sum()
    if not np.isfinite(total):
        strongest = peak_power.argmax()
        msg = "peak_power must add up to a finite power, "
        msg += f"got {peak_power[strongest]:g} at layer {strongest}"
        raise ValueError(msg)
    centre_bins = layer_bins - offset_bins[:, None] if align == "peak" else layer_bins
    return Waveforms(
        centre_bins=centre_bins,
        amplitude=amplitude,
        variance_bins2=variance_bins2,
        decay_rate=decay_rate,
        peak_offset_bins=offset_bins,
        peak_power=reached,
        n_range_bins=checked_height(n_range_bins),
        line_share=line_share,
    )


def checked_height(n_range_bins):
    """Height of a window as int; ValueError unless it is a whole number of at least one."""
    whole = np.isscalar(n_range_bins) and n_range_bins == np.floor(n_range_bins)
    if not (whole and 1 <= n_range_bins < 2**31):
        msg = f"n_range_bins must be a whole number of at least 1, got {n_range_bins!r}"
        raise ValueError(msg)
    return int(n_range_bins)


def checked_power(name, value):
    """A power as float; ValueError unless it is finite and not negative."""
    value = float(value)
    if not (value >= 0 and np.isfinite(value)):
        msg = f"{name} must be finite and not negative, got {value}"
        raise ValueError(msg)
    return value


def checked_tolerance(tolerance_db):
    """A tolerance [dB] as float, or None; ValueError unless the closed form can keep it."""
    if tolerance_db is None:
        return None
    tolerance_db = float(tolerance_db)
    if not (tolerance_db > 0 and np.isfinite(tolerance_db)):
        msg = f"tolerance_db must be positive and finite, or None for exact, got {tolerance_db}"
        raise ValueError(msg)
    if tolerance_db < EXACT_BOUND_DB:
        msg = f"tolerance_db must be at least {EXACT_BOUND_DB:g}, the rounding of the closed form, "
        msg += f"got {tolerance_db}"
        raise ValueError(msg)
    return tolerance_db


def _per_layer(name, value, n_layers):
    array = np.asarray(value, dtype=float)
    if array.shape != (n_layers,):
        msg = f"{name}: expected one value for each of {n_layers} layers, got shape {array.shape}"
        raise ValueError(msg)
    if name == "peak_power":
        wanted = "finite and not negative"
        valid = array >= 0
    else:
        wanted = "finite and positive"
        valid = array > 0
    bad = ~(valid & np.isfinite(array))
    if bad.any():
        layer = int(np.argmax(bad))
        msg = f"{name} must be {wanted}, got {array[layer]} at layer {layer}"
        raise ValueError(msg)
    return array


def _largest_and_share(peak_power, layer_bins):
    """Largest power of each layer, (layer,), and shares by range line; zero where absent."""
    power = np.asarray(peak_power, dtype=float)
    if power.shape != layer_bins.shape:
        msg = f"peak_power: expected (layer,) or the shape of the layers, {layer_bins.shape}, "
        msg += f"got {power.shape}"
        raise ValueError(msg)
    present = np.isfinite(layer_bins)
    bad = present & ~(np.isfinite(power) & (power >= 0))
    if bad.any():
        layer, line = np.argwhere(bad)[0]
        msg = "peak_power must be finite and not negative, "
        msg += f"got {power[layer, line]} at layer {layer}, line {line}"
        raise ValueError(msg)
    power = np.where(present, power, 0)
    largest = power.max(axis=1, initial=0)
    return largest, power / np.where(largest > 0, largest, 1)[:, None]
