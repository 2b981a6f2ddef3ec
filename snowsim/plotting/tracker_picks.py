"""Picks and side outputs of the trackers: errors by training set, by zone and against depth; sheets of maps."""

import numpy as np

from snowsim.plotting.style import COLOURS, NAMES

TITLES = {"side_1": "side 1", "side_2": "side 2", "side_3": "side 3", "side_4": "side 4", "side_5": "side 5"}


def plot_pick_errors(ax, table, column, label):
    """One column of the table of picks: a point a replica, a bar for their mean, by training set."""
    for x, (training_set, rows) in enumerate(table.groupby("training_set", sort=False)):
        colour = COLOURS[training_set]
        ax.bar(x, rows[column].mean(), color=colour, alpha=0.35, width=0.6)
        ax.plot(np.full(len(rows), x), rows[column], "o", color=colour, markersize=4)
    names = table["training_set"].unique()
    ax.set_xticks(range(len(names)), [NAMES[name] for name in names], rotation=30, ha="right")
    ax.set_ylabel(label)


def plot_picks_by_depth(ax, table, column, label):
    """One column of the table of picks against depth, mean over replicas, a line a training set."""
    for training_set, rows in table.groupby("training_set", sort=False):
        mean = rows.groupby("depth_from_bins")[column].mean()
        ax.step(mean.index, mean, where="post", color=COLOURS[training_set], label=NAMES[training_set])
    ax.set(xlabel="depth below the surface [range bins]", ylabel=label)
    ax.legend(fontsize=7)


def plot_zone_differences(ax, table, metric):
    """Difference of a fused edge score to RD by accumulation zone, with 95 % intervals."""
    rows = table[(table["metric"] == metric) & (table["training_set"] != "rd")]
    zones = list(dict.fromkeys(rows["zone"]))
    names = list(dict.fromkeys(rows["training_set"]))
    for shift, training_set in zip(np.linspace(-0.2, 0.2, len(names)), names, strict=True):
        of_set = rows[rows["training_set"] == training_set].set_index("zone").loc[zones]
        x = np.arange(len(zones)) + shift
        ax.vlines(x, of_set["difference_low"], of_set["difference_high"], color=COLOURS[training_set])
        ax.plot(x, of_set["difference"], "o", color=COLOURS[training_set], markersize=4, label=NAMES[training_set])
    ax.axhline(0, color="0.5", linewidth=0.8)
    sizes = rows.drop_duplicates("zone").set_index("zone")["n_images"]
    ax.set_xticks(range(len(zones)), [f"{zone}\n{sizes[zone]} scenes" for zone in zones])
    ax.set_ylabel(f"{NAMES[metric]} of fuse less that of RD")
    ax.legend(fontsize=7)


def plot_side_outputs(axes, samples, scene, training_set):
    """A row of panels: the image with its layers, then every output of one training set on it."""
    here = samples.sel(scene=scene)
    axes[0].imshow(here["image"], cmap="gray", vmin=0, vmax=255, aspect="auto", interpolation="nearest")
    rows, lines = np.nonzero(here["mask"].values)
    axes[0].plot(lines, rows, ",", color=COLOURS["rd_gd"])
    axes[0].set_ylabel(f"{NAMES[training_set]}\n{scene}", fontsize=7)
    for ax, output in zip(axes[1:], samples["output"].values, strict=True):
        probability = here["probability"].sel(training_set=training_set, output=output)
        ax.imshow(probability, cmap="gray_r", vmin=0, vmax=255, aspect="auto", interpolation="nearest")
        ax.set_title(TITLES.get(output, output), fontsize=7)
    for ax in axes:
        ax.set(xticks=[], yticks=[])
