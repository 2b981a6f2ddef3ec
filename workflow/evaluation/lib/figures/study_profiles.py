"""Profiles as measured: errors against a coherent solver by what causes them, and cost."""

import numpy as np
from matplotlib.ticker import NullFormatter

from evaluation.lib.figures.style import GUIDE, SERIES, new_figure
from evaluation.lib.profiles import compared

ASKED_DB = (1.0, 3.0)  # median, and 95 % of the cells
AXES = {
    "step_m": "step of the profile [m]",
    "lens_m": "thickness of ice lenses [m]",
    "lost_db": "lost to reflections above [dB]",
}
N_CLASSES = 6


def atlas_profiles(profiles):
    """Median and 95 % of the error by step, lens and loss, and error against cost, by band."""
    figure, axes = new_figure(2, 2, width=9.5, height=6.5)
    inside = compared(profiles)
    with_lenses = inside[inside["lens_m"] > 0]
    # Of losses, those beyond the warning too.
    whole = profiles[profiles["surface_db"] < inside["surface_db"].max()]
    shown = {"step_m": inside, "lens_m": with_lenses, "lost_db": whole}
    for ax, (name, table) in zip(axes.flat, shown.items(), strict=False):
        plot_errors(ax, table, name)
        ax.set_xlabel(AXES[name])
    axes[0, 0].legend()
    plot_cost(axes[1, 1], inside)
    return figure


def plot_errors(ax, table, name):
    """Median (lines) and 95 % (dashed) of cells in classes of equal number, by band."""
    for colour, (radar, rows) in zip(SERIES, table.groupby("radar", sort=False), strict=False):
        rank = rows[name].rank(method="first") - 1
        group = (rank * N_CLASSES / len(rows)).astype(int)
        error_db = rows["error_db"].abs()
        middle = rows[name].groupby(group).median()
        for share, style in {0.5: "o-", 0.95: "s--"}.items():
            label = radar if share == 0.5 else None
            ax.plot(
                middle, error_db.groupby(group).quantile(share), style, color=colour, label=label
            )
    for limit_db in ASKED_DB:
        ax.axhline(limit_db, **GUIDE)
    ax.set(xscale="log", yscale="log", ylabel="error: median, dashed: 95 % [dB]")
    ax.xaxis.set_minor_formatter(NullFormatter())
    ax.yaxis.set_minor_formatter(NullFormatter())


def plot_cost(ax, table):
    """Error of every profile's median cell against seconds, combined and by the solver."""
    table = table.assign(error_db=table["error_db"].abs(), in_power_db=table["in_power_db"].abs())
    keys = ["radar", "profile"]
    by_profile = table.groupby(keys, sort=False).median(numeric_only=True)
    for colour, (radar, rows) in zip(SERIES, by_profile.groupby(level=0, sort=False), strict=False):
        ax.plot(rows["seconds"], rows["error_db"], ".", color=colour, label=radar)
        seconds = np.median(rows["solver_seconds"])
        ax.axvline(seconds, color=colour, linewidth=0.8, linestyle=":")
    ax.set(xscale="log", yscale="log")
    ax.set(
        xlabel="seconds (dotted: the solver's median)", ylabel="median of a profile's cells [dB]"
    )
