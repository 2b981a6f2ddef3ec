"""Layers as a glaciologist reads them: from an edge map to picks, and from picks to errors in bins and metres."""

from dataclasses import dataclass

import numpy as np
from numba import njit

from snowsim.echogram import check_layer_bins


@dataclass(eq=False)
class _Followed:
    """A layer being followed: its picks so far, and where the last one is."""

    bins: np.ndarray
    last_line: int
    last_bin: float


def pick_layers(edges, *, threshold, max_step_bins=3.0, max_gap_lines=20, min_lines=20, where="image"):
    """Follow layers through an edge map, range line by range line and in order.

    In every range line each run of pixels at or above the threshold is one pick, at its centroid. Picks join the layers
    followed so far such that layers keep their order and steps are small; a pick that joins none begins a layer.

    Parameters
    ----------
    edges : array_like, (range_bin, range_line)
        Edge map in [0, 1], usually after `snowsim.metrics.edges.suppress`.
    threshold : float
        Edge strength of a pick, usually that of the best F.
    max_step_bins : float
        A layer's next pick lies closer than this to its last one [range bins].
    max_gap_lines : int
        More range lines than these without a pick end a layer.
    min_lines : int
        Layers with fewer picks are dropped as specks.
    where : str
        Name of the image, for errors.

    Returns
    -------
    ndarray, (layer, range_line)
        Fractional range bins, NaN without a pick; strictly increasing with layer index where present.

    Raises
    ------
    ValueError
        If the map is not 2-D, is empty or leaves [0, 1], or if the threshold is not above 0.
    """
    edges = np.asarray(edges, dtype=float)
    if edges.ndim != 2 or edges.size == 0 or not (edges.min() >= 0 and edges.max() <= 1):
        msg = f"{where}: edges must be (range_bin, range_line), not empty and in [0, 1], got shape {edges.shape}"
        raise ValueError(msg)
    if not threshold > 0:
        msg = f"{where}: threshold must be above 0, got {threshold}"
        raise ValueError(msg)
    n_lines = edges.shape[1]
    layers = []  # downwards, those that ended among them
    for line in range(n_lines):
        found = _line_picks(edges[:, line], threshold)
        following = [layer for layer in layers if line - layer.last_line <= max_gap_lines + 1]
        joined = _align(np.array([layer.last_bin for layer in following]), found, max_step_bins)
        layer_of_pick = {int(pick): layer for layer, pick in zip(following, joined, strict=True) if pick >= 0}
        place = 0
        for pick, position in enumerate(found):
            layer = layer_of_pick.get(pick)
            if layer is None:
                layer = _Followed(np.full(n_lines, np.nan), line, position)
                # Below all that are picked above it here, above all that are picked below it; else by depth.
                stop = next((layers.index(layer_of_pick[i]) for i in sorted(layer_of_pick) if i > pick), len(layers))
                while place < stop and layers[place].last_bin < position:
                    place += 1
                layers.insert(place, layer)
            else:
                place = layers.index(layer)
            layer.bins[line], layer.last_line, layer.last_bin = position, line, position
            place += 1
    kept = [layer.bins for layer in layers if np.isfinite(layer.bins).sum() >= min_lines]
    return np.array(kept) if kept else np.empty((0, n_lines))


def match_picks(picks, layer_bins, *, max_distance_bins=10.0):
    """Assign picks to true layers, in every range line by itself and keeping their order.

    Parameters
    ----------
    picks, layer_bins : array_like, (pick, range_line) and (layer, range_line)
        Fractional range bins, NaN where absent.
    max_distance_bins : float
        A pick this far from a layer or farther is not of that layer [range bins].

    Returns
    -------
    error_bins : ndarray, (layer, range_line)
        Pick less truth, positive where the pick is deeper; NaN where the layer is absent or has no pick.
    used : ndarray of bool, (pick, range_line)
        Where a pick was assigned to a layer.

    Raises
    ------
    ValueError
        If layers cross, an array is not 2-D or infinite, widths differ or `max_distance_bins` is not above 0.

    Notes
    -----
    Of all assignments that keep the order, the one with the least sum of distances, where a layer without a pick
    counts `max_distance_bins`; found by dynamic programming.
    """
    picks, layer_bins = np.asarray(picks, dtype=float), np.asarray(layer_bins, dtype=float)
    check_layer_bins(picks, "picks")
    check_layer_bins(layer_bins)
    if picks.shape[1] != layer_bins.shape[1]:
        msg = f"picks cover {picks.shape[1]} range lines, the layers {layer_bins.shape[1]}"
        raise ValueError(msg)
    if not max_distance_bins > 0:
        msg = f"max_distance_bins must be above 0, got {max_distance_bins}"
        raise ValueError(msg)
    error_bins = np.full(layer_bins.shape, np.nan)
    used = np.zeros(picks.shape, dtype=bool)
    for line in range(layer_bins.shape[1]):
        layer = np.flatnonzero(np.isfinite(layer_bins[:, line]))
        pick = np.flatnonzero(np.isfinite(picks[:, line]))
        assigned = _align(layer_bins[layer, line], picks[pick, line], max_distance_bins)
        layer, pick = layer[assigned >= 0], pick[assigned[assigned >= 0]]
        error_bins[layer, line] = picks[pick, line] - layer_bins[layer, line]
        used[pick, line] = True
    return error_bins, used


