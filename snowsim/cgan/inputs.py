"""What a generator knows of each pixel: is a layer there, how bright, how deep, how bright is snow.

Grey levels are decibels above 0: by that of a scene's uppermost layer they compare with decibels of
powers, and no scale is needed.
"""

from dataclasses import dataclass

import numpy as np
import torch
from scipy.ndimage import gaussian_filter, uniform_filter1d

EDGE_BINS = 10.0  # about the surface, where depth counts bin by bin
# Further down: echoes fall about so; below three of the last nothing changes.
FALLS_BINS = (30.0, 100.0, 300.0)
# Range lines over which the brightness of an observed layer is averaged: speckle must not tell it.
ALONG = 33
# Standard deviations of the mean that is the level of snow: it shows no single layer.
LEVEL_BINS, LEVEL_LINES = 10.0, 16.0
N_CHANNELS = 3 + len(FALLS_BINS)  # of `conditions`


@dataclass(frozen=True)
class Batch:
    """What a step is given, tensors (patch, channel, range_bin, range_line) in [-1, 1].

    `inputs`: what both networks know; `image`: as observed; `noise`: a dict, of any size.
    """

    inputs: torch.Tensor
    image: torch.Tensor
    noise: dict

    def on(self, device):
        """The same on a device; noise follows when it is needed."""
        return Batch(self.inputs.to(device), self.image.to(device), self.noise)


@dataclass(frozen=True)
class Levels:
    """How bright a scene is, by the mean of its uppermost layer.

    `of_layers` (layer, range_line); `of_snow` (range_bin, range_line), the Gaussian mean of
    `LEVEL_BINS` and `LEVEL_LINES` over all that lies there. What a render adds to the network's
    image: `contrast`, how many grey levels a decibel has, by the mean of observed scenes, scales
    grain and `fades` [grey levels], of snow along track, which broadcast to (range_bin,
    range_line).
    """

    of_layers: np.ndarray
    of_snow: np.ndarray
    contrast: float = 1.0
    fades: np.ndarray | float = 0.0


def place_map(scene, layer_bins, n_range_bins, levels=None):
    """What `conditions` takes of each pixel, float32 (row, range_line, 4).

    Depth below the uppermost layer [bins], number of layers above, and `Levels`: of a layer in its
    own pixels, else 0, and of snow. `levels` are by default those of the scene's image, or 1. Where
    a range line lacks a layer that others have, it is straight between its neighbours. At least one
    layer must be there.
    """
    if levels is None:
        levels = observed_levels(scene.image, layer_bins, n_range_bins)
    rows = np.arange(n_range_bins)[:, None]
    whole = _without_gaps(layer_bins)
    depth = rows - np.rint(whole.min(axis=0))
    n_above = sum(rows >= np.rint(row) for row in whole)
    bright = np.zeros(n_above.shape)
    inside = (layer_bins > -0.5) & (layer_bins < n_range_bins - 0.5)
    _, lines = np.nonzero(inside)
    at = np.rint(layer_bins[inside]).astype(int)
    bright[at, lines] = levels.of_layers[inside]
    return np.stack([depth, n_above, bright, levels.of_snow], axis=2).astype(np.float32)


def slabs_of(places):
    """Number of layers above each pixel, from what `place_map` gives."""
    return places[..., 1].astype(int)


def _without_gaps(layer_bins):
    """Layers that are there at all, straight across their gaps."""
    lines = np.arange(layer_bins.shape[1])
    whole = []
    for row in layer_bins:
        present = np.isfinite(row)
        if present.any():
            whole.append(np.interp(lines, lines[present], row[present]))
    return np.array(whole)


def observed_levels(image, layer_bins, n_range_bins):
    """`Levels` of an image with these layers: along a layer a mean of `ALONG` lines.

    1 everywhere without an image.
    """
    held = np.isfinite(layer_bins)
    if image is None:
        return Levels(held.astype(float), np.ones((n_range_bins, held.shape[1])))
    rows = np.rint(np.where(held, layer_bins, 0)).astype(int)
    rows = np.clip(rows, 0, len(image) - 1)
    lines = np.arange(held.shape[1])
    grey = np.where(held, image[rows, lines], 0.0)
    total = uniform_filter1d(grey, ALONG, axis=1, mode="constant")
    n = uniform_filter1d(held.astype(float), ALONG, axis=1, mode="constant")
    mean = total / np.maximum(n, 1 / ALONG)
    first = held.any(axis=1).argmax()
    scale = max(mean[first][held[first]].mean(), 1.0)
    of_snow = gaussian_filter(image.astype(float), (LEVEL_BINS, LEVEL_LINES), mode="nearest")
    return Levels(mean / scale, of_snow / scale)


def conditions(places):
    """What networks know: layers and how bright these are, the depth, the level of snow.

    (patch, channel, range_bin, range_line), of `places` (patch, range_bin, range_line, 4) as
    `place_map` gives them. Depth has four channels, bounded in [-1, 1]: deeper than what was
    trained on looks much like the deepest that was. Levels of 0 and 1 become -1 and 1: 1 is as
    bright as the uppermost layer.
    """
    depth, _, bright, of_snow = (torch.from_numpy(places[..., k])[:, None] for k in range(4))
    near = torch.tanh(depth / EDGE_BINS)
    below = depth.clamp(min=0)
    falls = [1 - 2 * torch.exp(-below / fall) for fall in FALLS_BINS]
    return torch.cat([2 * bright - 1, near, *falls, 2 * of_snow - 1], dim=1)


def is_snow(inputs):
    """Pixels of the uppermost layer or below, of what `conditions` gives."""
    return inputs[:, 1:2] >= 0
