"""Which true layer each pick belongs to, and how far from it the pick lies."""

import numpy as np
from numba import njit

from snowsim.echogram import check_layer_bins


def match_picks(picks, layer_bins, *, max_distance_bins=10.0):
    """Assign picks to true layers, both (row, range_line), line by line and keeping their order.

    Of all assignments that keep the order, the one with the least sum of distances, where a layer
    without a pick counts `max_distance_bins`; found by dynamic programming. Returns the error of
    each layer, pick less truth [range bins], NaN where the layer is absent or has no pick, and
    where each pick was used. Picks that cross and unlike widths are refused.
    """
    picks = np.asarray(picks, dtype=float)
    layer_bins = np.asarray(layer_bins, dtype=float)
    check_layer_bins(picks, "picks")
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
