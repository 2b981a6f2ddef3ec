"""PHY's charts: speed against accuracy, growth, and what plans leave out."""

import numpy as np

from evaluation.lib.figures.style import (
    BLACK,
    COLOURS,
    PLANTED,
    named_style,
    new_figure,
    new_panel,
    note_source,
)

FLOOR = "float32 normal"
ROUNDING = 1e-9  # errors below are drawn as none
NEAR_DECADES = (0.45, 0.4)  # points nearer than these in error and cost share a label


def speed_accuracy_waveforms(speed_accuracy_waveforms):
    """Every way of computing mean power."""
    figure, ax = new_panel(width=7, height=3.6)
    plot_speed_accuracy(ax, speed_accuracy_waveforms)
    return note_source(figure, PLANTED)


def speed_accuracy_speckle(speed_accuracy_speckle):
    """Every speckle method, and the Gamma law where the mean moves within the looks."""
    runs = speed_accuracy_speckle
    figure, axes = new_figure(1, 2, width=9, height=3.4, width_ratios=(3, 2))
    of_methods, of_movement = axes[0]
    xlabel = "distance of distribution functions from the sum of looks"
    plot_speed_accuracy(of_methods, runs.dropna(subset="seconds"), "distance", xlabel)
    method = "gamma, moving"
    for n_looks, rows in runs.query("method == @method").groupby("n_looks"):
        rows = rows.drop_duplicates("movement_db").sort_values("movement_db")
        marks = "o-" if n_looks == runs["n_looks"].min() else "o--"
        style = {"color": COLOURS[method], "label": f"{n_looks:.0f} looks"}
        of_movement.plot("movement_db", "distance", marks, data=rows, **style)
    of_movement.set_yscale("log")
    of_movement.set_xlabel("change of the mean within the looks [dB]")
    of_movement.set_ylabel("distance from the sum of looks")
    of_movement.legend()
    return note_source(figure, PLANTED)


def speed_accuracy_scenes(speed_accuracy_scenes):
    """Whole scenes."""
    return speed_accuracy_waveforms(speed_accuracy_scenes)


def speed_accuracy_growth(speed_accuracy_growth):
    """Time of a scene against its pixels and against its layers."""
    figure, axes = new_figure(1, 2, width=7)
    of_pixels, of_layers = axes[0]
    plot_growth(of_pixels, speed_accuracy_growth.query("setting == 'pixels'"), "n_pixels")
    of_pixels.set(xlabel="pixels of a scene of 15 layers", xscale="log", yscale="log")
    plot_growth(of_layers, speed_accuracy_growth.query("setting == 'layers'"), "n_layers")
    of_layers.set_xlabel("layers of a scene of 1024 x 256 pixels")
    return note_source(figure, PLANTED)


def phy_plan(plans):
    """Three numbers of all scenes' plans as histograms, their means marked."""
    figure, axes = new_figure(1, 3, width=8, height=2.6)
    labels = {
        "plan_share": "share of pixels times layers computed",
        "plan_cost_normals": "predicted cost [normals per pixel]",
        "plan_bound_db": "error bound [dB]",
    }
    for ax, (column, label) in zip(axes[0], labels.items(), strict=True):
        values = plans[column].dropna()
        ax.hist(values, bins=30, color=COLOURS["PHY"])
        mean = values.mean()
        ax.axvline(mean, color=BLACK, linewidth=1, label=f"mean {mean:.3g}")
        ax.set(xlabel=label, ylabel="scenes")
    tolerance_db = plans["plan_tolerance_db"].iloc[0]
    style = {"color": BLACK, "linestyle": ":", "linewidth": 1}
    axes[0, 2].axvline(tolerance_db, label=f"tolerance {tolerance_db:.3g}", **style)
    for ax in axes[0]:
        ax.legend()
    return figure


def fastest(runs, by):
    """Fastest run of every group, with its nanoseconds per pixel: other jobs only ever add."""
    runs = runs.assign(ns=runs["seconds"] / runs["n_pixels"] * 1e9)
    groups = runs.groupby(list(by), sort=False, dropna=False)
    return runs.loc[groups["ns"].idxmin()]


def pareto_front(error, cost):
    """Which points no other point beats in both, bool, from arrays of equal length.

    A point with NaN is never on the front.
    """
    error = np.asarray(error, dtype=float)
    front = np.zeros(error.size, dtype=bool)
    least = np.inf
    for i in np.lexsort((error, cost)):
        # By cost upwards: what errs less than all cheaper points is on the front.
        if error[i] < least:
            front[i] = True
            least = error[i]
    return front


