"""Input of eq. (1): a scene's layers and their parameters, checked once."""

from dataclasses import dataclass

import numpy as np

from snowsim.echogram import check_choice, check_layer_bins
from snowsim.limits import check_count, check_values
from snowsim.phy.waveform import SAFE_RANGE, waveform_peak

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

    ValueError with name, value and position for values of wrong shape or sign, layers that cross
    and unknown options.
    """
    layer_bins = np.asarray(layer_bins, dtype=float)
    check_layer_bins(layer_bins)
    check_choice("normalise", normalise, NORMALISE)
    check_choice("align", align, ALIGN)
    check_count("n_range_bins", n_range_bins)
    given = {
        "peak_power": np.asarray(peak_power, dtype=float),
        "variance_bins2": np.asarray(variance_bins2, dtype=float),
        "decay_rate": np.asarray(decay_rate, dtype=float),
    }
    varies = given["peak_power"].shape == layer_bins.shape
    if varies:
        # Where a layer is absent, its power may be NaN.
        given["peak_power"] = np.where(np.isfinite(layer_bins), given["peak_power"], 0)
    for name, values in given.items():
        shape = layer_bins.shape if varies and name == "peak_power" else layer_bins.shape[:1]
        if values.shape != shape:
            msg = f"{name}: expected one value for each of {len(layer_bins)} layers, "
            msg += f"got shape {values.shape}"
            raise ValueError(msg)
        check_values(name, values, *SAFE_RANGE.get(name, (0.0,)))
    peak_power = given["peak_power"]
    line_share = None
    if varies:
        largest = peak_power.max(axis=1, initial=0)
        line_share = peak_power / np.where(largest > 0, largest, 1)[:, None]
        peak_power = largest
    offset_bins, unit_peak = waveform_peak(given["variance_bins2"], given["decay_rate"])
    with np.errstate(over="ignore"):
        amplitude = peak_power / unit_peak if normalise == "peak" else peak_power
        total = amplitude.sum() + (amplitude * unit_peak).sum()
    check_values("peak_power: the sum over layers", total)
    centre_bins = layer_bins - offset_bins[:, None] if align == "peak" else layer_bins
    return Waveforms(
        centre_bins=centre_bins,
        amplitude=amplitude,
        variance_bins2=given["variance_bins2"],
        decay_rate=given["decay_rate"],
        peak_offset_bins=offset_bins,
        peak_power=amplitude * unit_peak,
        n_range_bins=int(n_range_bins),
        line_share=line_share,
    )
