"""Scenes planted with eq. (1), rendered by a formula of their own."""

import numpy as np
import xarray as xr
from scipy.stats import exponnorm

BIN_SIZE_S = 2.886e-10
FIRST_TWTT_S = 1e-7


def waveform(x, variance, decay):
    """Gaussian of unit height convolved with exp(-decay x): the density of a normal plus an exponential variable."""
    sigma = np.sqrt(variance)
    return np.sqrt(2 * np.pi * variance) / decay * exponnorm.pdf(x, 1 / (sigma * decay), scale=sigma)


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


def as_frame(power, layer_bins, *, index=0, bin_size_s=BIN_SIZE_S):
    """Power and layers as datasets of the Open Polar Radar convention."""
    n_lines = layer_bins.shape[1]
    step = np.timedelta64(10, "ms")
    slow_time = np.datetime64("2012-04-29T14:00:00", "ns") + (index * n_lines + np.arange(n_lines)) * step
    along = {
        "Latitude": 75 + 4.92e-5 * np.arange(n_lines),
        "Longitude": np.full(n_lines, -45.0),
        "Elevation": np.full(n_lines, 3000.0),
        "Surface": FIRST_TWTT_S + bin_size_s * layer_bins[0],
    }
    echogram = xr.Dataset(
        {"Data": (("twtt", "slow_time"), power)} | {name: ("slow_time", value) for name, value in along.items()},
        coords={"twtt": FIRST_TWTT_S + bin_size_s * np.arange(len(power)), "slow_time": slow_time},
    )
    twtt = FIRST_TWTT_S + bin_size_s * layer_bins
    ones = np.ones(layer_bins.shape, dtype=np.int8)
    dims = ("layer", "slow_time")
    layers = xr.Dataset(
        {"twtt": (dims, twtt), "quality": (dims, ones), "type": (dims, ones)}, coords={"slow_time": slow_time}
    )
    return echogram, layers


class Planted:
    """The scene of the design: five layers, 44-bin slabs, powers 1 to .1, noise 1e-3."""

    peak_power = np.array([1, 0.3, 0.2, 0.15, 0.1])
    decay_rate = np.array([0.09, 0.07, 0.06, 0.06, 0.05])
    variance = np.full(5, 12.5)
    noise_power = 1e-3

    def power(self, layer_bins, n_range_bins, *, align="peak"):
        """Mean power, (range_bin, range_line), with the waveform's peak or its Gaussian on the layer."""
        x = np.arange(n_range_bins)[:, None]
        power = np.full((n_range_bins, layer_bins.shape[1]), self.noise_power)
        for layer, row in enumerate(layer_bins):
            shape = self.variance[layer], self.decay_rate[layer]
            offset, value = peak_of(*shape)
            lag = x - row + (offset if align == "peak" else 0)
            power += self.peak_power[layer] / value * waveform(lag, *shape)
        return power

    def flight(self, rng, *, n_frames=4, n_lines=256, n_looks=100, slab_bins=44, align="peak"):
        """Frames with slabs that vary along track and a surface that moves."""
        frames = []
        for index in range(n_frames):
            mean = slab_bins * (1 + 0.05 * rng.standard_normal((4, 1)))
            thickness = mean + np.cumsum(0.1 * rng.standard_normal((4, n_lines)), axis=1)
            surface = 50.3 + 3 * np.sin(np.arange(n_lines)[None] / 30)
            layer_bins = surface + np.concatenate([np.zeros((1, n_lines)), np.cumsum(thickness, axis=0)])
            power = self.power(layer_bins, int(layer_bins.max()) + 100, align=align)
            frames.append(as_frame(rng.gamma(n_looks, power / n_looks), layer_bins, index=index))
        return frames
