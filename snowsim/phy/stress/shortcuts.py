"""Shortcuts to eq. (1) that people take, kept to show where they fail: no renderer uses them."""

import dataclasses

import numpy as np

from snowsim.phy.literal import waveform_naive
from snowsim.phy.supports import find_supports
from snowsim.phy.tables import tabulated_power
from snowsim.phy.waveform import waveform_unchecked

CUT_DEVIATIONS, CUT_BINS = 5, 150  # the support that is often assumed


def naive_power(waveforms):
    """Closed form on every row as it is usually written."""
    return _summed(waveforms, waveform_naive)


def cut_power(waveforms):
    """Closed form between 5 deviations above and 150 bins below each Gaussian's centre, whatever the decay."""

    def cut(x_bins, variance_bins2, decay_rate):
        inside = (x_bins >= -CUT_DEVIATIONS * np.sqrt(variance_bins2)) & (x_bins <= CUT_BINS)
        return np.where(inside, waveform_unchecked(x_bins, variance_bins2, decay_rate), 0)

    return _summed(waveforms, cut)


def nearest_power(waveforms, n_phases=16):
    """Closed form with centres moved to the nearest of `n_phases` places a bin, as tables without interpolation do."""
    rounded = np.rint(waveforms.centre_bins * n_phases) / n_phases
    return _summed(dataclasses.replace(waveforms, centre_bins=rounded), waveform_unchecked)


def wrapped_power(waveforms):
    """Convolution of the window's columns by Fourier transforms of the window's height, without padding."""
    rows = np.arange(waveforms.n_range_bins)[:, None]
    power = np.zeros(waveforms.shape)
    for layer, lines in enumerate(np.isfinite(waveforms.centre_bins)):
        x_bins = rows - waveforms.centre_bins[layer, lines]
        gaussian = np.exp(-(x_bins**2) / (2 * waveforms.variance_bins2[layer]))
        exponential = np.exp(-waveforms.decay_rate[layer] * rows)
        exponential[0] /= 2
        spectrum = np.fft.rfft(gaussian, axis=0) * np.fft.rfft(exponential, axis=0)
        power[:, lines] += waveforms.amplitude[layer] * np.fft.irfft(spectrum, len(rows), axis=0)
    return np.maximum(power, 0)


def single_precision_power(waveforms, noise_power, error):
    """Sub-bin tables for a relative `error`, with tables and sums forced into float32; ValueError without supports."""
    supports = find_supports(waveforms, noise_power, error)
    if supports is None:
        msg = f"no support keeps a relative error of {error:g} with noise_power {noise_power:g}"
        raise ValueError(msg)
    return tabulated_power(waveforms, dataclasses.replace(supports, dtype=np.dtype(np.float32)), 0.0)


def _summed(waveforms, waveform):
    """Sum of all layers by ``waveform(x_bins, variance_bins2, decay_rate)`` on every row."""
    rows = np.arange(waveforms.n_range_bins)[:, None]
    power = np.zeros(waveforms.shape)
    for layer, lines in enumerate(np.isfinite(waveforms.centre_bins)):
        x_bins = rows - waveforms.centre_bins[layer, lines]
        one = waveform(x_bins, waveforms.variance_bins2[layer], waveforms.decay_rate[layer])
        power[:, lines] += waveforms.amplitude[layer] * one
    return power
