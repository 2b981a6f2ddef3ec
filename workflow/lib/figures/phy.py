"""PHY's charts: speed against accuracy of its parts and of whole scenes, growth, and what plans leave out."""

import numpy as np

from lib.figures.style import BLACK, COLOURS, PLANTED, new_figure, note_source

FLOOR = "float32 normal"
ROUNDING = 1e-9  # errors below are drawn as none
NEAR_DECADES = (0.45, 0.4)  # points nearer than these in error and cost share a label


def speed_accuracy_waveforms(speed_accuracy_waveforms):
    """Every way of computing mean power."""
    figure, axes = new_figure(width=7, height=3.6)
    plot_speed_accuracy(axes[0, 0], speed_accuracy_waveforms)
    return note_source(figure, PLANTED)


def speed_accuracy_speckle(speed_accuracy_speckle):
    """Every speckle method, and the moment-matched Gamma law where the mean moves within the looks."""
    runs = speed_accuracy_speckle
    figure, axes = new_figure(1, 2, width=9, height=3.4, width_ratios=(3, 2))
    xlabel = "distance of distribution functions from the sum of looks"
    plot_speed_accuracy(axes[0, 0], runs[runs["seconds"].notna()], "distance", xlabel)
    ax, method = axes[0, 1], "gamma, moving"
    for n_looks, rows in runs[runs["method"] == method].groupby("n_looks"):
        rows = rows.drop_duplicates("movement_db").sort_values("movement_db")
        style = {
            "linestyle": "-" if n_looks == runs["n_looks"].min() else "--",
            "color": COLOURS[method],
        }
        ax.plot(
            rows["movement_db"],
            rows["distance"],
            "o",
            markersize=3,
            label=f"{n_looks:.0f} looks",
            **style,
        )
    ax.set(
        yscale="log",
        xlabel="change of the mean within the looks [dB]",
        ylabel="distance from the sum of looks",
    )
    ax.legend(fontsize=6)
    return note_source(figure, PLANTED)


def speed_accuracy_scenes(speed_accuracy_scenes):
    """Whole scenes."""
    return speed_accuracy_waveforms(speed_accuracy_scenes)


def speed_accuracy_growth(speed_accuracy_growth):
    """Time of a scene against its pixels and against its layers."""
    runs = speed_accuracy_growth
    figure, axes = new_figure(1, 2, width=7)
    plot_growth(
        axes[0, 0],
        runs[runs["setting"] == "pixels"],
        "n_pixels",
        "pixels of a scene of 15 layers",
        "log",
    )
    plot_growth(
        axes[0, 1],
        runs[runs["setting"] == "layers"],
        "n_layers",
        "layers of a scene of 1024 x 256 pixels",
    )
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
        ax.axvline(values.mean(), color=BLACK, linewidth=1, label=f"mean {values.mean():.3g}")
        ax.set(xlabel=label, ylabel="scenes")
    tolerance_db = plans["plan_tolerance_db"].iloc[0]
    axes[0, 2].axvline(
        tolerance_db, color=BLACK, linestyle=":", linewidth=1, label=f"tolerance {tolerance_db:.3g}"
    )
    for ax in axes[0]:
        ax.legend(fontsize=6)
    return figure


def fastest(runs, by):
    """Least nanoseconds per pixel of every group: other jobs only ever add; and the group's first other values."""
    runs = runs.assign(ns=runs["seconds"] / runs["n_pixels"] * 1e9)
    others = {
        name: "first" for name in runs.columns if name not in (*by, "ns", "repeat", "seconds")
    }
    return (
        runs.groupby(list(by), sort=False, dropna=False).agg({"ns": "min", **others}).reset_index()
    )


def pareto_front(error, cost):
    """Which points no other point beats in both, bool, from arrays of equal length; a point with NaN never is."""
    error, cost = np.asarray(error, dtype=float), np.asarray(cost, dtype=float)
    front = np.zeros(error.size, dtype=bool)
    least = np.inf
    for i in np.lexsort((error, cost)):
        # By cost upwards: what errs less than all cheaper points is on the front.
        if error[i] < least:
            front[i], least = True, error[i]
    return front


