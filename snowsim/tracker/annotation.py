"""What partial annotation leaves open: pixels that may hold a layer nobody picked."""

import numpy as np

REACH_BINS = 8.0  # a picked layer wanders this far along a gap; half the least first layer of the paper


def annotated_pixels(scene, layer_bins, n_range_bins, reach_bins=REACH_BINS):
    """Where the picks of a scene tell layers from background.

    Unknown is what lies within `reach_bins` of the continuation of a picked layer across its gaps (straight between
    picks, level beyond the first and the last), and all that lies deeper than the deepest pick or continuation by more
    than that. A layer between two picked ones that has no pick at all goes unnoticed.

    Parameters
    ----------
    scene : Scene
        One that holds `complete_layer_bins` is partially annotated; any other is known everywhere.
    layer_bins : ndarray, (layer, range_line)
        Its layers, scaled or not [range bins]; NaN where not annotated.
    n_range_bins : int
        Height of the map.
    reach_bins : float

    Returns
    -------
    ndarray of bool, (range_bin, range_line)
    """
    known = np.ones((n_range_bins, layer_bins.shape[1]), dtype=bool)
    if scene.complete_layer_bins is None:
        return known
    bins = np.arange(n_range_bins)[:, None]
    lines = np.arange(layer_bins.shape[1])
    deepest = np.full(lines.size, -np.inf)
    for layer in layer_bins:
        picked = np.isfinite(layer)
        if not picked.any():
            continue
        continued = np.interp(lines, lines[picked], layer[picked])
        known &= picked | (np.abs(bins - continued) > reach_bins)
        deepest = np.maximum(deepest, continued)
    known &= bins <= deepest + reach_bins
    # A pick is known even where it lies near the gap of another layer.
    inside = np.isfinite(layer_bins) & (layer_bins > -0.5) & (layer_bins < n_range_bins - 0.5)
    known[np.rint(layer_bins[inside]).astype(int), np.broadcast_to(lines, layer_bins.shape)[inside]] = True
    return known
