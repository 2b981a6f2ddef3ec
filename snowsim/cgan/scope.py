"""What a generator was trained on, as ranges of a scene's geometry, and scenes outside them."""

import numpy as np
import pandas as pd

STEEP = 98  # [%] of slopes: single pixels decide nothing
CLOSE = 2  # [%] of spacings
LINES = 16  # over which a slope is taken: picks are whole bins


def geometry(scene):
    """Height [range bins], layers below the surface, slope and spacing of a `Scene`.

    Slope [bins per range line] is a layer's where it is steep, spacing [bins] that of neighbours
    where they are close; none where there is none.
    """
    layers = scene.layer_bins[np.isfinite(scene.layer_bins).any(axis=1)]
    found = {"height": scene.n_range_bins, "layers": max(len(layers) - 1, 0)}
    slopes = _distances(layers[:, :-LINES], layers[:, LINES:]) / LINES
    if slopes.size:
        found["slope"] = float(np.percentile(slopes, STEEP))
    spacings = _distances(layers[:-1], layers[1:])
    if spacings.size:
        found["spacing"] = float(np.percentile(spacings, CLOSE))
    return found


def _distances(start, end):
    """Distances between layers, or between places of layers, where both are."""
    distances = np.abs(end - start)
    return distances[np.isfinite(distances)]


def scope_of(scenes):
    """Least and most of every quantity of `geometry` over scenes, lists by name.

    It is kept with the generator.
    """
    table = pd.DataFrame([geometry(scene) for scene in scenes])
    return table.agg(["min", "max"]).to_dict("list")


def outside(scene, scope):
    """Quantities of a scene outside a scope, each with its value and the range, in words."""
    words = []
    for name, value in geometry(scene).items():
        least, most = scope.get(name, (-np.inf, np.inf))
        if not least <= value <= most:
            words.append(f"{name} {value:.4g}, trained on {least:.4g} to {most:.4g}")
    return words
