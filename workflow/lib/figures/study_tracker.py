"""Studies of the tracker: ablation, what seeds resolve, where it fails."""

import numpy as np

from lib.figures.style import BLACK, COLOURS, NAMES, RED, name_of, new_figure

METRIC = "ods"
# Panels of the atlas: what is shown, along what, and of what axis.
PANELS = {
    "loss": ("loss after a short training", "learning rate", "log"),
    "brightness": ("ODS of fuse", "shift [grey levels]", "linear"),
    "rows cut": ("ODS of fuse", "rows above a multiple of 16 less", "linear"),
    "layers": ("ODS of fuse", "level layers below the surface", "linear"),
}


def tracker_ablation(ablation):
    """Difference of every setting to the default of its training set."""
    figure, axes = new_figure(width=6, height=4)
    rows = ablation[(ablation["metric"] == METRIC) & (ablation["setting"] != "default")].iloc[::-1]
    labels = [f"{name_of(row.setting)}, {NAMES[row.training_set]}" for row in rows.itertuples()]
    plot_intervals(axes[0, 0], rows, labels)
    axes[0, 0].tick_params("y", labelsize=7)
    axes[0, 0].set_xlabel(f"{NAMES[METRIC]} less that of the default")
    return figure


def tracker_worth(worth):
    """Score of a training set less that of another with 95 % interval; grey: the least detectable one."""
    figure, axes = new_figure(1, 2, width=9, height=4, sharey=True)
    for ax, metric in zip(axes.flat, ("ods", "ap"), strict=True):
        rows = worth[worth["metric"] == metric].iloc[::-1]
        for y, row in enumerate(rows.itertuples()):
            ax.barh(y, 2 * row.detectable, left=-row.detectable, height=0.6, color="0.9")
        plot_intervals(ax, rows, [worth_label(row) for row in rows.itertuples()])
        ax.tick_params("y", labelsize=7)
        ax.set_xlabel(f"difference of {NAMES[metric]}")
    return figure


def worth_label(row):
    """Names of both training sets, and of their settings where these are not the default."""
    runs = (row.training_set, row.setting), (row.base_training_set, row.base)
    return " less ".join(
        NAMES[s] + ("" if how == "default" else f", {name_of(how)}") for s, how in runs
    )


def plot_intervals(ax, rows, labels):
    """Differences with their intervals, a row each, coloured by training set."""
    for y, row in enumerate(rows.itertuples()):
        ax.hlines(y, row.low, row.high, color=COLOURS[row.training_set])
        ax.plot(row.difference, y, "o", color=COLOURS[row.training_set], markersize=4)
    ax.axvline(0, color="0.5", linewidth=0.8)
    ax.set_yticks(range(len(rows)), labels)


def atlas_tracker(atlas):
    """Where the tracker fails; crosses at the lower border: diverged or refused."""
    figure, axes = new_figure(2, 2, width=8, height=5.5)
    for ax, (panel, (ylabel, xlabel, xscale)) in zip(axes.flat, PANELS.items(), strict=True):
        rows = atlas[atlas["panel"] == panel]
        ok, failed = rows[rows["status"] == "ok"], rows[rows["status"] != "ok"]
        for _, of_replica in ok.groupby("replica"):
            ax.plot(
                of_replica["value"],
                of_replica["result"],
                "o-",
                color=BLACK,
                markersize=3,
                linewidth=0.8,
            )
        if len(failed):  # an empty line that is not clipped would upset the layout
            ax.plot(failed["value"], np.zeros(len(failed)), "x", color=RED, clip_on=False)
        ax.set(
            xlabel=xlabel,
            ylabel=ylabel,
            xscale=xscale,
            ylim=(0, 1.08 * ok["result"].max() if len(ok) else 1),
        )
    return figure
