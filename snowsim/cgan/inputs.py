"""What a generator knows of each pixel: whether a layer runs through it, how bright, how deep."""

from dataclasses import dataclass

import numpy as np
import torch
from scipy.ndimage import uniform_filter1d

EDGE_BINS = 10.0  # about the surface, where depth counts bin by bin
# Further down: echoes fall about so; below three of the last nothing changes.
FALLS_BINS = (30.0, 100.0, 300.0)
# Range lines over which the brightness of an observed layer is averaged: speckle must not tell it.
ALONG = 33
N_CHANNELS = 2 + len(FALLS_BINS)  # of `conditions`


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


def place_map(scene, layer_bins, n_range_bins, brightness=None):
    """Depth below the uppermost layer [bins], number of layers above, brightness [percent].

    int16 (row, range_line, 3); brightness is that of a layer in its own pixels. `brightness`
    (layer, range_line) is by default that of the scene's image, or 1. Where a range line lacks a
    layer that others have, it is straight between its neighbours. At least one layer must be there.
    """
    if brightness is None:
        brightness = observed_brightness(scene.image, layer_bins)
    rows = np.arange(n_range_bins)[:, None]
    whole = _without_gaps(layer_bins)
    depth = rows - np.rint(whole.min(axis=0))
    n_above = sum(rows >= np.rint(row) for row in whole)
    bright = np.zeros(n_above.shape)
    inside = (layer_bins > -0.5) & (layer_bins < n_range_bins - 0.5)
    _, lines = np.nonzero(inside)
    at = np.rint(layer_bins[inside]).astype(int)
    bright[at, lines] = np.rint(100 * brightness[inside])
    return np.stack([depth, n_above, bright], axis=2).astype(np.int16)


def _without_gaps(layer_bins):
    """Layers that are there at all, straight across their gaps."""
    lines = np.arange(layer_bins.shape[1])
    whole = []
    for row in layer_bins:
        present = np.isfinite(row)
        if present.any():
            whole.append(np.interp(lines, lines[present], row[present]))
    return np.array(whole)


def observed_brightness(image, layer_bins):
    """Mean grey level along each layer by that of the uppermost, (layer, range_line).

    1 without an image. Grey levels are decibels above 0, so that decibels of powers have the same
    ratios: no scale is needed.
    """
    held = np.isfinite(layer_bins)
    if image is None:
        return held.astype(float)
    rows = np.rint(np.where(held, layer_bins, 0)).astype(int)
    rows = np.clip(rows, 0, len(image) - 1)
    lines = np.arange(held.shape[1])
    grey = np.where(held, image[rows, lines], 0.0)
    total = uniform_filter1d(grey, ALONG, axis=1, mode="constant")
    n = uniform_filter1d(held.astype(float), ALONG, axis=1, mode="constant")
    mean = total / np.maximum(n, 1 / ALONG)
    first = held.any(axis=1).argmax()
    mean_of_first = mean[first][held[first]].mean()
    return mean / max(mean_of_first, 1.0)


def conditions(places):
    """What networks know: layers and how bright these are, and the depth, in [-1, 1].

    (patch, channel, range_bin, range_line). `places` (patch, range_bin, range_line, 3) are as
    `place_map` gives them. Depth has four channels, all bounded: deeper than what was trained on
    looks much like the deepest that was. The pixels of layers say how bright these are: 1 is as
    bright as the uppermost.
    """
    percent = places[..., 2].astype(np.float32)
    bright = torch.from_numpy(percent / 50 - 1)[:, None]
    depth = torch.from_numpy(places[..., 0].astype(np.float32))[:, None]
    near = torch.tanh(depth / EDGE_BINS)
    below = depth.clamp(min=0)
    falls = [1 - 2 * torch.exp(-below / fall) for fall in FALLS_BINS]
    return torch.cat([bright, near, *falls], dim=1)
