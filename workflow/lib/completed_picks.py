"""Picks of observed scenes completed by the layers that a tracker follows.

A generator that sees echoes where nothing is marked learns to draw them unasked, and marked layers
as bright as those that people pick: the brightest. Of marks that lie bins apart from their layers
it learns blurred ones.
"""

from dataclasses import replace

import numpy as np

APART_BINS = 4.0  # nearer to a pick, it is the layer that was picked
SHORTEST_LINES = 16  # of a piece


def completed(scene, found):
    """A `Scene` with the layers that a tracker `found` (layer, range_line) where none is picked.

    Picks lie where the tracker found a layer within `APART_BINS` of them, else as they are. What is
    found below the uppermost pick, apart from every pick and over `SHORTEST_LINES` or more, is a
    layer of its own. Layers come by their mean depth; rows without a pick are left out.
    """
    picked = scene.layer_bins
    # A row without a layer, where none is found at all.
    found = np.vstack([found, np.full(picked.shape[1], np.nan)])
    apart = np.abs(found[:, None] - picked)  # (found, picked, range_line)
    apart = np.nan_to_num(apart, nan=np.inf)
    nearest = np.take_along_axis(found, apart.argmin(axis=0), axis=0)
    marked = np.where(apart.min(axis=0) <= APART_BINS, nearest, picked)
    # Infinite where nothing is picked.
    uppermost = np.nan_to_num(picked, nan=np.inf).min(axis=0)
    is_apart = (apart > APART_BINS).all(axis=1)
    new = np.where(is_apart & (found > uppermost), found, np.nan)
    n_lines = np.isfinite(new).sum(axis=1)
    new = new[n_lines >= SHORTEST_LINES]
    layer_bins = np.vstack([marked, new]).astype(picked.dtype)
    is_there = np.isfinite(layer_bins).any(axis=1)
    layer_bins = layer_bins[is_there]
    depth = np.nanmean(layer_bins, axis=1)
    by_depth = np.argsort(depth, kind="stable")
    return replace(scene, layer_bins=layer_bins[by_depth])
