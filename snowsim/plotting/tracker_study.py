"""Studies of the tracker: ablation, what seeds resolve, cost against score, where it fails."""

import numpy as np

from snowsim.plotting.style import COLOURS, NAMES


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
