"""Label sets beside the flight that they were drawn from."""

import numpy as np
import pandas as pd

from evaluation.lib.figures.style import BLUE, GREY, new_figure

FLIGHT = {"marker": "o", "linestyle": "", "color": GREY, "label": "flight"}
DRAWN = {"color": BLUE, "label": "label sets"}


def labels(scenes, statistics, scale):
    """Number of layers, first slab and all slabs: flight, and label sets; titles compare them."""
    figure, axes = new_figure(1, 3, width=10)
    of_layers, of_first, of_slabs = axes[0]
    notes = pd.DataFrame([scene.notes for scene in scenes])
    plot_numbers(of_layers, notes["n_layers"], statistics)
    plot_first(of_first, notes["first_thickness_bins"] * scale.bin_m, statistics, scale)
    plot_slabs(of_slabs, pd.concat(map(relative_thickness, scenes), axis=1), statistics)
    for ax in axes[0]:
        ax.legend()
    return figure


def plot_numbers(ax, drawn, statistics):
    """Shares of blocks and of scenes by their number of layers.

    Blocks without a layer below the surface are in no zone of the statistics, and are added here.
    """
    n_blocks = statistics["n_blocks_by_layers"].sum("zone").values
    n_blocks[0] += statistics.attrs.get("n_blocks_without_layers", 0)
    in_flight = np.repeat(np.arange(n_blocks.size), n_blocks)
    numbers = np.arange(max(in_flight.max(), drawn.max()) + 1)
    for n_layers, style in ((in_flight, FLIGHT), (drawn, DRAWN)):
        ax.plot(numbers, [100 * np.mean(n_layers <= number) for number in numbers], **style)
    bare, drawn_bare = (100 * np.mean(n_layers == 0) for n_layers in (in_flight, drawn))
    ax.set(xlabel="layers below the surface", ylabel="share with at most so many [%]")
    ax.set_title(f"surface alone: flight {bare:.0f} %, label sets {drawn_bare:.0f} %")


def plot_first(ax, drawn_m, statistics, scale):
    """Distribution of the mean thickness of slab 0."""
    quantile_m = statistics["first_thickness_quantile_bins"] * scale.bin_m
    percent = np.linspace(0, 100, quantile_m.size)
    ax.plot(quantile_m, percent, **FLIGHT)
    ax.plot(np.percentile(drawn_m, percent), percent, **DRAWN)
    ax.set(xlabel="mean thickness of slab 0 [m]", ylabel="share that is thinner [%]")
    ax.set_title(f"mean: flight {quantile_m.mean():.2f} m, label sets {drawn_m.mean():.2f} m")


def plot_slabs(ax, drawn, statistics):
    """Mean thickness of slabs relative to slab 0; `drawn` has a column for each scene."""
    by_zone = statistics["relative_thickness_mean"].fillna(0)
    of_flight = by_zone.weighted(statistics["n_samples"]).mean("zone").to_series()
    means = drawn.mean(axis=1)
    ax.plot(of_flight, **FLIGHT)
    ax.plot(means, **DRAWN)
    ax.set(xlabel="slab", ylabel="mean thickness / slab 0")
    off = (means / of_flight - 1).abs().dropna()
    if not off.empty:  # else no scene has a slab
        ax.set_title(f"furthest apart: slab {off.idxmax()}, by {100 * off.max():.0f} %")


def relative_thickness(scene):
    """Mean thickness of the slabs of a drawn scene relative to slab 0."""
    thickness = np.diff(scene.layer_bins.mean(axis=1))
    return pd.Series(thickness / thickness[:1])
