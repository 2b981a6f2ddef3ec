"""Edge scores and training of the trackers.

Picks and side outputs of the trackers: errors by training set, by zone and against depth; sheets of maps.
Studies of the tracker: ablation, what seeds resolve, cost against score, where it fails.
"""

import numpy as np

from lib.figures.style import COLOURS, NAMES


def plot_precision_recall(ax, curves):
    """Precision against recall of the fused output, a line a training set, mean over replicas."""
    for training_set, rows in curves.groupby("training_set", sort=False):
        ax.plot(rows["recall"], rows["precision"], color=COLOURS[training_set], label=NAMES[training_set])
    ax.set(xlabel="recall", ylabel="precision", xlim=(0, 1), ylim=(0, 1))
    ax.legend(loc="lower left")


def plot_scores(ax, intervals, metric):
    """One edge score of the fused output, a point with its 95 % interval a training set."""
    rows = intervals[(intervals["output"] == "fuse") & (intervals["metric"] == metric)]
    for x, row in enumerate(rows.itertuples()):
        ax.plot([x, x], [row.low, row.high], color=COLOURS[row.training_set])
        ax.plot(x, row.mean, "o", color=COLOURS[row.training_set])
    ax.set_xticks(range(len(rows)), [NAMES[name] for name in rows["training_set"]], rotation=30, ha="right")
    ax.set_ylabel(f"{NAMES[metric]} of fuse")


def plot_losses(ax, losses, columns, window=50):
    """Training losses against step as running means over `window` steps."""
    for column in columns:
        smooth = losses[column].rolling(window, min_periods=1).mean()
        ax.plot(losses["step"], smooth, linewidth=1, label=column)
    ax.set(xlabel="step", ylabel="loss")


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


def plot_ablation(ax, table, metric="ods"):
    """Difference of every setting to the default of its training set, with 95 % intervals, a row each."""
    rows = table[(table["metric"] == metric) & (table["setting"] != "default")].iloc[::-1]
    for y, row in enumerate(rows.itertuples()):
        colour = COLOURS[row.training_set]
        ax.hlines(y, row.low, row.high, color=colour)
        ax.plot(row.difference, y, "o", color=colour, markersize=4)
    ax.axvline(0, color="0.5", linewidth=0.8)
    labels = [f"{row.setting.replace('_', ' ')}, {NAMES[row.training_set]}" for row in rows.itertuples()]
    ax.set_yticks(range(len(rows)), labels, fontsize=7)
    ax.set_xlabel(f"{NAMES[metric]} less that of the default")


def plot_chosen(ax, table, metric="ods"):
    """Score of the default and of the chosen setting on the test scenes, a pair a training set."""
    rows = table[table["metric"] == metric]
    sets = list(dict.fromkeys(rows["training_set"]))
    for row in rows.itertuples():
        is_default = row.setting == "default"
        x = sets.index(row.training_set) + (-0.12 if is_default else 0.12)
        face = "white" if is_default else COLOURS[row.training_set]
        ax.plot(x, row.mean, "o", color=COLOURS[row.training_set], markerfacecolor=face)
        if not is_default:
            ax.annotate(row.setting.replace("_", " "), (x, row.mean), (4, 4), textcoords="offset points", fontsize=6)
    ax.set_xticks(range(len(sets)), [NAMES[name] for name in sets], rotation=30, ha="right")
    ax.set_ylabel(f"{NAMES[metric]} on test scenes")


def plot_seeds(ax, table, metric):
    """Difference of every pair of training sets with its 95 % interval; grey: what could have been told from none."""
    rows = table[table["metric"] == metric].iloc[::-1]
    for y, row in enumerate(rows.itertuples()):
        ax.barh(y, 2 * row.detectable, left=-row.detectable, height=0.6, color="0.9")
        ax.hlines(y, row.low, row.high, color=COLOURS[row.training_set])
        ax.plot(row.difference, y, "o", color=COLOURS[row.training_set], markersize=4)
    ax.axvline(0, color="0.5", linewidth=0.8)
    ax.set_yticks(range(len(rows)), [f"{NAMES[r.training_set]} - {NAMES[r.base]}" for r in rows.itertuples()])
    ax.set_xlabel(f"difference of {NAMES[metric]}")


def plot_speed(ax, table):
    """Fused ODS against the seconds per image of the fastest round, a point a network."""
    for name, rows in table.groupby("setting", sort=False):
        row = rows.loc[rows["seconds"].idxmin()]
        light = row["network"] != "multi_scale"
        ax.plot(row["seconds"], row["ods"], "s" if light else "o", color=COLOURS["rd_gd" if light else "rd"])
        label = f"width {row['width']}" + (f", {row['network']}" if light else "")
        ax.annotate(label, (row["seconds"], row["ods"]), (5, 3), textcoords="offset points", fontsize=7, gid=name)
    ax.set(xscale="log", xlabel="seconds per image", ylabel="ODS of fuse, validation scenes")


def plot_panel(ax, table, panel, xlabel, ylabel, xscale="linear"):
    """One panel of the stability table; crosses at the lower border: diverged or refused."""
    rows = table[table["panel"] == panel]
    ok = rows[rows["status"] == "ok"]
    for _, of_replica in ok.groupby("replica"):
        ax.plot(of_replica["value"], of_replica["result"], "o-", color=COLOURS["rd"], markersize=3, linewidth=0.8)
    failed = rows[rows["status"] != "ok"]
    if len(failed):  # an empty line that is not clipped would upset the layout
        ax.plot(failed["value"], np.zeros(len(failed)), "x", color=COLOURS["cgan"], clip_on=False)
    ax.set(xlabel=xlabel, ylabel=ylabel, xscale=xscale, ylim=(0, 1.08 * ok["result"].max() if len(ok) else 1))
