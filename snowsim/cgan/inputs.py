"""Inputs of the networks at each pixel: depth, layers, and the levels of layers and of snow.

Levels are grey levels of an observed image, or decibels of PHY's mean power. Both count from the 0
of an image; divided by the mean level of the scene's uppermost layer, they can be compared.
"""

import numpy as np
import pandas as pd
import torch
from scipy.ndimage import gaussian_filter, uniform_filter1d

from snowsim.echogram import DB_BELOW_NOISE_FLOOR, to_db
from snowsim.phy import mean_power_of

EDGE_BINS = 10.0  # near the surface, within about this depth, inputs change from bin to bin
# E-folding depths of the other inputs of depth; below three of the last nothing changes.
FALLS_BINS = (30.0, 100.0, 300.0)
# Range lines over which the brightness of a layer is averaged, so that it holds no speckle.
MEAN_LINES = 33
# Standard deviations of the Gaussian mean that gives the level of snow: it shows no single layer.
LEVEL_BINS, LEVEL_LINES = 10.0, 16.0
N_CHANNELS = 3 + len(FALLS_BINS)  # of the inputs


def expected_image(scene):
    """Levels of the mean power that PHY gives the echoes of a `Scene`, (range_bin, range_line).

    Decibels above an image's 0, without speckle and gain from line to line. ValueError for a scene
    without echoes.
    """
    echoes = scene.echoes
    if echoes is None:
        msg = (
            f"scene {scene.name}: expected echoes, from which its brightness follows, got none: "
            "snowsim.labels.echoes_of_layers makes them of layers and statistics"
        )
        raise ValueError(msg)
    power = mean_power_of(echoes, scene.n_range_bins)
    return to_db(1 + power / echoes.noise_power) + DB_BELOW_NOISE_FLOOR


def snow_level(image):
    """Level of snow at each pixel of an image: a Gaussian mean over all that lies there."""
    return gaussian_filter(image.astype(float), (LEVEL_BINS, LEVEL_LINES), mode="nearest")


def known_map(image, layer_bins, of_snow):
    """Map of what is known of each pixel, float32 (range_bin, range_line, 1 + `N_CHANNELS`).

    First comes the number of layers above. Then follow the inputs of the networks: the level of a
    layer in its own pixels, else -1; depth below the uppermost layer in four channels, bounded, so
    that greater depths than in training look much like the greatest there; and the level of snow,
    `of_snow`, as `snow_level` gives it. Levels of 0 and of the uppermost layer become -1 and 1.
    Levels are those of `image`, observed or as `expected_image` gives it. Where a range line lacks
    a layer that others have, the layer is interpolated linearly. There must be at least one layer.
    """
    n_range_bins = len(image)
    of_layers, scale = _levels(image, layer_bins)
    of_snow = of_snow / scale
    rows = np.arange(n_range_bins)[:, None]
    whole = np.rint(_without_gaps(layer_bins))
    n_above = sum(rows >= row for row in whole)
    bright = np.zeros(n_above.shape)
    inside = (layer_bins > -0.5) & (layer_bins < n_range_bins - 0.5)
    _, lines = np.nonzero(inside)
    at = np.rint(layer_bins[inside]).astype(int)
    bright[at, lines] = of_layers[inside]
    depth = np.float32(rows - whole.min(axis=0))
    below = np.maximum(depth, 0)
    falls = [1 - 2 * np.exp(-below / fall) for fall in FALLS_BINS]
    channels = [n_above, 2 * bright - 1, np.tanh(depth / EDGE_BINS), *falls, 2 * of_snow - 1]
    return np.stack(channels, axis=2).astype(np.float32)


def inputs_of(known):
    """Inputs of the networks (patch, channel, range_bin, range_line), and each pixel's slab.

    From maps of `known_map`, (patch, range_bin, range_line, channel); the slab is the number of
    layers above, (patch, range_bin, range_line).
    """
    inputs = torch.from_numpy(known[..., 1:]).permute(0, 3, 1, 2)
    return inputs, known[..., 0].astype(int)


def is_snow(inputs):
    """True for pixels of the uppermost layer and below, from the inputs of the networks."""
    return inputs[:, 1:2] >= 0


def _without_gaps(layer_bins):
    """Layers that have any pick, interpolated linearly across their gaps."""
    is_there = np.isfinite(layer_bins).any(axis=1)
    by_line = pd.DataFrame(layer_bins[is_there].T.astype(float))
    return by_line.interpolate(limit_direction="both").to_numpy().T


def _levels(image, layer_bins):
    """Levels of layers (layer, range_line) over the mean level of the uppermost, and that mean.

    Along a layer they are means of `MEAN_LINES` range lines.
    """
    held = np.isfinite(layer_bins)
    rows = np.rint(np.where(held, layer_bins, 0)).astype(int)
    rows = np.clip(rows, 0, len(image) - 1)
    lines = np.arange(held.shape[1])
    level = np.where(held, image[rows, lines], 0.0)
    total = uniform_filter1d(level, MEAN_LINES, axis=1, mode="constant")
    n = uniform_filter1d(held.astype(float), MEAN_LINES, axis=1, mode="constant")
    of_layers = total / np.maximum(n, 1 / MEAN_LINES)
    first = held.any(axis=1).argmax()
    scale = max(of_layers[first][held[first]].mean(), 1.0)
    return of_layers / scale, scale
