"""Speed against accuracy, where methods fail, and core-seconds against worth to a tracker."""

import numpy as np

from evaluation.lib.figures.style import (
    BLACK,
    BLUE,
    COLOURS,
    GREEN,
    GUIDE,
    ORANGE,
    RED,
    new_figure,
    new_panel,
)

POWER = ("error_db", "largest error of mean power plus noise [dB]")
# Column of errors of each panel, and their axis.
PANELS = {
    "mean power": POWER,
    "speckle": ("distance", "distance of distribution functions"),
    "whole scenes": POWER,
}
METHOD_COLOURS = {
    "closed form": GREEN,
    "convolution": BLACK,
    "table": BLUE,
    "looks": BLACK,
    "gamma": GREEN,
    "quantile": BLUE,
    "PHY, as printed": BLACK,
    "PHY, exact": GREEN,
    "PHY": BLUE,
    "cGAN": RED,
    "one float32 normal a pixel": "0.5",
    "exact": GREEN,
    "naive closed form": ORANGE,
}
LEAST_ERROR_DB = 1e-14
MOST_ERROR_DB = 1e2  # of the atlas; beyond, drawn at the border
QUANTITIES = {
    "peak_power": "relative error of peak power",
    "decay_rate": "relative error of decay rate",
    "width_bins": "error of 1/e width [bins]",
}
MOST_BOUNDS = 300  # errors of estimators beyond so many bounds are drawn there
# Training sets of each series of the chart of costs, and whether it tells those of trainings, by
# gradients, or those of scenes.
BUDGETS = {
    "trainings on RD, by gradients": ("rd", "training_s", {"color": BLACK, "marker": "o"}),
    "trainings on PD, by gradients": ("pd", "training_s", {"color": BLUE, "marker": "o"}),
    "PHY's scenes": ("pd", "scenes_s", {"color": BLUE, "marker": "D"}),
    "the cGAN's scenes": ("gd", "scenes_s", {"color": RED, "marker": "D"}),
}
# Where names of points stand, by turns: right below and above.
SIDES = (
    {"xytext": (3, -4), "ha": "left", "va": "top"},
    {"xytext": (0, 5), "ha": "center", "va": "bottom"},
)


def speed_accuracy(table):
    """Fastest run of every way against its error: parts of PHY, and whole scenes."""
    figure, axes = new_figure(1, 3, width=11, height=3.6)
    for ax, (panel, (column, xlabel)) in zip(axes[0], PANELS.items(), strict=True):
        plot_ways(ax, table[table["panel"] == panel], column)
        ax.set(xlabel=xlabel, title=panel)
    axes[0, 0].set_ylabel("ns per pixel")
    return figure


def plot_ways(ax, runs, column):
    """Fastest runs against error; lines where no error is known, for these are other models."""
    runs = runs.assign(ns=runs["seconds"] / runs["n_pixels"] * 1e9)
    # The fastest: other jobs only ever add.
    points = runs.groupby(["method", "setting"], sort=False)[["ns", column]].min().reset_index()
    inexact = points[column] > 0
    least = points.loc[inexact, column].min()
    exact_at = least / 50
    points["x"] = points[column].where(points[column] != 0, exact_at)
    for method, rows in points.groupby("method", sort=False):
        style = {"color": METHOD_COLOURS[method], "label": method}
        if rows["x"].isna().all():
            ax.axhline(rows["ns"].min(), linestyle=":", linewidth=1, **style)
            continue
        ax.plot("x", "ns", "o", data=rows, markersize=4, **style)
        for number, row in enumerate(rows.itertuples(), start=1):
            # Numbers alone: names of tables half as fine lie too close to stand side by side.
            name = row.setting.removesuffix(" a bin")
            name_point(ax, name, (row.x, row.ns), number)
    ax.axvspan(exact_at / 10, exact_at * 10, color="0.93", zorder=0)
    ax.annotate("exact", (exact_at, 0.01), xycoords=("data", "axes fraction"), fontsize=7)
    ax.margins(y=0.12)
    ax.set(xscale="log", yscale="log", xlim=(exact_at / 10, 10 * points[column].max()))
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2), ncols=3)


def name_point(ax, name, place, number):
    """A name beside a point, by number on one side or the other: points may coincide."""
    side = SIDES[number % 2]
    ax.annotate(name, place, textcoords="offset points", fontsize=6, **side)


