"""The trackers: edge scores, training, errors of picks, and what every output shows."""

from itertools import product

import numpy as np

from evaluation.lib.figures.style import (
    COLOURS,
    NAMES,
    RED,
    RUNNING_STEPS,
    TRAINING_SETS,
    name_columns,
    name_of,
    named_style,
    new_figure,
    new_panel,
)

PICK_ERRORS = {
    "mean_absolute_error_bins": "mean absolute error [range bins]",
    "thickness_mean_absolute_error_m": "error of annual thickness [m]",
    "share_within": "share of errors within 2 bins",
    "n_missed_layers": "missed layers",
    "n_false_layers": "false layers",
}


def precision_recall(precision_recall):
    """Precision against recall of the fused output, a line a training set, mean over replicas."""
    figure, ax = new_panel(width=4, height=3.5)
    for training_set, rows in precision_recall.groupby("training_set", sort=False):
        ax.plot("recall", "precision", data=rows, **named_style(training_set))
    ax.set(xlabel="recall", ylabel="precision", xlim=(0, 1), ylim=(0, 1))
    ax.legend(loc="lower left", fontsize=8)
    return figure


def table3(table3_intervals):
    """Edge scores of the fused output, a point with its 95 % interval a training set."""
    figure, axes = new_figure(1, 3, width=7.5)
    for ax, metric in zip(axes.flat, ("ods", "ois", "ap"), strict=True):
        rows = table3_intervals.query("output == 'fuse' and metric == @metric")
        for x, row in enumerate(rows.itertuples()):
            colour = COLOURS[row.training_set]
            ax.plot([x, x], [row.low, row.high], color=colour)
            ax.plot(x, row.mean, "o", color=colour, markersize=6)
        name_columns(ax, rows["training_set"])
        ax.set_ylabel(f"{NAMES[metric]} of fuse")
    return figure


def tracker_losses(losses):
    """Training loss of the first replica of every set as running means."""
    figure, ax = new_panel()
    for training_set, table in zip(TRAINING_SETS, losses, strict=True):
        smooth = table["total"].rolling(RUNNING_STEPS, min_periods=1).mean()
        ax.plot(table["step"], smooth, linewidth=1, **named_style(training_set))
    ax.set(xlabel="step", ylabel="loss")
    ax.legend(fontsize=8)
    return figure


def picks(picks, picks_by_depth):
    """Errors of picks, a point a replica, a bar for their mean; share picked against depth."""
    figure, axes = new_figure(2, 3, width=10, height=5.5)
    *of_errors, of_depth = axes.flat
    for ax, (column, label) in zip(of_errors, PICK_ERRORS.items(), strict=True):
        for x, (training_set, rows) in enumerate(picks.groupby("training_set", sort=False)):
            colour = COLOURS[training_set]
            errors = rows[column]
            ax.bar(x, errors.mean(), color=colour, alpha=0.35, width=0.6)
            ax.plot(np.full(len(rows), x), errors, "o", color=colour, markersize=4)
        name_columns(ax, picks["training_set"].unique())
        ax.set_ylabel(label)
    for training_set, rows in picks_by_depth.groupby("training_set", sort=False):
        mean = rows.groupby("depth_from_bins")["share_found"].mean()
        of_depth.step(mean.index, mean, where="post", **named_style(training_set))
    of_depth.set_xlabel("depth below the surface [range bins]")
    of_depth.set_ylabel("share of layer pixels picked")
    of_depth.legend(fontsize=7)
    return figure


def table3_zones(table3_zones):
    """Difference of the fused scores to those of RD by accumulation zone, with 95 % intervals."""
    figure, axes = new_figure(1, 2, width=9, height=3)
    for ax, metric in zip(axes.flat, ("ods", "ap"), strict=True):
        rows = table3_zones.query("metric == @metric and training_set != 'rd'")
        sizes = rows.drop_duplicates("zone").set_index("zone")["n_images"]
        sets = rows["training_set"].unique()
        for shift, training_set in zip(np.linspace(-0.2, 0.2, len(sets)), sets, strict=True):
            of_set = rows.query("training_set == @training_set").set_index("zone").loc[sizes.index]
            x = np.arange(len(sizes)) + shift
            colour = COLOURS[training_set]
            ax.vlines(x, of_set["difference_low"], of_set["difference_high"], color=colour)
            ax.plot(x, of_set["difference"], "o", markersize=4, **named_style(training_set))
        ax.axhline(0, color="0.5", linewidth=0.8)
        labels = [f"{zone}\n{size} scenes" for zone, size in sizes.items()]
        ax.set_xticks(range(len(sizes)), labels)
        ax.set_ylabel(f"{NAMES[metric]} of fuse less that of RD")
        ax.legend(fontsize=7)
    return figure


def side_outputs(samples):
    """The image with its layers, then every output on it, a row a scene and a training set."""
    sheets = list(product(samples["scene"].values, samples["training_set"].values))
    figure, axes = new_figure(len(sheets), 7, width=9, height=1.2 * len(sheets))
    style = {"vmin": 0, "vmax": 255, "interpolation": "nearest"}
    for row, (scene, training_set) in zip(axes, sheets, strict=True):
        here = samples.sel(scene=scene, training_set=training_set)
        of_image, *of_outputs = row
        of_image.imshow(here["image"], **style)
        rows, lines = np.nonzero(here["mask"].values)
        of_image.plot(lines, rows, ",", color=RED)
        of_image.set_ylabel(f"{NAMES[training_set]}\n{scene}", fontsize=7)
        for ax, output in zip(of_outputs, samples["output"].values, strict=True):
            ax.imshow(here["probability"].sel(output=output), cmap="gray_r", **style)
            ax.set_title(name_of(output), fontsize=7)
        for ax in row:
            ax.set(xticks=[], yticks=[])
    return figure
