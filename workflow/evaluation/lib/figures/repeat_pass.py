"""Layers tracked in two passes over one place."""

import numpy as np

from evaluation.lib.figures.style import BLUE, RED, new_figure

MARGIN_ROWS = 20  # below the deepest pick
CONTRAST_DB = (-31.0, -15.0)


def repeat_pass(picks):
    """Both pictures with their picks; layers that the other year has are in one colour."""
    years = picks["picture"].values
    figure, axes = new_figure(1, len(years), width=9, height=7, sharey=True)
    low, high = CONTRAST_DB
    for ax, year in zip(axes[0], years, strict=True):
        of_year = picks.sel(picture=year)
        found = of_year["found"].values.astype(bool)
        ax.imshow(of_year["power_db"], cmap="gray_r", vmin=low, vmax=high)
        plot_rows(ax, of_year, found, BLUE, "in both years")
        plot_rows(ax, of_year, ~found, RED, "in this year alone")
        ax.set(title=year, xlabel="column of 100 m")
    axes[0, 0].set(ylabel="row below the surface", ylim=(deepest(picks), 0))
    axes[0, 1].legend(loc="lower right")
    return figure


def plot_rows(ax, picks, chosen, colour, label):
    """Chosen layers of a year, one of them named."""
    rows = picks["row"].values[chosen]
    # Layers in a line, with gaps between: one line has one label.
    columns = np.arange(rows.shape[1] + 1)
    with_gaps = np.pad(rows, ((0, 0), (0, 1)), constant_values=np.nan)
    every = np.tile(columns, len(rows))
    ax.plot(every, with_gaps.ravel(), color=colour, linewidth=1, label=label)


def deepest(picks):
    """Row at which the figure ends."""
    return float(np.nanmax(picks["row"].values, initial=0)) + MARGIN_ROWS