def plot_speed_accuracy(
    ax, runs, column="error_db", xlabel="largest error of mean power plus noise [dB]"
):
    """Fastest runs against error, Pareto front and floor; lines where no error is known: they are no approximations."""
    points = fastest(runs, ("setting", "method"))
    floor = points[points["method"] == FLOOR]
    points = points[points["method"] != FLOOR]
    known = points[np.isfinite(points[column])]
    inexact = known[column] > ROUNDING
    least = known.loc[inexact, column].min()
    shown = known.assign(x=np.where(inexact, known[column], least / 10))
    for method, rows in shown.groupby("method", sort=False):
        ax.plot(
            rows["x"], rows["ns"], "o", color=COLOURS[method], markersize=4, label=method, zorder=3
        )
    _annotate(ax, shown)
    front = shown[pareto_front(known[column].where(inexact, 0), known["ns"])].sort_values("x")
    ax.plot(
        front["x"],
        front["ns"],
        drawstyle="steps-post",
        color="0.6",
        linewidth=1,
        label="Pareto front",
    )
    for row in points[~np.isfinite(points[column])].itertuples():
        label = f"{row.method} (another model)"
        ax.axhline(row.ns, color=COLOURS[row.method], linestyle="--", linewidth=1, label=label)
    if len(floor):
        ax.axhline(
            floor["ns"].min(),
            color=BLACK,
            linestyle=":",
            linewidth=1,
            label="one float32 normal per pixel",
        )
    ax.set(xscale="log", yscale="log", xlabel=xlabel, ylabel="ns per pixel")
    if not inexact.all():
        ax.axvspan(least / 30, least / 4, color="0.93", zorder=0)
        ax.annotate(
            "exact", (least / 10, 0.02), xycoords=("data", "axes fraction"), fontsize=6, ha="center"
        )
        ax.set_xlim(left=least / 30)
    ax.set_xlim(right=12 * known[column].max())
    ax.legend(fontsize=6, loc="upper left", bbox_to_anchor=(1.01, 1))


def _annotate(ax, shown):
    """Settings beside their points; near points of a method share a label, those under another point hang below."""
    places = np.log10(shown[["x", "ns"]].to_numpy(dtype=float))
    clusters = [
        (places[rows], ", ".join(joined_settings(shown["setting"].iloc[rows])))
        for method in shown["method"].unique()
        for rows in near_points(places, np.flatnonzero(shown["method"] == method))
    ]
    for points, text in clusters:
        x, y = points.mean(axis=0)
        others = [other.mean(axis=0) for other, _ in clusters if other is not points]
        hangs = any(
            abs(at[0] - x) < NEAR_DECADES[0] * 2 and 0 < at[1] - y < NEAR_DECADES[1]
            for at in others
        )
        offset = (0, -9 if hangs else 5)
        ax.annotate(
            text, (10**x, 10**y), xytext=offset, textcoords="offset points", fontsize=6, ha="center"
        )


def near_points(places, rows):
    """Rows of (x, y) in decades, grouped such that each lies near the one before it in x; lists of indices."""
    groups = []
    for row in rows[np.argsort(places[rows, 0], kind="stable")]:
        if groups and (np.abs(places[row] - places[groups[-1][-1]]) < NEAR_DECADES).all():
            groups[-1].append(row)
        else:
            groups.append([row])
    return groups


def joined_settings(settings):
    """Settings in their order, a unit that all share written once: ["0.1 dB", "0.5 dB"] gives ["0.1", "0.5 dB"]."""
    settings = list(dict.fromkeys(settings))
    units = {setting.partition(" ")[2] for setting in settings}
    if len(units) == 1 and all(setting[:1].isdigit() for setting in settings):
        settings[:-1] = [setting.partition(" ")[0] for setting in settings[:-1]]
    return settings


def plot_growth(ax, runs, column, xlabel, scale="linear"):
    """Milliseconds of a scene against its pixels or its layers, fastest runs; dashed, what the plan predicts."""
    points = fastest(runs, (column, "method"))
    for method, rows in points.groupby("method", sort=False):
        rows, colour = rows.sort_values(column), COLOURS[method]
        ax.plot(
            rows[column],
            rows["ns"] * rows["n_pixels"] / 1e6,
            "o-",
            color=colour,
            markersize=3,
            label=method,
        )
        if rows["plan_ms"].notna().any():
            ax.plot(
                rows[column],
                rows["plan_ms"],
                "--",
                color=colour,
                linewidth=0.8,
                label=f"{method}, planned",
            )
    ax.set(xlabel=xlabel, ylabel="ms per scene", xscale=scale, yscale=scale)
    ax.legend(fontsize=6)
