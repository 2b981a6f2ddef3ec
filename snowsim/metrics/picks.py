"""Layers as a glaciologist reads them.

Picks from an edge map, and which true layer each pick belongs to.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit

from snowsim.echogram import check_layer_bins
from snowsim.limits import check_values
from snowsim.metrics.edges.suppression import check_prediction


@dataclass(eq=False)
class _Followed:
    """A layer being followed: its picks so far, and where the last one is."""

    bins: np.ndarray
    last_line: int
    last_bin: float


def pick_layers(
    edges, *, threshold, max_step_bins=3.0, max_gap_lines=20, min_lines=20, where="image"
):
    """Follow layers through an edge map, usually suppressed, range line by range line and in order.

    In every range line each run of pixels at or above `threshold`, usually that of the best F, is
    one pick, at its centroid. Picks join the layers followed so far such that layers keep their
    order and steps are below `max_step_bins`; a pick that joins none begins a layer. More than
    `max_gap_lines` without a pick end a layer; one with fewer picks than `min_lines` is dropped as
    a speck.

    Returns fractional range bins (layer, range_line), NaN without a pick, strictly increasing with
    layer index where present. Maps that leave [0, 1], named `where`, and thresholds not above 0 are
    refused.
    """
    edges = check_prediction(edges, where)
    check_values(f"{where}: threshold", threshold, 0, above=True)
    n_lines = edges.shape[1]
    layers = []  # downwards, those that ended among them
    for line in range(n_lines):
        found = _line_picks(edges[:, line], threshold)
        following = [layer for layer in layers if line - layer.last_line <= max_gap_lines + 1]
        last_bins = np.array([layer.last_bin for layer in following])
        joined = _align(last_bins, found, max_step_bins)
        layer_of_pick = dict(zip(joined, following, strict=True))  # and of -1, no pick, any
        place = 0
        for pick, position in enumerate(found):
            layer = layer_of_pick.get(pick)
            if layer is None:
                layer = _Followed(np.full(n_lines, np.nan), line, position)
                # Below all that are picked above it here, above all that are picked below it; else
                # by depth.
                picked_below = [layer_of_pick[i] for i in joined if i > pick]
                stop = layers.index(picked_below[0]) if picked_below else len(layers)
                while place < stop and layers[place].last_bin < position:
                    place += 1
                layers.insert(place, layer)
            else:
                place = layers.index(layer)
            layer.bins[line] = position
            layer.last_line = line
            layer.last_bin = position
            place += 1
    kept = [layer.bins for layer in layers if np.isfinite(layer.bins).sum() >= min_lines]
    return np.array(kept) if kept else np.empty((0, n_lines))


def match_picks(picks, layer_bins, *, max_distance_bins=10.0):
    """Assign picks to true layers, both (row, range_line), line by line and keeping their order.

    Of all assignments that keep the order, the one with the least sum of distances, where a layer
    without a pick counts `max_distance_bins`; found by dynamic programming. Returns the error of
    each layer, pick less truth [range bins], NaN where the layer is absent or has no pick, and
    where each pick was used. Layers that cross, unlike widths and distances not above 0 are
    refused.
    """
    picks = np.asarray(picks, dtype=float)
    layer_bins = np.asarray(layer_bins, dtype=float)
    check_layer_bins(picks, "picks")
    check_layer_bins(layer_bins)
    check_values("max_distance_bins", max_distance_bins, 0, above=True)
    if picks.shape[1] != layer_bins.shape[1]:
        msg = f"picks cover {picks.shape[1]} range lines, the layers {layer_bins.shape[1]}"
        raise ValueError(msg)
    error_bins = np.full(layer_bins.shape, np.nan)
    used = np.zeros(picks.shape, dtype=bool)
    for line in range(layer_bins.shape[1]):
        layer = np.flatnonzero(np.isfinite(layer_bins[:, line]))
        pick = np.flatnonzero(np.isfinite(picks[:, line]))
        assigned = _align(layer_bins[layer, line], picks[pick, line], max_distance_bins)
        layer = layer[assigned >= 0]
        pick = pick[assigned[assigned >= 0]]
        error_bins[layer, line] = picks[pick, line] - layer_bins[layer, line]
        used[pick, line] = True
    return error_bins, used


def _line_picks(strength, threshold):
    """Centroid of every run of a range line at or above the threshold, (pick,) [range bins]."""
    rows = np.flatnonzero(strength >= threshold)
    if rows.size == 0:
        return np.empty(0)
    starts = np.flatnonzero(np.diff(rows, prepend=-2) > 1)
    weights = strength[rows]
    return np.add.reduceat(rows * weights, starts) / np.add.reduceat(weights, starts)


@njit(cache=True)
def _align(expected, found, max_distance):
    """Index of what was found for each entry expected, -1 for none.

    The order-keeping assignment of least distance.
    """
    n = expected.size
    m = found.size
    # gain[i, j]: the most that the first i expected and j found can save of max_distance each.
    gain = np.zeros((n + 1, m + 1))
    for i in range(1, n + 1):
        for j in range(1, m + 1):
            gain[i, j] = max(gain[i - 1, j], gain[i, j - 1])
            saved = max_distance - abs(expected[i - 1] - found[j - 1])
            if saved > 0:
                gain[i, j] = max(gain[i, j], gain[i - 1, j - 1] + saved)
    assigned = np.full(n, -1)
    i, j = n, m
    while i > 0 and j > 0:
        if gain[i, j] == gain[i - 1, j]:
            i -= 1
        elif gain[i, j] == gain[i, j - 1]:
            j -= 1
        else:
            i, j = i - 1, j - 1
            assigned[i] = j
    return assigned
