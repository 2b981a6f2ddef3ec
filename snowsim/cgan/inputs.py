"""What a generator knows of each pixel: whether a layer runs through it, how deep it lies, and in which slab."""

import numpy as np
import torch
from torch.nn import functional

from snowsim.patches import to_signed

EDGE_BINS = 10.0  # about the surface, where depth counts bin by bin
FALLS_BINS = (30.0, 100.0, 300.0)  # further down: echoes fall about so; below three of the last nothing changes
SPREAD_PIXELS, REACH_PIXELS = 1.5, 4  # of a Gaussian wider than the grain of speckle
METHODS = ("pix2pix", "depth", "guided")


def place_map(scene, layer_bins, n_range_bins):
    """Depth of each pixel below the uppermost layer [bins] and number of layers above it, int16 (row, range_line, 2).

    Where a range line lacks a layer that others have, it is straight between its neighbours. ValueError, naming the
    scene, without any layer.
    """
    present = np.isfinite(layer_bins)
    if not present.any():
        msg = f"scene {scene.name}: mask without layers, expected at least one to measure depth from"
        raise ValueError(msg)
    lines, rows = np.arange(layer_bins.shape[1]), np.arange(n_range_bins)[:, None]
    both = zip(present, layer_bins, strict=True)
    whole = np.array([np.interp(lines, lines[on], row[on]) for on, row in both if on.any()])
    n_above = sum(rows >= np.rint(row) for row in whole)
    return np.stack([rows - np.rint(whole.min(axis=0)), n_above], axis=2).astype(np.int16)


def n_channels(method):
    """Channels that a discriminator gets from `conditions`, and a generator, `guided` PHY's mean power as well."""
    n = 1 if method == "pix2pix" else 2 + len(FALLS_BINS)
    return n, n + (method == "guided")


def conditions(method, masks, depths):
    """What networks know, (patch, channel, range_bin, range_line) in [-1, 1]: the mask and, not `pix2pix`, depth.

    Four channels of depth [bins], all bounded: deeper than what was trained on looks much like the deepest that was.
    """
    signed = to_signed(masks)
    if method == "pix2pix":
        return signed
    depth = torch.from_numpy(depths.astype(np.float32))[:, None]
    below = depth.clamp(min=0)
    falls = [1 - 2 * torch.exp(-below / fall) for fall in FALLS_BINS]
    return torch.cat([signed, torch.tanh(depth / EDGE_BINS), *falls], dim=1)


def low_passed(images):
    """Images (patch, 1, range_bin, range_line), float32, less what varies as quickly as speckle does."""
    taps = torch.exp(-((torch.arange(-REACH_PIXELS, REACH_PIXELS + 1.0) / SPREAD_PIXELS) ** 2) / 2).to(images.device)
    taps = taps / taps.sum()
    padded = functional.pad(images.float(), (REACH_PIXELS,) * 4, mode="replicate")
    return functional.conv2d(functional.conv2d(padded, taps.view(1, 1, -1, 1)), taps.view(1, 1, 1, -1))
