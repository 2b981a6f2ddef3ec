"""Studies of the tracker: ablation, what seeds resolve, where it fails."""

import numpy as np

from evaluation.lib.figures.style import BLACK, COLOURS, NAMES, RED, name_of, new_figure, new_panel

# Axes of the panels of the atlas.
PANELS = {
    "loss": {
        "ylabel": "loss after a short training",
        "xlabel": "learning rate",
        "xscale": "log",
    },
    "brightness": {
        "ylabel": "ODS of fuse",
        "xlabel": "shift [grey levels]",
    },
    "rows cut": {
        "ylabel": "ODS of fuse",
        "xlabel": "rows above a multiple of 16 less",
    },
    "layers": {
        "ylabel": "ODS of fuse",
        "xlabel": "level layers below the surface",
    },
}


def tracker_ablation(ablation):
    """Difference of every setting to the default of its training set."""
    figure, ax = new_panel(width=6, height=4)
    rows = ablation.query("metric == 'ods' and setting != 'default'").iloc[::-1]
    labels = [f"{name_of(row.setting)}, {NAMES[row.training_set]}" for row in rows.itertuples()]
    plot_intervals(ax, rows, labels)
    ax.set_xlabel("ODS less that of the default")
    return figure


def tracker_worth(worth):
    """Score of a set less that of another with 95 % interval; grey: the least detectable one."""
    figure, axes = new_figure(1, 2, width=9, height=4, sharey=True)
    for ax, metric in zip(axes.flat, ("ods", "ap"), strict=True):
        rows = worth.query("metric == @metric").iloc[::-1]
        for y, detectable in enumerate(rows["detectable"]):
            ax.barh(y, 2 * detectable, left=-detectable, height=0.6, color="0.9")
        labels = []
        for row in rows.itertuples():
            run = name_of_run(row.training_set, row.setting)
            base = name_of_run(row.base_training_set, row.base)
            labels.append(f"{run} less {base}")
        plot_intervals(ax, rows, labels)
        ax.set_xlabel(f"difference of {NAMES[metric]}")
    return figure


def name_of_run(training_set, setting):
    """Name of a training set, and of its setting where this is not the default."""
    name = NAMES[training_set]
    return name if setting == "default" else f"{name}, {name_of(setting)}"


def plot_intervals(ax, rows, labels):
    """Differences with their intervals, a row each, coloured by training set."""
    for y, row in enumerate(rows.itertuples()):
        ax.hlines(y, row.low, row.high, color=COLOURS[row.training_set])
        ax.plot(row.difference, y, "o", color=COLOURS[row.training_set], markersize=4)
    ax.axvline(0, color="0.5", linewidth=0.8)
    ax.set_yticks(range(len(rows)), labels)
    ax.tick_params("y", labelsize=7)


def atlas_tracker(atlas):
    """Where the tracker fails; crosses at the lower border: diverged or refused."""
    figure, axes = new_figure(2, 2, width=8, height=5.5)
    for ax, (panel, labels) in zip(axes.flat, PANELS.items(), strict=True):
        rows = atlas[atlas["panel"] == panel]
        succeeded = rows.query("status == 'ok'")
        for _, of_replica in succeeded.groupby("replica"):
            ax.plot("value", "result", "o-", data=of_replica, color=BLACK, linewidth=0.8)
        failed = rows.query("status != 'ok'")
        if len(failed):  # an empty line that is not clipped would upset the layout
            zeros = np.zeros(len(failed))
            ax.plot(failed["value"], zeros, "x", color=RED, markersize=6, clip_on=False)
        ax.set(ylim=(0, 1.08 * succeeded["result"].max() if len(succeeded) else 1), **labels)
    return figure
