"""Scenes planted with eq. (1), rendered by a formula of their own.

No code is shared with what is tested.
"""

from functools import cached_property

import numpy as np
from made_up import made_up_frame
from scipy.ndimage import gaussian_filter1d
from scipy.stats import exponnorm


def gaussian_series(shape, sd, length_lines, rng):
    """Gaussian series (..., range_line) of autocorrelation ``exp(-(h / length)^2)``."""
    margin = 4 * length_lines
    white = rng.standard_normal((*shape[:-1], shape[-1] + 2 * margin))
    smooth = gaussian_filter1d(white, length_lines / 2)[..., margin:-margin]
    return sd * smooth * np.sqrt(length_lines * np.sqrt(np.pi))


def waveform(x, variance, decay):
    """Gaussian of unit height convolved with exp(-decay x).

    The density of a normal plus an exponential variable.
    """
    sigma = np.sqrt(variance)
    density = exponnorm.pdf(x, 1 / (sigma * decay), scale=sigma)
    return np.sqrt(2 * np.pi * variance) / decay * density


def peak_of(variance, decay):
    """Row of the largest value and that value, by search on a grid of 1e-3 bins."""
    x = np.arange(-5, 30, 1e-3)
    values = waveform(x, variance, decay)
    return x[values.argmax()], values.max()


def width_of(variance, decay):
    """Bins from the peak to 1/e, by search on the same grid."""
    x = np.arange(-5, 80, 1e-3)
    values = waveform(x, variance, decay)
    return x[values > values.max() / np.e][-1] - x[values.argmax()]


LAGS = np.arange(-120, 800, 1 / 256)


class Planted:
    """The scene of the design: five layers, 44-bin slabs, powers 1 to .1, noise 1e-3."""

    peak_power = np.array([1, 0.3, 0.2, 0.15, 0.1])
    decay_rate = np.array([0.09, 0.07, 0.06, 0.06, 0.05])
    variance_bins2 = np.full(5, 12.5)
    noise_power = 1e-3

    def of_each(self, function):
        """A function of variance and decay rate, by layer."""
        shapes = zip(self.variance_bins2, self.decay_rate, strict=True)
        return [function(*shape) for shape in shapes]

    def level(self):
        """Mean power and rows of layers that are level, 256 range lines."""
        layer_bins = np.repeat(50 + 44.0 * np.arange(5)[:, None], 256, axis=1)
        return self.power(layer_bins, 360), layer_bins

    def power(self, layer_bins, n_range_bins, *, align="peak"):
        """Mean power, (range_bin, range_line), with waveform's peak or Gaussian on the layer."""
        power = np.full((n_range_bins, layer_bins.shape[1]), self.noise_power)
        rows = np.arange(n_range_bins)[:, None]
        layers = zip(layer_bins, self.peak_power, self.tables, strict=False)
        for row, peak_power, (table, offset) in layers:
            lag = rows - row + (offset if align == "peak" else 0)
            power += peak_power * np.interp(lag, LAGS, table)
        return power

    @cached_property
    def tables(self):
        """Waveforms of unit peak at `LAGS`, straight between them to 1e-7, and rows of the peak."""
        tables = self.of_each(lambda *shape: waveform(LAGS, *shape))
        peaks = self.of_each(peak_of)
        return [(table / value, row) for table, (row, value) in zip(tables, peaks, strict=True)]

    def flight(self, rng, *, n_frames=4, n_looks=100, align="peak"):
        """Frames with slabs that vary along track and a surface that moves."""
        frames = []
        for index in range(n_frames):
            mean = 44 * (1 + 0.05 * rng.standard_normal((4, 1)))
            thickness = mean + np.cumsum(0.1 * rng.standard_normal((4, 256)), axis=1)
            surface = 50.3 + 3 * np.sin(np.arange(256)[None] / 30)
            depth = np.concatenate([np.zeros((1, 256)), np.cumsum(thickness, axis=0)])
            layer_bins = surface + depth
            power = self.power(layer_bins, int(layer_bins.max()) + 100, align=align)
            seen = rng.gamma(n_looks, power / n_looks)
            frames.append(made_up_frame(seen, layer_bins, minute=index))
        return frames


class Alike(Planted):
    """The same scene with one decay rate for all buried layers, as the fit has it."""

    decay_rate = np.array([0.09, 0.06, 0.06, 0.06, 0.06])
