"""PHY's charts: speed against accuracy, growth, what plans leave out, and the stability atlas."""

import numpy as np

# Okabe & Ito (2008), and two greys.
COLOURS = {
    "looks": "#000000",
    "literal": "#000000",
    "convolved": "#000000",
    "sampled": "#000000",
    "exact": "#009E73",
    "gamma": "#009E73",
    "closed form": "#009E73",
    "PHY exact": "#009E73",
    "PHY": "#0072B2",
    "table": "#0072B2",
    "planned": "#0072B2",
    "quantile": "#0072B2",
    "quantile, correlated": "#E69F00",
    "render": "#56B4E9",
    "gamma, moving": "#56B4E9",
    "looks, moving": "#999999",
    "closed form in support": "#999999",
    "cube": "#CC79A7",
    "recursive float32": "#D55E00",
    "recursive32": "#D55E00",
    "recursive float64": "#882255",
    "recursive64": "#882255",
    "naive": "#CC79A7",
    "naive closed form": "#CC79A7",
    "cube_open": "#D55E00",
    "scatterers": "#D55E00",
    "wrapped": "#999999",
    "cut": "#E69F00",
    "nearest": "#56B4E9",
    "table32": "#F0E442",
    "cGAN": "#CC79A7",
    "nature run": "#999999",
}
ATLAS_NAMES = {
    "exact": "mean_power exact",
    "planned": "mean_power with a tolerance",
    "render": "render",
    "looks": "speckle looks",
    "gamma": "speckle gamma",
    "cube": "speckle cube",
    "quantile": "speckle quantile",
    "naive": "closed form as usually written",
    "sampled": "sampled convolution (FFT)",
    "wrapped": "FFT without padding",
    "cut": "support cut at -5 s.d., +150 bins",
    "nearest": "table, nearest of 16 per bin",
    "recursive32": "recursive filter, float32",
    "recursive64": "recursive filter, float64",
    "table32": "table forced into float32",
    "cube_open": "cube below 10 looks",
}
PUBLIC = ("exact", "planned", "render", "looks", "gamma", "cube", "quantile")
FLOOR = "float32 normal"
LEAST_ERROR, MOST_ERROR_DB = 1e-14, 1e2  # of the atlas; beyond, drawn at the border
ROUNDING = 1e-9  # errors below are drawn as none
NEAR_DECADES = (0.45, 0.4)  # points nearer than these in error and cost share a label
# Where sweeps across zero turn linear, and ticks where matplotlib would write too many.
LINEAR_FROM = {"position [bins]": 10.0, "spacing of two layers [bins]": 1e-16}
TICKS = {
    "spacing of two layers [bins]": (-10, -1e-6, 0, 1e-12, 1e-6, 1),
    "power of the weaker layer": (1e-300, 1e-200, 1e-100, 1),
}


def fastest(runs, by):
    """Least nanoseconds per pixel of every group: other jobs only ever add; and the group's first other values."""
    runs = runs.assign(ns=runs["seconds"] / runs["n_pixels"] * 1e9)
    others = {name: "first" for name in runs.columns if name not in (*by, "ns", "repeat", "seconds")}
    return runs.groupby(list(by), sort=False, dropna=False).agg({"ns": "min", **others}).reset_index()


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


