"""Speed against accuracy, of the task and of PHY's arithmetic, and where methods fail."""

import numpy as np
from matplotlib.colors import ListedColormap

from evaluation.lib.figures.style import (
    BLACK,
    BLUE,
    GREEN,
    GUIDE,
    ORANGE,
    RED,
    list_downwards,
    new_figure,
    plt,
)

# Names of training sets, their colours, and how their names are aligned to the last point.
TRACKERS = {
    "rd": ("RD: annotated scenes", BLACK, "left"),
    "pd": ("PD: PHY's scenes", BLUE, "right"),
    "gd": ("GD: the cGAN's scenes", RED, "left"),
    "rd_pd": ("RD+PD", GREEN, "left"),
}
WAYS = {
    "convolution": ("numerical convolution", BLACK),
    "closed form": ("closed form, exact", GREEN),
    "table": ("table, by nodes a bin", BLUE),
}
BOUND_DB = 0.05  # of PHY's table
OUTCOMES = {"within": "right", "wrong": "wrong", "refused": "refused"}
OUTCOME_COLOURS = {"within": BLUE, "wrong": ORANGE, "refused": "0.75"}
QUANTITIES = {
    "peak_power": "peak power [%]",
    "decay_rate": "decay rate [%]",
    "width_bins": "1/e width [bins]",
}


def speed_accuracy(budgets, table):
    """Core-seconds against ODS, by what a tracker saw; time against error of PHY's arithmetic."""
    figure, axes = new_figure(1, 2, width=9, height=3.6)
    of_task, of_arithmetic = axes[0]
    plot_task(of_task, budgets)
    plot_arithmetic(of_arithmetic, table[table["panel"] == "mean power"])
    return figure


def plot_task(ax, budgets):
    """Fused ODS on validation scenes against the cost of scenes and training, by gradients."""
    cost = budgets["scenes_s"] + budgets["training_s"]
    keys = ["training_set", "n_gradients"]
    means = budgets.assign(cost=cost).groupby(keys)[["cost", "ods"]].mean().reset_index()
    for name, (label, colour, side) in TRACKERS.items():
        rows = means[means["training_set"] == name]
        ax.plot("cost", "ods", data=rows, color=colour, marker="o", markersize=4)
        last = rows.iloc[-1]
        is_alone = len(rows) == 1
        label = f"{label}, {last['n_gradients']}" if is_alone else label
        name_point(ax, label, last[["cost", "ods"]], colour, below=is_alone, ha=side, fontsize=8)
        for row in () if is_alone else rows.itertuples():
            name_point(ax, row.n_gradients, (row.cost, row.ods), colour, below=True, ha=side)
    ax.margins(x=0.25, y=0.15)
    ax.set(xscale="log", xlabel="core-seconds to make scenes and train a tracker")
    ax.set(ylabel="ODS on validation scenes", title="the task; numbers: gradients")


def plot_arithmetic(ax, runs):
    """Fastest runs of every way to PHY's mean power against its largest error."""
    runs = runs.assign(ns=runs["seconds"] / runs["n_pixels"] * 1e9)
    # The fastest: other jobs only ever add.
    points = runs.groupby(["method", "setting"], sort=False)[["ns", "error_db"]].min().reset_index()
    exact_at = points.loc[points["error_db"] > 0, "error_db"].min() / 50
    points["error_db"] = points["error_db"].where(points["error_db"] != 0, exact_at)
    for method, (label, colour) in WAYS.items():
        rows = points[points["method"] == method].sort_values("error_db")
        ax.plot("error_db", "ns", data=rows, color=colour, marker="o", markersize=4)
        name_point(ax, label, rows.iloc[0][["error_db", "ns"]], colour, ha="left", fontsize=8)
        if method == "table":
            for row in rows.itertuples():
                number = row.setting.removesuffix(" a bin")
                name_point(ax, number, (row.error_db, row.ns), colour, below=True)
    ax.axvline(BOUND_DB, **GUIDE)
    name_point(ax, " largest allowed", (BOUND_DB, 60), "0.5", ha="left")
    ax.margins(x=0.15, y=0.15)
    ax.set(xscale="log", yscale="log", xlabel="largest error [dB]; leftmost: exact")
    ax.set(ylabel="ns a pixel", title="PHY's arithmetic: mean power of 15 layers")


