"""Label sets beside the flight that they were drawn from."""

import numpy as np
import pandas as pd

from evaluation.lib.figures.style import BLUE, GREY, ZONE_COLOURS, ZONE_MARKERS, new_figure
from snowsim.statistics.zones import OWN_ZONE

ENOUGH_SCENES = 10  # of a zone, for a mean of theirs


def labels(scenes, statistics, scale):
    """Number of layers, first slab and thickness of deeper slabs: flight, and label sets."""
    figure, axes = new_figure(1, 3, width=9.5)
    of_layers, of_first, of_slabs = axes[0]
    notes = pd.DataFrame([scene.notes for scene in scenes])
    n_blocks = statistics["n_blocks_by_layers"].sum("zone")
    percent = 100 * n_blocks / n_blocks.sum()
    of_layers.bar(np.arange(percent.size), percent, width=1, color="0.75", label="flight")
    drawn_percent = 100 * notes["n_layers"].value_counts(normalize=True, sort=False).sort_index()
    of_layers.step(drawn_percent.index, drawn_percent, where="mid", color=BLUE, label="label sets")
    of_layers.set(xlabel="layers below the surface", ylabel="share [%]", title="number of layers")

    quantile_m = statistics["first_thickness_quantile_bins"] * scale.bin_m
    percent = np.linspace(0, 100, quantile_m.size)
    of_first.plot(quantile_m, percent, "o", color=GREY, label="flight")
    drawn_m = np.quantile(notes["first_thickness_bins"], percent / 100) * scale.bin_m
    of_first.plot(drawn_m, percent, color=BLUE, label="label sets")
    of_first.set(xlabel="mean thickness [m]", ylabel="share that is thinner [%]", title="slab 0")

    plot_slabs(of_slabs, relative_thickness(scenes), statistics)
    for ax in axes[0]:
        ax.legend()
    return figure


def relative_thickness(scenes):
    """Mean thickness of slabs relative to slab 0, (zone, slab), where enough scenes have it."""
    rows = []
    for scene in scenes:
        layers = scene.layer_bins
        # All that were drawn, labelled or not.
        if scene.complete_layer_bins is not None:
            layers = scene.complete_layer_bins[: len(layers)]
        thickness = np.diff(layers.mean(axis=1))
        rows.append(thickness / thickness[:1])
    zones = np.array([scene.zone for scene in scenes])
    by_zone = pd.DataFrame(rows).groupby(zones)
    return by_zone.mean().where(by_zone.count() >= ENOUGH_SCENES)


def plot_slabs(ax, drawn, statistics):
    """Mean thickness of slabs relative to slab 0 by zone: points flight, lines label sets."""
    own = statistics["relative_thickness_mean"].where(statistics["source"] == OWN_ZONE)
    for zone, of_zone in drawn.iterrows():
        style = {"color": ZONE_COLOURS[zone], "marker": ZONE_MARKERS[zone]}
        ax.plot(own.isel(zone=zone), linestyle="", label=f"zone {zone}", **style)
        ax.plot(of_zone, color=ZONE_COLOURS[zone], linewidth=1)
    ax.set(xlabel="slab", ylabel="mean thickness / slab 0", title="flight (points), label sets")
