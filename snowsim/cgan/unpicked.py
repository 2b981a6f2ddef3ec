"""Picks completed by a tracker: layers that nobody picked, and where picked ones lie.

A generator that sees echoes where nothing is marked learns to draw them unasked, and marked layers
as bright as those that people pick: the brightest. Of marks that lie bins apart from their layers
it learns blurred ones.
"""

from dataclasses import replace

import numpy as np

from snowsim.picking import pick_layers

APART_BINS = 4.0  # nearer to a pick, it is the layer that was picked
SHORTEST_LINES = 16  # of a piece


def completed(scene, probability, *, threshold):
    """A `Scene` with the layers that a tracker finds where none is picked.

    Picks lie where the tracker finds a layer within `APART_BINS` of them, else as they are. Layers
    are followed by `snowsim.picking.pick_layers`; each piece that is new is a layer of its
    own. Layers come by their mean depth. `probability` (range_bin, range_line) is the tracker's, in
    [0, 1], `threshold` above 0.
    """
    picked = scene.layer_bins
    found = pick_layers(probability, threshold=threshold, where=f"scene {scene.name}")
    new = np.array([_where_new(row, picked) for row in found]).reshape(-1, picked.shape[1])
    is_long = np.isfinite(new).sum(axis=1) >= SHORTEST_LINES
    marked = [_moved(row, found) for row in picked]
    layer_bins = np.array([*marked, *new[is_long]], dtype=picked.dtype)
    present = np.isfinite(layer_bins)
    total = np.where(present, layer_bins, 0).sum(axis=1)
    depth = np.where(present.any(axis=1), total / np.maximum(present.sum(axis=1), 1), np.inf)
    return replace(scene, layer_bins=layer_bins[np.argsort(depth, kind="stable")])


def _moved(pick, found):
    """A pick on the nearest followed layer, on each range line where that is near enough."""
    if len(found) == 0:
        return pick
    distance = np.nan_to_num(np.abs(found - pick), nan=np.inf)
    nearest = np.take_along_axis(found, distance.argmin(axis=0)[None], axis=0)[0]
    is_near = distance.min(axis=0) <= APART_BINS
    return np.where(is_near, nearest, pick)


def _where_new(row, picked):
    """A followed layer where it lies below the uppermost pick and apart from all, else NaN."""
    distance = np.where(np.isfinite(picked), np.abs(picked - row), np.inf).min(axis=0)
    uppermost = np.where(np.isfinite(picked), picked, np.inf).min(axis=0)
    return np.where((distance > APART_BINS) & (row > uppermost), row, np.nan)