def name_point(ax, name, place, colour, *, below=False, ha="center", fontsize=6):
    """A name above a point, or below it."""
    style = {"xytext": (0, -4), "va": "top"} if below else {"xytext": (0, 5), "va": "bottom"}
    style |= {"ha": ha, "color": colour, "fontsize": fontsize}
    ax.annotate(name, tuple(place), textcoords="offset points", **style)


def atlas(atlas_phy, atlas_statistics):
    """Where methods fail: PHY's along four sweeps, and the estimators in a table."""
    figure = plt.figure(figsize=(10, 5.4))
    of_phy, of_estimators = figure.subfigures(2, 1, height_ratios=(1, 1.4))
    sweeps = atlas_phy.groupby("sweep", sort=False)
    for ax, (sweep, rows) in zip(of_phy.subplots(1, len(sweeps)), sweeps, strict=True):
        plot_outcomes(ax, rows)
        ax.set_xlabel(sweep)
    marks = [plt.Line2D([], [], color=colour, lw=5) for colour in OUTCOME_COLOURS.values()]
    of_phy.legend(marks, OUTCOMES.values(), loc="outside upper right", ncols=3, fontsize=8)
    of_phy.suptitle("PHY: values at which each way to mean power or speckle is right", fontsize=9)
    tabulate_estimators(of_estimators.subplots(), atlas_statistics)
    of_estimators.suptitle(
        "Estimators: mean error over layers on planted flights; white: within the bound", fontsize=9
    )
    return figure


def plot_outcomes(ax, rows):
    """A strip for each method, coloured by what happens at each value of a sweep."""
    methods = list(rows["method"].unique())
    for (method, outcome), part in rows.groupby(["method", "outcome"]):
        at = np.full(len(part), methods.index(method))
        ax.plot(part["value"], at, "s", color=OUTCOME_COLOURS[outcome], markersize=4)
    if (rows["value"] > 0).all():
        ax.set_xscale("log")
    list_downwards(ax, methods)


def tabulate_estimators(ax, rows):
    """Errors of each quantity by each estimator: a column a planted flight, coloured if beyond."""
    names = [
        (estimator, quantity) for estimator in ("deblended", "paper") for quantity in QUANTITIES
    ]
    places = rows[["sweep", "value"]].drop_duplicates().to_records(index=False).tolist()
    colours = np.zeros((len(names), len(places)))
    for column, (sweep, value) in enumerate(places):
        of_place = rows[(rows["sweep"] == sweep) & (rows["value"] == value)]
        for row, (estimator, quantity) in enumerate(names):
            found = of_place[of_place["estimator"] == estimator].set_index("quantity")
            found = found.reindex([quantity]).iloc[0]  # NaN: refused
            text = "-"  # refused
            colours[row, column] = 2
            if np.isfinite(found["error"]):
                in_percent = quantity != "width_bins"
                text = f"{100 * found['error']:+z.0f}" if in_percent else f"{found['error']:+z.1f}"
                colours[row, column] = abs(found["error"]) > found["bound"]
            ax.text(column, row, text, ha="center", va="center", fontsize=6)
    ax.imshow(colours, cmap=ListedColormap(["1.0", "#F6D6A8", "0.85"]), vmin=0, vmax=2)
    list_downwards(ax, [f"{QUANTITIES[quantity]}, {name}" for name, quantity in names])
    ax.set_xticks(range(len(places)), [f"{value:g}" for _, value in places], fontsize=7)
    for sweep in rows["sweep"].unique():
        at = [number for number, place in enumerate(places) if place[0] == sweep]
        ax.text(np.mean(at), len(names) + 0.6, sweep, ha="center", fontsize=8)
        ax.axvline(at[0] - 0.5, color=BLACK, linewidth=0.8)
