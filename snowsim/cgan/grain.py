"""Grain: noise with the statistics of what a generator's images lack beside observed ones."""

from functools import lru_cache

import numpy as np
import torch
from scipy.signal import lfilter
from torch import nn

N_WEIGHTS = 5  # [range bins] of the filter
# Range lines and bins over which the correlation of the texture of snow falls to 1/e.
TEXTURE_LINES, TEXTURE_BINS = 2.5, 6.0
# Unit of the texture's size, which is then as large as the filter's weights and learns as fast.
UNIT = 10.0
# Distances of the pixels whose covariances are compared.
GRAIN_DISTANCES = (1, 2, 4, 16, 48)  # [range lines]
GRAIN_LAGS = (0, 1, 2, 3, 4, 8, 16, 32)  # [range bins]


class Grain(nn.Module):
    """Noise to be added to images, in the scale of these, (patch, 1, range_bin, range_line).

    White noise, which stands for speckle, and in snow a correlated texture of some size, filtered
    down range by `N_WEIGHTS` weights; and a gain for each range line. White noise ``w`` is first
    skewed, ``w + s (w**2 - 1) / sqrt(2)``: speckle in decibels is not Gaussian.
    """

    def __init__(self):
        super().__init__()
        size = (N_WEIGHTS, 1)
        self.filter = nn.Conv2d(1, 1, size, padding=(N_WEIGHTS // 2, 0), bias=False)
        self.size = nn.Parameter(torch.zeros(1, 1))
        self.gain = nn.Parameter(torch.zeros(1, 1))
        self.skew = nn.Parameter(torch.zeros(1, 1))

    def draw(self, is_snow, *, rng):
        """Noise of one pass, a dict of tensors, for `is_snow` (patch, range_bin, range_line)."""
        n_patches, n_range_bins, n_range_lines = is_snow.shape
        shape = (n_patches, 2, n_range_bins, n_range_lines)
        noise = rng.standard_normal(shape, dtype=np.float32)
        along = correlated(noise[:, 1], TEXTURE_LINES, axis=2)
        texture = correlated(along, TEXTURE_BINS, axis=1)
        noise[:, 1] = texture * is_snow
        shape = (n_patches, 1, 1, n_range_lines)
        gains = rng.standard_normal(shape, dtype=np.float32)
        return {"grain": torch.from_numpy(noise), "gains": torch.from_numpy(gains)}

    def forward(self, noise):
        """Grain (patch, 1, range_bin, range_line) made of the noise of `draw`."""
        both = noise["grain"].to(self.skew)
        gains = noise["gains"].to(self.gain)
        white, texture = both.split(1, dim=1)
        skewed = white + self.skew * (white**2 - 1) / 2**0.5
        speckle = skewed / torch.sqrt(1 + self.skew**2)
        total = speckle + UNIT * self.size * texture
        return self.filter(total) + self.gain * gains

    def mismatch(self, lacking, is_snow):
        """Loss of the grain: squared errors of its covariance and third moment in snow.

        The moments are compared with those of `lacking`, what images lack. `lacking` and `is_snow`
        are (patch, 1, range_bin, range_line). Errors are in units of the variance.
        """
        lags = [lag for lag in GRAIN_LAGS if lag < lacking.shape[2]]
        distances = [distance for distance in GRAIN_DISTANCES if distance < lacking.shape[3]]
        found = change_covariance(lacking, is_snow, lags, distances)
        unit = found[0, 0].clamp(min=1e-6)  # a crop may lack snow
        error = self.covariance(lags, distances) - found
        of_covariance = (error**2).sum() / unit**2
        third = third_moment(lacking, is_snow)
        error = self.third_moment() - third
        return of_covariance + error**2 / unit**3

    def covariance(self, lags, distances):
        """Covariance that the weights give the grain in snow, as `change_covariance` has it."""
        weights = self.filter.weight[0, 0, :, 0]
        white, texture = _covariances(tuple(lags), tuple(distances), weights.device)
        size = UNIT * self.size.sum()
        noise = white + size**2 * texture
        filtered = torch.einsum("dljk,j,k->dl", noise, weights, weights)
        return filtered + self.gain**2

    def third_moment(self):
        """Mean third power of the grain; only its skewed noise has one."""
        s = self.skew.sum()
        of_white = 2**0.5 * s * (3 + 2 * s**2) / (1 + s**2) ** 1.5
        return of_white * (self.filter.weight**3).sum()


def correlated(white, length, *, axis):
    """Noise with the variance of `white` and the correlation ``exp(-distance / length)``."""
    share = np.float32(np.exp(-1 / length))
    rest = np.sqrt(1 - share**2)
    white = np.moveaxis(white, axis, -1).copy()
    white[..., 0] /= rest
    feedback = np.float32([1, -share])
    filtered = lfilter([rest], feedback, white)
    return np.moveaxis(filtered, -1, axis)


@lru_cache(maxsize=8)
def _covariances(lags, distances, device):
    """Covariances of changes of white noise and of the texture, where weights j and k meet them.

    A tensor (2, distance, lag, j, k), kept on the device, since a captured step cannot copy it.
    """
    steps = np.arange(N_WEIGHTS)
    lags = np.array(lags)[:, None, None]
    apart = np.abs(lags + steps[:, None] - steps)
    distances = np.array(distances)[:, None, None, None]
    shape = (len(distances), *apart.shape)
    white = np.broadcast_to(apart == 0, shape)
    changed = 1 - np.exp(-distances / TEXTURE_LINES)
    alike = np.exp(-apart / TEXTURE_BINS)
    texture = changed * alike
    both = np.array([white, texture], dtype=np.float32)
    return torch.from_numpy(both).to(device)


def change_covariance(image, held, lags, distances):
    """Half the mean product of changes between range lines some distance apart, (distance, lag).

    Lags are down range. Only pixels `held` count; level layers do not change and add nothing.
    """
    found = torch.zeros(len(distances), len(lags), device=image.device)
    for row, distance in enumerate(distances):
        both = held[..., distance:] & held[..., :-distance]
        change = image[..., distance:] - image[..., :-distance]
        change = change * both
        height = change.shape[2]
        for column, lag in enumerate(lags):
            above = slice(0, height - lag)
            product = change[:, :, lag:] * change[:, :, above]
            pairs = both[:, :, lag:] & both[:, :, above]
            n_held = pairs.sum().clamp(min=1)
            found[row, column] = product.sum() / n_held / 2
    return found


def third_moment(image, held):
    """Mean third power of the deviation of pixels `held` from the mean of their range bin."""
    across = {"dim": (0, 3), "keepdim": True}
    n_held = held.sum(**across).clamp(min=1)
    mean = (image * held).sum(**across) / n_held
    above = (image - mean) * held
    return (above**3).sum() / held.sum().clamp(min=1)