def plot_speed_accuracy(ax, runs, column="error_db", xlabel="largest error of mean power plus noise [dB]"):
    """Nanoseconds per pixel against error, fastest runs; the Pareto front, and the floor of one float32 normal.

    Points without an error in `column` are drawn at the right border as lines: they are no approximations.
    """
    points = fastest(runs, ("setting", "method"))
    floor = points[points["method"] == FLOOR]
    points = points[points["method"] != FLOOR]
    known = points[np.isfinite(points[column])]
    inexact = known[column] > ROUNDING
    least = known.loc[inexact, column].min()
    shown = known.assign(x=np.where(inexact, known[column], least / 10))
    for method, rows in shown.groupby("method", sort=False):
        ax.plot(rows["x"], rows["ns"], "o", color=COLOURS[method], markersize=4, label=method, zorder=3)
    _annotate(ax, shown)
    front = shown[pareto_front(known[column].where(inexact, 0), known["ns"])].sort_values("x")
    ax.plot(front["x"], front["ns"], drawstyle="steps-post", color="0.6", linewidth=1, label="Pareto front")
    for row in points[~np.isfinite(points[column])].itertuples():
        ax.axhline(
            row.ns, color=COLOURS[row.method], linestyle="--", linewidth=1, label=f"{row.method} (another model)"
        )
    if len(floor):
        ax.axhline(floor["ns"].min(), color="black", linestyle=":", linewidth=1, label="one float32 normal per pixel")
    ax.set(xscale="log", yscale="log", xlabel=xlabel, ylabel="ns per pixel")
    if not inexact.all():
        ax.axvspan(least / 30, least / 4, color="0.93", zorder=0)
        ax.annotate("exact", (least / 10, 0.02), xycoords=("data", "axes fraction"), fontsize=6, ha="center")
        ax.set_xlim(left=least / 30)
    ax.set_xlim(right=12 * known[column].max())
    ax.legend(fontsize=6, frameon=False, loc="upper left", bbox_to_anchor=(1.01, 1))


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
        hangs = any(abs(at[0] - x) < NEAR_DECADES[0] * 2 and 0 < at[1] - y < NEAR_DECADES[1] for at in others)
        ax.annotate(text, (10**x, 10**y), xytext=(0, -9 if hangs else 5), textcoords="offset points", fontsize=6,
                    ha="center")  # fmt: skip


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


def plot_movement(ax, runs):
    """Distance of the moment-matched Gamma from the literal sum against how much the mean moves within the looks."""
    for n_looks, rows in runs[runs["method"] == "gamma, moving"].groupby("n_looks"):
        rows = rows.drop_duplicates("movement_db").sort_values("movement_db")
        style = "-" if n_looks == runs["n_looks"].min() else "--"
        ax.plot(rows["movement_db"], rows["distance"], "o", linestyle=style, color=COLOURS["gamma, moving"],
                markersize=3, label=f"{n_looks:.0f} looks")  # fmt: skip
    ax.set(yscale="log", xlabel="change of the mean within the looks [dB]", ylabel="distance from the literal sum")
    ax.legend(fontsize=6, frameon=False)


def plot_growth(ax, runs, column, xlabel, scale="linear"):
    """Milliseconds of a scene against its pixels or its layers, fastest runs; dashed, what the plan predicts."""
    points = fastest(runs, (column, "method"))
    for method, rows in points.groupby("method", sort=False):
        rows = rows.sort_values(column)
        ms = rows["ns"] * rows["n_pixels"] / 1e6
        ax.plot(rows[column], ms, "o-", color=COLOURS[method], markersize=3, label=method)
        if rows["plan_ms"].notna().any():
            ax.plot(
                rows[column], rows["plan_ms"], "--", color=COLOURS[method], linewidth=0.8, label=f"{method}, planned"
            )
    ax.set(xlabel=xlabel, ylabel="ms per scene", xscale=scale, yscale=scale)
    ax.legend(fontsize=6, frameon=False)


def plot_plans(ax, plans, column, xlabel, reference=None):
    """Histogram of one number of all scenes' plans; its mean is marked, and a reference where there is one."""
    values = plans[column].dropna()
    ax.hist(values, bins=30, color=COLOURS["PHY"])
    ax.axvline(values.mean(), color="black", linewidth=1, label=f"mean {values.mean():.3g}")
    if reference is not None:
        ax.axvline(reference[1], color="black", linestyle=":", linewidth=1, label=f"{reference[0]} {reference[1]:.3g}")
    ax.set(xlabel=xlabel, ylabel="scenes")
    ax.legend(fontsize=6, frameon=False)