def atlas(atlas_phy, atlas_statistics):
    """Where PHY's methods fail, in the first row, and the estimators, below."""
    figure, axes = new_figure(1 + len(QUANTITIES), 4, width=11, height=10)
    of_phy = atlas_phy.groupby("sweep", sort=False)
    for ax, (sweep, rows) in zip(axes[0], of_phy, strict=True):
        plot_methods(ax, rows)
        ax.set_xlabel(sweep)
    axes[0, 0].set_ylabel("largest error [dB]")
    of_estimators = atlas_statistics.groupby("sweep", sort=False)
    for column, (sweep, rows) in zip(axes[1:].T, of_estimators, strict=True):
        for ax, quantity in zip(column, QUANTITIES, strict=True):
            plot_estimators(ax, rows, quantity)
        column[-1].set_xlabel(sweep)
    for ax, label in zip(axes[1:, 0], QUANTITIES.values(), strict=True):
        ax.set_ylabel(label)
    axes[0, 2].legend(loc="center")
    axes[0, 3].legend(loc="lower left")
    axes[1, 0].legend()
    return figure


def plot_methods(ax, rows):
    """Largest error of each method along a sweep.

    Crosses are wrong, bars in the grey band refused; dotted, the limit of what is held to one.
    """
    for number, (method, part) in enumerate(rows.groupby("method", sort=False)):
        part = part.sort_values("value")
        style = {"color": METHOD_COLOURS[method]}
        error_db = part["error_db"].clip(LEAST_ERROR_DB, MOST_ERROR_DB)
        ax.plot(part["value"], error_db, label=method, **style)
        wrong = part["outcome"] == "wrong"
        ax.plot(part["value"][wrong], error_db[wrong], "x", markersize=4, **style)
        refused = part.loc[part["outcome"] == "refused", "value"]
        height = 3 * MOST_ERROR_DB * 10**number
        ax.plot(refused, np.full(len(refused), height), "|", markersize=5, **style)
    limit = rows.query("method in ('table', 'gamma')").sort_values("value")
    ax.plot(limit["value"], limit["limit_db"], **GUIDE)
    ax.axhspan(1.5 * MOST_ERROR_DB, 1e5, color="0.93", zorder=0)
    if (rows["value"] > 0).all():
        ax.set_xscale("log")
    ax.set(yscale="log", ylim=(LEAST_ERROR_DB / 3, 1e5))
    ax.set_yticks(10.0 ** np.arange(-14, 3, 4))


def plot_estimators(ax, rows, quantity):
    """Mean error over layers of one quantity along a sweep.

    The bound is in grey; crosses at the top are refused.
    """
    rows = rows.query("quantity in (@quantity, 'all')")
    bound = rows["bound"].max()
    limit = MOST_BOUNDS * bound
    ax.axhspan(-bound, bound, color="0.9", zorder=0)
    for estimator, part in rows.groupby("estimator", sort=False):
        colour = COLOURS[estimator]
        held = part.query("outcome != 'refused'")
        style = {"color": colour, "marker": "o", "label": estimator}
        ax.plot("value", "error", data=held, **style)
        refused = part.query("outcome == 'refused'")["value"]
        ax.plot(refused, np.full(len(refused), limit), "x", color=colour, markersize=4)
    ax.set_yscale("symlog", linthresh=bound)
    ax.set_ylim(-1.5 * limit, 1.5 * limit)
    ticks = bound * np.array([-100, -10, -1, 0, 1, 10, 100])
    ax.set_yticks(ticks, [f"{tick:g}" for tick in ticks])
    values = sorted(rows["value"].unique())
    if values[0] > 0:
        ax.set_xscale("log")
    ax.set_xticks(values, [f"{value:g}" for value in values], fontsize=7)
    ax.set_xticks([], minor=True)


def cost_worth(budgets):
    """Fused ODS on validation scenes against core-seconds: of trainings, and of what they see."""
    figure, ax = new_panel(width=6.5, height=4)
    keys = ["training_set", "n_gradients"]
    means = budgets.groupby(keys)[["training_s", "scenes_s", "ods"]].mean().reset_index()
    # Trackers on the scenes of either renderer alone are compared at the same number of gradients.
    (n_gradients,) = means.query("training_set == 'gd'")["n_gradients"]
    for number, (series, (name, cost, style)) in enumerate(BUDGETS.items()):
        rows = means[means["training_set"] == name]
        if cost == "scenes_s":
            rows = rows[rows["n_gradients"] == n_gradients]
        ax.plot(cost, "ods", data=rows, markersize=5, label=series, **style)
        for row in rows.itertuples():
            name_point(ax, row.n_gradients, (getattr(row, cost), row.ods), number)
    ax.set(xscale="log", xlabel="core-seconds of a training, or to make scenes")
    ax.set_ylabel("fused ODS on validation scenes")
    ax.legend(loc="lower right")
    return figure
