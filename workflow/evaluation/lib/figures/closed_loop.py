"""The closed loop: errors of statistics re-estimated from PHY's renders of label sets."""

import numpy as np

from evaluation.lib.figures.style import ZONE_COLOURS, ZONE_MARKERS, name_of, new_figure

MOST_BOUNDS = 6  # errors beyond so many bounds are drawn at the border
BY_PLACE = {
    "peak_power": "layer",
    "decay_rate": "layer",
    "width_bins": "layer",
    "thickness_mean_bins": "slab",
    "relative_thickness_mean": "slab",
}


def closed_loop(table):
    """Errors of `evaluation.lib.closed_loop.compare` by layer and slab, and of the whole flight."""
    figure, axes = new_figure(2, 3, width=9.5, height=5.5, sharey=True)
    *of_places, of_flight = axes.flat
    for ax, (quantity, along) in zip(of_places, BY_PLACE.items(), strict=True):
        rows = table[table["quantity"] == quantity]
        plot_errors(ax, rows, rows[along])
        ax.set(xlabel=along, title=name_of(quantity.removesuffix("_bins")))
    axes[1, 0].legend(["bound", *(f"zone {zone}" for zone in range(4))], ncols=3)
    of_whole = table[(table[["layer", "slab", "interface"]] == -1).all(axis=1)]
    at = np.arange(len(of_whole))
    plot_errors(of_flight, of_whole, at)
    of_flight.set_xticks(at, map(name_of, of_whole["quantity"]), rotation=90, fontsize=6)
    of_flight.set_title("the whole flight")
    for ax in axes[:, 0]:
        ax.set_ylabel("error / bound")
    return figure


def plot_errors(ax, rows, at):
    """Errors in units of their bounds at some places, with two standard errors."""
    ax.axhspan(-1, 1, color="0.92", zorder=0)
    ax.set_ylim(-MOST_BOUNDS, MOST_BOUNDS)
    for zone, part in rows.groupby("zone"):
        share = (part["error"] / part["bound"]).clip(-MOST_BOUNDS, MOST_BOUNDS)
        reach = 2 * part["error_standard_error"] / part["bound"]
        style = {"color": ZONE_COLOURS[zone], "marker": ZONE_MARKERS[zone]}
        beside = 0.18 * max(zone, 0)
        ax.errorbar(at[rows["zone"] == zone] + beside, share, reach, linestyle="", **style)
