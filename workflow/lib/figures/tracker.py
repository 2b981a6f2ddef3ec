"""The trackers: edge scores, training, errors of picks, and what every output shows."""

import numpy as np

from lib.figures.style import (
    COLOURS,
    NAMES,
    RED,
    RUNNING_STEPS,
    TRAINING_SETS,
    name_columns,
    name_of,
    new_figure,
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
    figure, axes = new_figure(width=4, height=3.5)
    for training_set, rows in precision_recall.groupby("training_set", sort=False):
        axes[0, 0].plot(
            rows["recall"],
            rows["precision"],
            color=COLOURS[training_set],
            label=NAMES[training_set],
        )
    axes[0, 0].set(xlabel="recall", ylabel="precision", xlim=(0, 1), ylim=(0, 1))
    axes[0, 0].legend(loc="lower left")
    return figure


def table3(table3_intervals):
    """Edge scores of the fused output, a point with its 95 % interval a training set."""
    figure, axes = new_figure(1, 3, width=7.5)
    fuse = table3_intervals[table3_intervals["output"] == "fuse"]
    for ax, metric in zip(axes.flat, ("ods", "ois", "ap"), strict=True):
        rows = fuse[fuse["metric"] == metric]
        for x, row in enumerate(rows.itertuples()):
            ax.plot([x, x], [row.low, row.high], color=COLOURS[row.training_set])
            ax.plot(x, row.mean, "o", color=COLOURS[row.training_set])
        name_columns(ax, list(rows["training_set"]))
        ax.set_ylabel(f"{NAMES[metric]} of fuse")
    return figure


def tracker_losses(losses):
    """Training loss of the first replica of every set as running means."""
    figure, axes = new_figure()
    for training_set, table in zip(TRAINING_SETS, losses, strict=True):
        smooth = table["total"].rolling(RUNNING_STEPS, min_periods=1).mean()
        axes[0, 0].plot(
            table["step"],
            smooth,
            linewidth=1,
            color=COLOURS[training_set],
            label=NAMES[training_set],
        )
    axes[0, 0].set(xlabel="step", ylabel="loss")
    axes[0, 0].legend()
    return figure


def picks(picks, picks_by_depth):
    """Errors of picks, a point a replica, a bar for their mean; share of layer pixels picked against depth."""
    figure, axes = new_figure(2, 3, width=10, height=5.5)
    for ax, (column, label) in zip(axes.flat, PICK_ERRORS.items(), strict=False):
        for x, (training_set, rows) in enumerate(picks.groupby("training_set", sort=False)):
            ax.bar(x, rows[column].mean(), color=COLOURS[training_set], alpha=0.35, width=0.6)
            ax.plot(
                np.full(len(rows), x), rows[column], "o", color=COLOURS[training_set], markersize=4
            )
        name_columns(ax, picks["training_set"].unique())
        ax.set_ylabel(label)
    ax = axes[1, 2]
    for training_set, rows in picks_by_depth.groupby("training_set", sort=False):
        mean = rows.groupby("depth_from_bins")["share_found"].mean()
        ax.step(
            mean.index, mean, where="post", color=COLOURS[training_set], label=NAMES[training_set]
        )
    ax.set(xlabel="depth below the surface [range bins]", ylabel="share of layer pixels picked")
    ax.legend(fontsize=7)
    return figure


def table3_zones(table3_zones):
    """Difference of the fused edge scores to RD by accumulation zone, with 95 % intervals."""
    figure, axes = new_figure(1, 2, width=9, height=3)
    for ax, metric in zip(axes.flat, ("ods", "ap"), strict=True):
        rows = table3_zones[
            (table3_zones["metric"] == metric) & (table3_zones["training_set"] != "rd")
        ]
        zones, sets = (list(dict.fromkeys(rows[column])) for column in ("zone", "training_set"))
        for shift, training_set in zip(np.linspace(-0.2, 0.2, len(sets)), sets, strict=True):
            of_set = rows[rows["training_set"] == training_set].set_index("zone").loc[zones]
            x, colour = np.arange(len(zones)) + shift, COLOURS[training_set]
            ax.vlines(x, of_set["difference_low"], of_set["difference_high"], color=colour)
            ax.plot(
                x, of_set["difference"], "o", color=colour, markersize=4, label=NAMES[training_set]
            )
        ax.axhline(0, color="0.5", linewidth=0.8)
        sizes = rows.drop_duplicates("zone").set_index("zone")["n_images"]
        ax.set_xticks(range(len(zones)), [f"{zone}\n{sizes[zone]} scenes" for zone in zones])
        ax.set_ylabel(f"{NAMES[metric]} of fuse less that of RD")
        ax.legend(fontsize=7)
    return figure


def side_outputs(samples):
    """The image with its layers, then every output on it, a row a scene and a training set."""
    sheet = [
        (scene, name)
        for scene in samples["scene"].values
        for name in samples["training_set"].values
    ]
    figure, axes = new_figure(len(sheet), 7, width=9, height=1.2 * len(sheet))
    for row, (scene, training_set) in zip(axes, sheet, strict=True):
        here = samples.sel(scene=scene)
        row[0].imshow(
            here["image"], cmap="gray", vmin=0, vmax=255, aspect="auto", interpolation="nearest"
        )
        rows, lines = np.nonzero(here["mask"].values)
        row[0].plot(lines, rows, ",", color=RED)
        row[0].set_ylabel(f"{NAMES[training_set]}\n{scene}", fontsize=7)
        for ax, output in zip(row[1:], samples["output"].values, strict=True):
            probability = here["probability"].sel(training_set=training_set, output=output)
            ax.imshow(
                probability, cmap="gray_r", vmin=0, vmax=255, aspect="auto", interpolation="nearest"
            )
            ax.set_title(name_of(output), fontsize=7)
        for ax in row:
            ax.set(xticks=[], yticks=[])
    return figure