def plot_speed_accuracy(
    ax, runs, column="error_db", xlabel="largest error of mean power plus noise [dB]"
):
    """Fastest runs against error, Pareto front and floor; lines where no error is known.

    What has no known error is no approximation, but another model.
    """
    points = fastest(runs, ("setting", "method"))
    floor = points.query("method == @FLOOR")
    points = points.query("method != @FLOOR")
    has_error = np.isfinite(points[column])
    error = points.loc[has_error, column]
    inexact = error > ROUNDING
    least = error[inexact].min()
    shown = points[has_error].assign(x=error.where(inexact, least / 10))
    for method, rows in shown.groupby("method", sort=False):
        ax.plot("x", "ns", "o", data=rows, markersize=4, zorder=3, **named_style(method))
    _annotate(ax, shown)
    front = shown[pareto_front(error.where(inexact, 0), shown["ns"])].sort_values("x")
    style = {"drawstyle": "steps-post", "color": "0.6", "linewidth": 1}
    ax.plot("x", "ns", data=front, label="Pareto front", **style)
    for row in points[~has_error].itertuples():
        style = {"color": COLOURS[row.method], "linestyle": "--", "linewidth": 1}
        ax.axhline(row.ns, label=f"{row.method} (another model)", **style)
    if len(floor):
        style = {"color": BLACK, "linestyle": ":", "linewidth": 1}
        ax.axhline(floor["ns"].min(), label="one float32 normal per pixel", **style)
    ax.set(xscale="log", yscale="log", xlabel=xlabel, ylabel="ns per pixel")
    if not inexact.all():
        ax.axvspan(least / 30, least / 4, color="0.93", zorder=0)
        foot = ("data", "axes fraction")
        ax.annotate("exact", (least / 10, 0.02), xycoords=foot, fontsize=6, ha="center")
        ax.set_xlim(left=least / 30)
    ax.set_xlim(right=12 * error.max())
    ax.legend(loc="upper left", bbox_to_anchor=(1.01, 1))


def _annotate(ax, shown):
    """Settings beside their points; those under another point hang below.

    Near points of a method share a label.
    """
    decades = np.log10(shown[["x", "ns"]].to_numpy(dtype=float))
    groups = []
    for method in shown["method"].unique():
        groups += near_points(decades, np.flatnonzero(shown["method"] == method))
    centres = [decades[rows].mean(axis=0) for rows in groups]
    for rows, centre in zip(groups, centres, strict=True):
        hangs = any(_is_just_above(other, centre) for other in centres if other is not centre)
        text = ", ".join(joined_settings(shown["setting"].iloc[rows]))
        place = {"xytext": (0, -9 if hangs else 5), "textcoords": "offset points"}
        ax.annotate(text, 10**centre, fontsize=6, ha="center", **place)


def _is_just_above(point, other):
    right, above = point - other
    return abs(right) < NEAR_DECADES[0] * 2 and 0 < above < NEAR_DECADES[1]


def near_points(decades, rows):
    """Rows of (x, y), grouped such that each lies near the one before it in x; lists of indices."""
    groups = []
    last = np.inf
    for row in rows[np.argsort(decades[rows, 0], kind="stable")]:
        if (np.abs(decades[row] - last) < NEAR_DECADES).all():
            groups[-1].append(row)
        else:
            groups.append([row])
        last = decades[row]
    return groups


def joined_settings(settings):
    """Settings in their order, a unit that all share written once.

    For example, ["0.1 dB", "0.5 dB"] gives ["0.1", "0.5 dB"].
    """
    settings = list(dict.fromkeys(settings))
    units = {setting.partition(" ")[2] for setting in settings}
    if len(units) == 1 and all(setting[:1].isdigit() for setting in settings):
        settings[:-1] = [setting.partition(" ")[0] for setting in settings[:-1]]
    return settings


def plot_growth(ax, runs, column):
    """Milliseconds of a scene against its size, fastest runs; dashed, what the plan predicts."""
    points = fastest(runs, (column, "method"))
    points["ms"] = points["ns"] * points["n_pixels"] / 1e6
    for method, rows in points.groupby("method", sort=False):
        rows = rows.sort_values(column)
        colour = COLOURS[method]
        ax.plot(column, "ms", "o-", data=rows, color=colour, label=method)
        if rows["plan_ms"].notna().any():
            style = {"color": colour, "linewidth": 0.8, "label": f"{method}, planned"}
            ax.plot(column, "plan_ms", "--", data=rows, **style)
    ax.set_ylabel("ms per scene")
    ax.legend()
