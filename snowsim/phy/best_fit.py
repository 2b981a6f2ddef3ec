"""The waveform of eq. (1) that fits a given mean echo best, and how far from it that remains."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from snowsim.phy.waveform import SAFE_RANGE, waveform_exact

MOST_SAMPLES = 150  # of a tail that are fitted: it is smooth


@dataclass(frozen=True)
class WaveformFit:
    """Best fit of eq. (1) to an echo.

    Attributes
    ----------
    offset_bins, variance_bins2, decay_rate, amplitude : float
        ``amplitude * w(x - offset_bins)`` with the Gaussian's variance and the exponential's rate.
    rms_db, largest_db : float
        Error over the tail fitted.
    n_bins : float
        Length of that tail.
    """

    offset_bins: float
    variance_bins2: float
    decay_rate: float
    amplitude: float
    rms_db: float
    largest_db: float
    n_bins: float

    def power(self, x_bins):
        """The fitted waveform at positions [bins]."""
        x_bins = np.asarray(x_bins, dtype=float) - self.offset_bins
        return self.amplitude * waveform_exact(x_bins, self.variance_bins2, self.decay_rate)


def fit_waveform(x_bins, power, tail_db):
    """Fit eq. (1) to the tail of a mean echo, least squares in decibels.

    Parameters
    ----------
    x_bins : array_like, (sample,)
        Increasing positions in fast time [bins], finer than the waveform is wide.
    power : array_like, (sample,)
        Mean power without noise.
    tail_db : float
        The tail reaches from the peak to where power has first fallen by this much below it.

    Returns
    -------
    WaveformFit

    Raises
    ------
    ValueError
        If arrays do not fit, power is not finite or negative, or the tail has fewer than six samples or no end.

    Notes
    -----
    Four numbers are free: where the Gaussian lies, its variance, the decay rate and the amplitude. The samples before
    the peak are left to the eye: what they show is the range response, which eq. (1) takes as a Gaussian.
    """
    x_bins, power = np.asarray(x_bins, dtype=float), np.asarray(power, dtype=float)
    if x_bins.shape != power.shape or power.ndim != 1 or not (np.isfinite(power) & (power >= 0)).all():
        msg = f"expected positions and powers, finite and not negative, got shapes {x_bins.shape} and {power.shape}"
        raise ValueError(msg)
    top = int(power.argmax())
    below = np.flatnonzero(power[top:] < power[top] * 10 ** (-tail_db / 10))
    if not below.size or below[0] < 6:
        msg = f"the tail must have six samples and fall by {tail_db:g} dB, has {below[0] if below.size else 'no end'}"
        raise ValueError(msg)
    tail = slice(top, top + int(below[0]), 1 + int(below[0]) // MOST_SAMPLES)
    x, level_db = x_bins[tail] - x_bins[top], 10 * np.log10(power[tail] / power[top])

    def residual(parameters):
        offset, log_variance, log_decay, amplitude_db = parameters
        wave = waveform_exact(x - offset, np.exp(log_variance), np.exp(log_decay))
        return 10 * np.log10(np.maximum(wave, 1e-300)) + amplitude_db - level_db

    decay = tail_db * np.log(10) / 10 / x[-1]
    low, high = (np.log(bounds) for bounds in zip(*SAFE_RANGE.values(), strict=True))
    # Several starts: the cost has side valleys where a wide Gaussian stands in for a slow decay.
    starts = [(-1.0, np.log(v), np.log(factor * decay), 0.0) for v in (0.3, 10.0) for factor in (0.3, 1)]
    limits = ([-np.inf, low[0], low[1], -np.inf], [np.inf, high[0], high[1], np.inf])
    fits = [least_squares(residual, start, bounds=limits, xtol=1e-12, ftol=1e-12) for start in starts]
    best = min(fits, key=lambda fit: fit.cost)
    offset, log_variance, log_decay, amplitude_db = best.x
    return WaveformFit(
        offset_bins=float(x_bins[top] + offset),
        variance_bins2=float(np.exp(log_variance)),
        decay_rate=float(np.exp(log_decay)),
        amplitude=float(power[top] * 10 ** (amplitude_db / 10)),
        rms_db=float(np.sqrt(np.mean(best.fun**2))),
        largest_db=float(np.abs(best.fun).max()),
        n_bins=float(x[-1] - x[0]),
    )
