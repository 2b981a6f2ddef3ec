"""Smooth random series along track."""

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.signal import oaconvolve


def draw_along_track(n_series, n_lines, correlation_lines, *, rng):
    """Draw smooth stationary series of zero mean and unit variance, (series, range_line).

    Their correlation is Gaussian, ``exp(-(lag / correlation_lines)^2)``. Series are white if
    `correlation_lines` is below .5.
    """
    # White noise, smoothed by a Gaussian of standard deviation s, has the correlation length 2 s.
    width = correlation_lines / 2
    margin = int(np.ceil(4 * width))
    noise = rng.standard_normal((n_series, n_lines + 2 * margin))
    if n_series == 0:  # oaconvolve would lose the number of range lines
        return noise[:, :n_lines]
    taps = gaussian_taps(width, margin)
    unit = taps / np.sqrt((taps**2).sum())
    return oaconvolve(noise, unit[None], mode="valid", axes=1)


def gaussian_taps(sd, reach):
    """Weights of a Gaussian mean over `reach` samples to either side, (2 reach + 1,)."""
    impulse = np.zeros(2 * reach + 1)
    impulse[reach] = 1
    return gaussian_filter1d(impulse, sd, mode="constant")
