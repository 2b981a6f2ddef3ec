"""Layers tracked in two passes over one place."""

import numpy as np
from scipy.ndimage import uniform_filter1d

from evaluation.lib.figures.style import BLUE, RED, new_figure

MARGIN_ROWS = 20  # below the deepest pick
SMOOTH_ROWS = 61
CONTRAST_DB = 3.5


def repeat_pass(picks):
    """Both pictures with their picks; layers that the other year has are in one colour."""
    years = picks["picture"].values
    figure, axes = new_figure(1, len(years), width=9, height=7, sharey=True)
    for ax, year in zip(axes[0], years, strict=True):
        of_year = picks.sel(picture=year)
        found = of_year["found"].values.astype(bool)
        texture = without_fall(of_year["power_db"].values)
        ax.imshow(texture, cmap="gray_r", vmin=-CONTRAST_DB, vmax=CONTRAST_DB)
        plot_rows(ax, of_year, found, BLUE, "in both years")
        plot_rows(ax, of_year, ~found, RED, "in this year alone")
        ax.set(title=year, xlabel="column of 100 m")
    axes[0, 0].set(ylabel="row below the surface", ylim=(deepest(picks), 0))
    axes[0, 1].legend(loc="lower right", frameon=True)
    return figure


def without_fall(power_db):
    """Decibels less their running mean down the rows, which falls with depth."""
    mean = np.nanmean(power_db[np.isfinite(power_db).any(axis=1)], axis=1)
    fall = uniform_filter1d(mean, SMOOTH_ROWS)
    return power_db[: len(fall)] - fall[:, None]


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
