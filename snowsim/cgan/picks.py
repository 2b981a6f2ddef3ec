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
    apart = np.nan_to_num(np.abs(found[:, None] - picked), nan=np.inf)  # (found, picked, line)
    marked = [_moved(pick, found, apart[:, number]) for number, pick in enumerate(picked)]
    is_apart = (apart > APART_BINS).all(axis=1) & (found > _uppermost(picked))
    new = np.where(is_apart, found, np.nan)
    is_long = np.isfinite(new).sum(axis=1) >= SHORTEST_LINES
    layer_bins = np.array([*marked, *new[is_long]], dtype=picked.dtype)
    layer_bins = layer_bins[np.isfinite(layer_bins).any(axis=1)]
    by_depth = np.argsort(np.nanmean(layer_bins, axis=1), kind="stable")
    return replace(scene, layer_bins=layer_bins[by_depth])


def _uppermost(picked):
    """Where the uppermost pick lies, (range_line,); infinite without one."""
    return np.where(np.isfinite(picked), picked, np.inf).min(axis=0)


def _moved(pick, found, apart):
    """A pick on the nearest of `found` layers, on each range line where that is near enough."""
    if len(found) == 0:
        return pick
    nearest = np.take_along_axis(found, apart.argmin(axis=0)[None], axis=0)[0]
    return np.where(apart.min(axis=0) <= APART_BINS, nearest, pick)
