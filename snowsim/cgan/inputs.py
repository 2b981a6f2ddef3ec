"""What a generator knows of each pixel: whether a layer runs through it, how bright, how deep, and in which slab."""

import numpy as np
import torch
from scipy.ndimage import uniform_filter1d
from torch.nn import functional

from snowsim.patches import to_signed

EDGE_BINS = 10.0  # about the surface, where depth counts bin by bin
FALLS_BINS = (
    30.0,
    100.0,
    300.0,
)  # further down: echoes fall about so; below three of the last nothing changes
SPREAD_PIXELS, REACH_PIXELS = 1.5, 4  # of a Gaussian wider than the grain of speckle
ALONG = 33  # range lines over which the brightness of an observed layer is averaged: speckle must not tell it
METHODS = ("pix2pix", "depth", "guided")


def place_map(scene, layer_bins, n_range_bins, brightness=None):
    """Depth of each pixel below the uppermost layer [bins], number of layers above it, brightness of its own [percent].

    int16 (row, range_line, 3). `brightness` (layer, range_line) is by default that of the scene's
    image, or 1. Where a range line lacks a layer that others have, it is straight between its
    neighbours. ValueError, naming the scene, without any layer.
    """
    present = np.isfinite(layer_bins)
    if not present.any():
        msg = (
            f"scene {scene.name}: mask without layers, expected at least one to measure depth from"
        )
        raise ValueError(msg)
    lines, rows = np.arange(layer_bins.shape[1]), np.arange(n_range_bins)[:, None]
    both = zip(present, layer_bins, strict=True)
    whole = np.array([np.interp(lines, lines[on], row[on]) for on, row in both if on.any()])
    n_above = sum(rows >= np.rint(row) for row in whole)
    if brightness is None:
        brightness = observed_brightness(scene.image, layer_bins)
    bright = np.zeros(n_above.shape)
    at = present & (layer_bins > -0.5) & (layer_bins < n_range_bins - 0.5)
    bright[np.rint(layer_bins[at]).astype(int), np.broadcast_to(lines, at.shape)[at]] = np.rint(
        100 * brightness[at]
    )
    return np.stack([rows - np.rint(whole.min(axis=0)), n_above, bright], axis=2).astype(np.int16)


def observed_brightness(image, layer_bins):
    """Mean grey level along each layer by that of the uppermost, (layer, range_line); 1 without an image.

    Grey levels are decibels above 0, so that decibels of powers have the same ratios: no scale is
    needed.
    """
    held = np.isfinite(layer_bins)
    if image is None:
        return held.astype(float)
    rows = np.clip(np.rint(np.where(held, layer_bins, 0)).astype(int), 0, len(image) - 1)
    grey = np.where(held, image[rows, np.arange(held.shape[1])], 0.0)
    total, n = (
        uniform_filter1d(values, ALONG, axis=1, mode="constant")
        for values in (grey, held.astype(float))
    )
    mean, first = total / np.maximum(n, 1 / ALONG), held.any(axis=1).argmax()
    return mean / max(mean[first][held[first]].mean(), 1.0)


def n_channels(method):
    """Channels that a discriminator gets from `conditions`, and a generator, `guided` PHY's mean power as well."""
    n = 1 if method == "pix2pix" else 2 + len(FALLS_BINS)
    return n, n + (method == "guided")


def conditions(method, masks, places):
    """What networks know, (patch, channel, range_bin, range_line): the mask and, not `pix2pix`, depth, in [-1, 1].

    `places` (patch, range_bin, range_line, 3 or more) are as `place_map` gives them. Depth has four
    channels, all bounded: deeper than what was trained on looks much like the deepest that was.
    With `depth`, the mask's pixels of layers say how bright these are: 1 is as bright as the
    uppermost.
    """
    signed = to_signed(masks)
    if method == "pix2pix":
        return signed
    if method == "depth":
        signed = torch.from_numpy(places[..., 2].astype(np.float32) / 50 - 1)[:, None]
    depth = torch.from_numpy(places[..., 0].astype(np.float32))[:, None]
    below = depth.clamp(min=0)
    falls = [1 - 2 * torch.exp(-below / fall) for fall in FALLS_BINS]
    return torch.cat([signed, torch.tanh(depth / EDGE_BINS), *falls], dim=1)


def low_passed(images):
    """Images (patch, 1, range_bin, range_line), float32, less what varies as quickly as speckle does."""
    taps = torch.exp(
        -((torch.arange(-REACH_PIXELS, REACH_PIXELS + 1.0) / SPREAD_PIXELS) ** 2) / 2
    ).to(images.device)
    taps = taps / taps.sum()
    padded = functional.pad(images.float(), (REACH_PIXELS,) * 4, mode="replicate")
    return functional.conv2d(
        functional.conv2d(padded, taps.view(1, 1, -1, 1)), taps.view(1, 1, 1, -1)
    )
