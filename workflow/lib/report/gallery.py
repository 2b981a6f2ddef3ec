"""Which scenes the gallery shows, and their layers as lines a page can draw."""

import numpy as np

LINE_STEP = 2  # every other range line of a layer is drawn


def choose_scenes(n_layers, n_scenes):
    """Indices of scenes at evenly spaced ranks of their number of layers, in that order; all if there are fewer."""
    order = np.argsort(np.asarray(n_layers), kind="stable")
    ranks = np.unique(np.rint(np.linspace(0, order.size - 1, min(n_scenes, order.size))).astype(int))
    return [int(i) for i in order[ranks]]


def layer_lines(layer_bins, step=LINE_STEP):
    """Layers as lists of unbroken pieces.

    Parameters
    ----------
    layer_bins : array_like, (layer, range_line)
        Fractional range bins, NaN where absent.
    step : int
        Every so many range lines a point; first and last are kept.

    Returns
    -------
    list of list of list
        layer -> piece -> [range_line, range_bin, range_line, range_bin, ...], bins to a tenth.
    """
    layer_bins = np.asarray(layer_bins, dtype=float)
    chosen = np.unique(np.r_[np.arange(0, layer_bins.shape[1], step), layer_bins.shape[1] - 1])
    layers = []
    for bins in layer_bins[:, chosen]:
        present = np.isfinite(bins)
        starts = np.flatnonzero(present & ~np.r_[False, present[:-1]])
        stops = np.flatnonzero(present & ~np.r_[present[1:], False]) + 1
        layers.append(
            [
                [float(x) for pair in zip(chosen[a:b], np.round(bins[a:b], 1), strict=True) for x in pair]
                for a, b in zip(starts, stops, strict=True)
            ]
        )
    return layers
