"""Speed against accuracy, of the task and of PHY's arithmetic, and where methods fail."""

import numpy as np
from matplotlib.colors import ListedColormap
from scipy.optimize import isotonic_regression

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
EDGE = 1.3  # factor of cost from the costliest point to the marks and names at the right
NAMES_WIDTH = 60  # factor of cost that the names take
NAMES_A_PANEL = 22  # names of sets that fit one below the other
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
    figure, axes = new_figure(1, 2, width=11, height=4.6, width_ratios=(1.6, 1))
    of_task, of_arithmetic = axes[0]
    plot_task(of_task, budgets)
    plot_arithmetic(of_arithmetic, table[table["panel"] == "mean power"])
    return figure


def plot_task(ax, budgets):
    """Fused ODS on validation scenes against the cost of scenes and training, a line a set.

    A point is the mean of the trainings with one number of gradients. The best of each set is
    large, and a line joins it to the set's name. Sets that were trained beside other jobs have no
    cost: their best is a cross at the right edge.
    """
    cost = budgets["scenes_s"] + budgets["training_s"]
    keys = ["training_set", "n_gradients"]
    means = budgets.assign(cost=cost).groupby(keys)[["cost", "ods"]].mean().reset_index()
    edge = means["cost"].max() * EDGE
    best = means.loc[means.groupby("training_set")["ods"].idxmax()].sort_values("ods")
    heights = kept_apart(best["ods"], np.ptp(means["ods"]) / NAMES_A_PANEL)
    for point, height in zip(best.itertuples(), heights, strict=True):
        shown = studied_set(point.training_set)
        is_variant = shown.labels == "complete" or shown.added_per_real == PAPER_SCENES_PER_REAL
        style = {"color": ADDED[shown.added], "linestyle": ":" if is_variant else "-"}
        rows = means[means["training_set"] == point.training_set].dropna(subset=["cost"])
        mark = REAL[shown.real]
        ax.plot(rows["cost"], rows["ods"], marker=mark, markersize=3, linewidth=0.9, **style)
        has_cost = np.isfinite(point.cost)
        at = point.cost if has_cost else edge
        ax.plot(at, point.ods, marker=mark if has_cost else "x", markersize=7, **style)
        name = f"{shown.about}: {point.ods:.3f}, {point.n_gradients} gradients"
        ends = ([at, edge * EDGE], [point.ods, height])
        ax.plot(*ends, color=style["color"], linewidth=0.4)
        ax.text(edge * EDGE, height, f" {name}", color=style["color"], fontsize=7, va="center")
    ax.set(xscale="log", xlim=(means["cost"].min() / EDGE, edge * NAMES_WIDTH))
    # Ticks where points are, not where names are.
    low, high = means["cost"].min(), edge
    ticks = np.outer(10.0 ** np.arange(np.floor(np.log10(low)), np.log10(high)), (1, 2, 5)).ravel()
    ticks = ticks[(ticks >= low) & (ticks <= high)]
    ax.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    ax.set_xticks([], minor=True)
    ax.set_xlabel("core-seconds to make scenes and train a tracker", loc="left")
    ax.set_ylabel("ODS on validation scenes")
    crosses = "; cross: cost not measured" if best["cost"].isna().any() else ""
    ax.set_title(
        "A point is the mean of the trackers trained on one set with one number of gradients;\n"
        f"the best of each set is large and named. Square: no real scenes{crosses}",
        loc="left",
    )


def kept_apart(values, least):
    """Ascending values, moved by as little as needed to lie at least `least` apart."""
    values = np.asarray(values, dtype=float)
    steps = least * np.arange(values.size)
    # The nearest ascending sequence to what is left of each after its own step.
    return isotonic_regression(values - steps).x + steps


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
    figure = plt.figure(figsize=(11, 6.2))
    of_phy, of_estimators = figure.subfigures(2, 1, height_ratios=(1, 1.3))
    sweeps = atlas_phy.groupby("sweep", sort=False)
    for ax, (sweep, rows) in zip(of_phy.subplots(1, len(sweeps)), sweeps, strict=True):
        plot_outcomes(ax, rows)
        ax.set_xlabel(sweep)
        ax.set_title(seen_of_methods(rows), fontsize=7, loc="left")
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


def seen_of_methods(rows):
    """What a sweep shows, in words: methods that are right everywhere, and those that are not."""
    is_right = (rows["outcome"] != "wrong").groupby(rows["method"], sort=False).all()
    right, wrong = (is_right.index[is_right == value] for value in (True, False))
    sentence = f"Never wrong: {', '.join(right)}" if len(right) else "None is always right"
    return f"{sentence};\nwrong in orange: {', '.join(wrong)}." if len(wrong) else f"{sentence}."


def seen_of_estimators(rows):
    """What a sweep shows, in words: how many errors each estimator keeps within the bounds."""
    n_errors = len(QUANTITIES) * rows["value"].nunique()
    is_within = rows["error"].abs() <= rows["bound"]
    counts = is_within.groupby(rows["estimator"], sort=False).sum()
    of_each = [f"{name} {count}" for name, count in counts.items()]
    return f"Of {n_errors} errors, within the bound:\n{', '.join(of_each)}."


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
        seen = seen_of_estimators(rows[rows["sweep"] == sweep])
        ax.text(np.mean(at), -0.6, seen, ha="center", va="bottom", fontsize=7)
        ax.axvline(at[0] - 0.5, color=BLACK, linewidth=0.8)
