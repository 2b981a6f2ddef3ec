"""Label sets beside the flight that they were drawn from."""

import numpy as np
import pandas as pd

from evaluation.lib.figures.style import BLUE, GREY, new_figure

FLIGHT = {"marker": "o", "linestyle": "", "color": GREY, "label": "flight"}
DRAWN = {"color": BLUE, "label": "label sets"}


def labels(scenes, statistics, scale):
    """Number of layers, first slab and thickness of all slabs: flight, and label sets."""
    figure, axes = new_figure(1, 3, width=9.5)
    of_layers, of_first, of_slabs = axes[0]
    notes = pd.DataFrame([scene.notes for scene in scenes])
    n_blocks = statistics["n_blocks_by_layers"].sum("zone")
    n_layers = np.arange(n_blocks.size)
    of_layers.plot(n_layers, 100 * n_blocks / n_blocks.sum(), **FLIGHT)
    n_scenes = np.bincount(notes["n_layers"])
    of_layers.step(np.arange(n_scenes.size), 100 * n_scenes / len(notes), where="mid", **DRAWN)
    of_layers.set(xlabel="layers below the surface", ylabel="share [%]", title="number of layers")

    quantile_m = statistics["first_thickness_quantile_bins"] * scale.bin_m
    percent = np.linspace(0, 100, quantile_m.size)
    of_first.plot(quantile_m, percent, **FLIGHT)
    drawn_bins = np.quantile(notes["first_thickness_bins"], percent / 100)
    of_first.plot(drawn_bins * scale.bin_m, percent, **DRAWN)
    of_first.set(xlabel="mean thickness [m]", ylabel="share that is thinner [%]", title="slab 0")

    by_zone = statistics["relative_thickness_mean"].fillna(0)
    of_slabs.plot(by_zone.weighted(statistics["n_samples"]).mean("zone"), **FLIGHT)
    drawn = pd.concat(map(relative_thickness, scenes), axis=1)
    of_slabs.plot(drawn.mean(axis=1), **DRAWN)
    of_slabs.set(xlabel="slab", ylabel="mean thickness / slab 0", title="all slabs")
    for ax in axes[0]:
        ax.legend()
    return figure


def relative_thickness(scene):
    """Mean thickness of the slabs of a drawn scene relative to slab 0."""
    thickness = np.diff(scene.layer_bins.mean(axis=1))
    return pd.Series(thickness / thickness[:1])
