"""Layers that nobody picked, as a tracker finds them.

A generator that sees echoes where nothing is marked learns to draw them unasked, and marked layers
as bright as those that people pick: the brightest.
"""

from dataclasses import replace

import numpy as np

from snowsim.metrics.edges import suppress
from snowsim.metrics.picks import pick_layers

APART_BINS = 4.0  # nearer to a pick, it is the layer that was picked
SHORTEST_LINES = 16  # of a piece


def with_unpicked(scene, probability, *, threshold):
    """A `Scene` with the layers that a tracker finds where none is picked, picks as they are.

    Layers are followed by `snowsim.metrics.picks.pick_layers`; each piece that is new is a layer of
    its own. Layers come by their mean depth. `probability` (range_bin, range_line) is the
    tracker's, in [0, 1], `threshold` above 0.
    """
    picked = scene.layer_bins
    found = pick_layers(suppress(probability), threshold=threshold, where=f"scene {scene.name}")
    new = np.array([_where_new(row, picked) for row in found]).reshape(-1, picked.shape[1])
    is_long = np.isfinite(new).sum(axis=1) >= SHORTEST_LINES
    layer_bins = np.concatenate([picked, new[is_long].astype(picked.dtype)])
    present = np.isfinite(layer_bins)
    total = np.where(present, layer_bins, 0).sum(axis=1)
    depth = np.where(present.any(axis=1), total / np.maximum(present.sum(axis=1), 1), np.inf)
    return replace(scene, layer_bins=layer_bins[np.argsort(depth, kind="stable")])


def _where_new(row, picked):
    """A followed layer where it lies below the uppermost pick and apart from all, else NaN."""
    distance = np.where(np.isfinite(picked), np.abs(picked - row), np.inf).min(axis=0)
    uppermost = np.where(np.isfinite(picked), picked, np.inf).min(axis=0)
    return np.where((distance > APART_BINS) & (row > uppermost), row, np.nan)
