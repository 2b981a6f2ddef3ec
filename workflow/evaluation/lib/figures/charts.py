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
from evaluation.lib.studied import studied_set
from snowsim.tracker.sampling import PAPER_SCENES_PER_REAL

# Colours of training sets by the scenes that are added to them, and marks by the real ones.
ADDED = {
    (): BLACK,
    ("phy",): BLUE,
    ("cgan",): RED,
    ("cgan_as_picked",): ORANGE,
    ("phy", "cgan"): GREEN,
}
REAL = {None: "s", "train": "o", "sample": "^", "completed": "D"}
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
    figure, axes = new_figure(1, 2, width=11, height=4.2, width_ratios=(1.5, 1))
    of_task, of_arithmetic = axes[0]
    plot_task(of_task, budgets)
    plot_arithmetic(of_arithmetic, table[table["panel"] == "mean power"])
    return figure


def plot_task(ax, budgets):
    """Fused ODS on validation scenes against the cost of scenes and training, a line a set.

    A point is the mean of the trainings with one number of gradients. The best of each set is
    large; the legend names it. Rows without a cost were trained beside other jobs: left out.
    """
    budgets = budgets.dropna(subset=["scenes_s", "training_s"])
    cost = budgets["scenes_s"] + budgets["training_s"]
    keys = ["training_set", "n_gradients"]
    means = budgets.assign(cost=cost).groupby(keys)[["cost", "ods"]].mean().reset_index()
    best = means.loc[means.groupby("training_set")["ods"].idxmax()]
    for point in best.sort_values("ods", ascending=False).itertuples():
        shown = studied_set(point.training_set)
        style = {"color": ADDED[shown.added], "marker": REAL[shown.real]}
        is_variant = shown.labels == "complete" or shown.added_per_real == PAPER_SCENES_PER_REAL
        style["linestyle"] = ":" if is_variant else "-"
        rows = means[means["training_set"] == point.training_set]
        label = f"{shown.about}: {point.ods:.3f}, {point.n_gradients} gradients"
        ax.plot(rows["cost"], rows["ods"], markersize=3, linewidth=0.9, **style)
        ax.plot(point.cost, point.ods, markersize=7, label=label, **style)
    ax.legend(fontsize=6, loc="center left", bbox_to_anchor=(1, 0.5))
    ax.set(xscale="log", xlabel="core-seconds to make scenes and train a tracker")
    ax.set_ylabel("ODS on validation scenes")
    ax.set_title("each point: trackers on one set with one number of gradients")


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