def plot_sweep(ax, rows):
    """One sweep of the atlas: error against the value swept; crosses are wrong, bars at the top refused."""
    setting = rows["setting"].iloc[0]
    rows = rows.assign(value=rows["value"].astype(float))
    for method in sorted(rows["method"].unique(), key=lambda name: name in PUBLIC):
        line = rows[rows["method"] == method].sort_values("value")
        public = method in PUBLIC
        error = line["error_db"].clip(LEAST_ERROR, MOST_ERROR_DB)
        style = {"color": COLOURS[method], "zorder": 3 if public else 2}
        ax.plot(line["value"], error, linewidth=1.6 if public else 0.7, label=ATLAS_NAMES[method], **style)
        wrong = line["outcome"] == "wrong"
        ax.plot(line["value"][wrong], error[wrong], "x", markersize=4, **style)
        refused = line["outcome"] == "refused"
        height = 3 * MOST_ERROR_DB * 4 ** (list(rows["method"].unique()).index(method) % 4)
        ax.plot(line["value"][refused], np.full(refused.sum(), height), "|", markersize=5, **style)
    limit = rows[rows["method"].isin(("planned", "gamma"))].sort_values("value")
    ax.plot(limit["value"], limit["limit_db"], color="0.5", linestyle=":", linewidth=0.9)
    positive = (rows["value"] > 0).all()
    ax.set_xscale(**({"value": "log"} if positive else {"value": "symlog", "linthresh": LINEAR_FROM[setting]}))
    ax.set_yscale("log")
    ax.set(ylim=(LEAST_ERROR / 3, 1e5), yticks=10.0 ** np.arange(-14, 3, 4))
    if setting in TICKS:
        ax.set_xticks(TICKS[setting])
        ax.set_xticks([], minor=True)
    ax.axhspan(1.5 * MOST_ERROR_DB, 1e5, color="0.93", zorder=0)
    ax.set_title(setting, fontsize=8)
    ax.tick_params(labelsize=6)


def plot_borders(ax, rows):
    """Border cases as a grid of outcomes, a row a case, a column a public function."""
    cases, methods = list(rows["value"].unique()), list(rows["method"].unique())
    marks = {"within": ("o", "#009E73"), "refused": ("_", "0.4"), "wrong": ("x", "#D55E00")}
    for outcome, (marker, colour) in marks.items():
        chosen = rows[rows["outcome"] == outcome]
        x = [methods.index(method) for method in chosen["method"]]
        y = [cases.index(case) for case in chosen["value"]]
        ax.plot(x, y, marker, color=colour, markersize=5, markeredgewidth=1.5, linestyle="none", label=outcome)
    ax.set_xticks(range(len(methods)), [ATLAS_NAMES[name].replace(" ", "\n", 1) for name in methods], fontsize=6)
    ax.set_yticks(range(len(cases)), cases, fontsize=6)
    ax.set(ylim=(len(cases) - 0.5, -0.5), xlim=(-0.5, len(methods) - 0.5))
    ax.legend(fontsize=6, frameon=False, loc="upper center", bbox_to_anchor=(0.5, -0.17), ncols=3)
    ax.set_title("borders of what may be given", fontsize=8)


def plot_atlas(figure, axes, atlas):
    """All sweeps on the axes of a figure, border cases on the last, one legend for all."""
    sweeps = [(name, rows) for name, rows in atlas.groupby("setting", sort=False) if name != "borders"]
    for ax, (_, rows) in zip(axes.flat, sweeps, strict=False):
        plot_sweep(ax, rows)
    for ax in axes[:, 0]:
        ax.set_ylabel("largest error [dB]", fontsize=7)
    plot_borders(axes.flat[-1], atlas[atlas["setting"] == "borders"])
    handles = {}
    for ax in axes.flat[: len(sweeps)]:
        handles |= {label: handle for handle, label in zip(*ax.get_legend_handles_labels(), strict=True)}
    labels = [name for name in ATLAS_NAMES.values() if name in handles]
    figure.legend(
        [handles[label] for label in labels], labels, loc="outside lower left", ncols=4, fontsize=7, frameon=False
    )