def score_picks(picks, layer_bins, *, max_distance_bins=10.0, within_bins=2.0, bin_size_m=None):
    """What picks of one scene are worth: position, completeness and annual thickness.

    Parameters
    ----------
    picks, layer_bins : array_like, (pick, range_line) and (layer, range_line)
        Fractional range bins, NaN where absent; layer 0 is the snow surface.
    max_distance_bins : float
        See `match_picks` [range bins].
    within_bins : float
        What counts as a small error [range bins].
    bin_size_m : float, optional
        Thickness of a range bin [m], to have the errors in metres too.

    Returns
    -------
    dict
        `mean_absolute_error_bins`, `bias_bins` and `share_within` over the true pixels that have a pick; `n_true` and
        `n_found` of these pixels and `n_picks`, to pool scenes; `n_layers`, `n_missed_layers` (a pick in less than half
        of their range lines) and `n_false_layers` (picked rows of which less than half belongs to any layer);
        `thickness_mean_absolute_error_bins`, `thickness_bias_bins` and `n_thickness` over the range lines where both
        bounds of a slab have a pick. With `bin_size_m`, every `_bins` error also as `_m`. NaN where nothing was found.

    Raises
    ------
    ValueError
        As `match_picks`; if there is no true pixel; if `bin_size_m` is not above 0.
    """
    if bin_size_m is not None and not bin_size_m > 0:
        msg = f"bin_size_m must be above 0, got {bin_size_m}"
        raise ValueError(msg)
    error_bins, used = match_picks(picks, layer_bins, max_distance_bins=max_distance_bins)
    present, picked = np.isfinite(layer_bins), np.isfinite(picks)
    if not present.any():
        msg = f"layer_bins must hold a layer, all of {np.shape(layer_bins)} is absent"
        raise ValueError(msg)
    found = error_bins[np.isfinite(error_bins)]
    thickness_error = np.diff(error_bins, axis=0)
    thickness_error = thickness_error[np.isfinite(thickness_error)]
    n_lines_of_layer = present.sum(axis=1)
    missed = (n_lines_of_layer > 0) & (2 * np.isfinite(error_bins).sum(axis=1) < n_lines_of_layer)
    scores = {
        "mean_absolute_error_bins": _mean(np.abs(found)),
        "bias_bins": _mean(found),
        "share_within": _mean(np.abs(found) <= within_bins),
        "n_true": int(present.sum()),
        "n_found": int(found.size),
        "n_picks": int(picked.sum()),
        "n_layers": int((n_lines_of_layer > 0).sum()),
        "n_missed_layers": int(missed.sum()),
        "n_false_layers": int((2 * used.sum(axis=1) < picked.sum(axis=1)).sum()),
        "thickness_mean_absolute_error_bins": _mean(np.abs(thickness_error)),
        "thickness_bias_bins": _mean(thickness_error),
        "n_thickness": int(thickness_error.size),
    }
    if bin_size_m is not None:
        in_bins = [name for name in scores if name.endswith("_bins")]
        scores |= {name.removesuffix("_bins") + "_m": scores[name] * bin_size_m for name in in_bins}
    return scores


def _mean(values):
    return float(np.mean(values)) if values.size else float("nan")


def _line_picks(strength, threshold):
    """Centroid of every run of one range line at or above the threshold, ascending, (pick,) [range bins]."""
    rows = np.flatnonzero(strength >= threshold)
    if rows.size == 0:
        return np.empty(0)
    starts = np.flatnonzero(np.diff(rows, prepend=-2) > 1)
    weights = strength[rows]
    return np.add.reduceat(rows * weights, starts) / np.add.reduceat(weights, starts)


@njit(cache=True)
def _align(expected, found, max_distance):
    """Index of what was found for each entry expected, -1 for none: the order-keeping assignment of least distance."""
    n, m = expected.size, found.size
    # gain[i, j]: the most that the first i expected and the first j found can save of max_distance each.
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
