"""What a generator was trained on, as ranges of a scene's geometry, and which scenes lie outside them."""

import numpy as np

STEEP, CLOSE = 98, 2  # [%] of slopes and of spacings: single pixels decide nothing
LINES = 16  # over which a slope is taken: picks are whole bins


def geometry(scene):
    """Height [range bins], layers below the surface, slope [bins per range line] and spacing [bins] of a `Scene`.

    Slope is a layer's where it is steep, spacing that of neighbours where they are close; none
    where there is none.
    """
    layers = scene.layer_bins[np.isfinite(scene.layer_bins).any(axis=1)]
    found = {"height": scene.n_range_bins, "layers": max(len(layers) - 1, 0)}
    slopes = (layers[:, LINES:] - layers[:, :-LINES]) / LINES
    for name, values, share in (
        ("slope", slopes, STEEP),
        ("spacing", np.diff(layers, axis=0), CLOSE),
    ):
        values = np.abs(values[np.isfinite(values)])
        if values.size:
            found[name] = float(np.percentile(values, share))
    return found


def scope_of(scenes):
    """Least and most of every quantity of `geometry` over scenes, lists by name; to be kept with the generator."""
    found = [geometry(scene) for scene in scenes]
    names = {name for of_scene in found for name in of_scene}
    held = {
        name: [of_scene[name] for of_scene in found if name in of_scene] for name in sorted(names)
    }
    return {name: [min(values), max(values)] for name, values in held.items()}


def outside(scene, scope):
    """Quantities of a scene that lie outside a scope, each with its value and the range, in words."""
    beyond = {name: value for name, value in geometry(scene).items() if name in scope}
    return [
        f"{name} {value:.4g}, trained on {scope[name][0]:.4g} to {scope[name][1]:.4g}"
        for name, value in beyond.items()
        if not scope[name][0] <= value <= scope[name][1]
    ]
