"""The closed loop: errors of statistics re-estimated from PHY's renders of label sets."""

from evaluation.lib.figures.style import BLACK, name_of, new_figure

MOST_BOUNDS = 6  # errors beyond so many bounds are drawn at the border
PANELS = {
    "peak_power": "layer",
    "decay_rate": "layer",
    "width_bins": "layer",
    "thickness_mean_bins": "slab",
    "relative_thickness_mean": "slab",
}


def closed_loop(table):
    """Errors of `evaluation.lib.closed_loop.compare` by layer and slab, and of the whole flight."""
    share = (table["error"] / table["bound"]).clip(-MOST_BOUNDS, MOST_BOUNDS)
    table = table.assign(share=share)
    figure, axes = new_figure(2, 3, width=9.5, height=6.5, sharey=True)
    *of_places, of_flight = axes.flat
    for ax, (quantity, along) in zip(of_places, PANELS.items(), strict=True):
        rows = table[table["quantity"] == quantity]
        plot_errors(ax, rows[along], rows)
        ax.set(xlabel=along, title=name_of(quantity.removesuffix("_bins")))
    of_whole = table[(table[["layer", "slab", "interface"]] == -1).all(axis=1)]
    plot_errors(of_flight, of_whole["quantity"].map(name_of), of_whole)
    of_flight.tick_params("x", rotation=90, labelsize=6)
    of_flight.set_title("the whole flight")
    for ax in axes[:, 0]:
        ax.set_ylabel("error / bound")
    return figure


def plot_errors(ax, at, rows):
    """Errors in units of their bounds at some places."""
    ax.plot(at, rows["share"], "o", color=BLACK, markersize=2)
    ax.axhspan(-1, 1, color="0.92", zorder=0)
    ax.set_ylim(-MOST_BOUNDS, MOST_BOUNDS)
