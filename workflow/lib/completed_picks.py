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
    apart = np.abs(found[:, None] - picked)  # (found, picked, range_line)
    apart = np.nan_to_num(apart, nan=np.inf)
    marked = [_moved(pick, found, apart[:, number]) for number, pick in enumerate(picked)]
    # Infinite where nothing is picked.
    uppermost = np.nan_to_num(picked, nan=np.inf).min(axis=0)
    is_apart = (apart > APART_BINS).all(axis=1)
    new = np.where(is_apart & (found > uppermost), found, np.nan)
    n_lines = np.isfinite(new).sum(axis=1)
    new = new[n_lines >= SHORTEST_LINES]
    layer_bins = np.array([*marked, *new], dtype=picked.dtype)
    is_there = np.isfinite(layer_bins).any(axis=1)
    layer_bins = layer_bins[is_there]
    depth = np.nanmean(layer_bins, axis=1)
    by_depth = np.argsort(depth, kind="stable")
    return replace(scene, layer_bins=layer_bins[by_depth])


def _moved(pick, found, apart):
    """A pick on the nearest of `found` layers, on each range line where that is near enough."""
    if len(found) == 0:
        return pick
    number = apart.argmin(axis=0)[None]
    nearest = np.take_along_axis(found, number, axis=0)[0]
    is_near = apart.min(axis=0) <= APART_BINS
    return np.where(is_near, nearest, pick)
