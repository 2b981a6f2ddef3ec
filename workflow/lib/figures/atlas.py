"""Atlases of PHY and of the estimators: error against what makes it hard, and limits of valid input."""

import numpy as np

from lib.figures.style import COLOURS, GREEN, ORANGE, PLANTED, RED, new_figure, note_source

PUBLIC = ("exact", "planned", "render", "looks", "gamma", "cube", "quantile")
METHOD_NAMES = {
    "exact": "mean_power exact",
    "planned": "mean_power with a tolerance",
    "render": "render",
}
METHOD_NAMES |= {name: f"speckle {name}" for name in ("looks", "gamma", "cube", "quantile")}
METHOD_NAMES |= {"naive": "closed form as usually written", "sampled": "sampled convolution (FFT)"}
METHOD_NAMES |= {"wrapped": "FFT without padding", "cut": "support cut at -5 s.d., +150 bins"}
METHOD_NAMES |= {
    "nearest": "table, nearest of 16 per bin",
    "recursive32": "recursive filter, float32",
}
METHOD_NAMES |= {"recursive64": "recursive filter, float64", "table32": "table forced into float32"}
METHOD_NAMES |= {"cube_open": "cube below 10 looks"}
LEAST_ERROR, MOST_ERROR_DB = 1e-14, 1e2  # of PHY's atlas; beyond, drawn at the border
# Where sweeps across zero turn linear, and ticks where matplotlib would write too many.
LINEAR_FROM = {"position [bins]": 10.0, "spacing of two layers [bins]": 1e-16}
TICKS = {
    "spacing of two layers [bins]": (-10, -1e-6, 0, 1e-12, 1e-6, 1),
    "power of the weaker layer": (1e-300, 1e-200, 1e-100, 1),
}
QUANTITIES = {
    "peak_power": "peak power [%]",
    "decay_rate": "decay rate [%]",
    "width_bins": "1/e width [bins]",
}
MOST_BOUNDS = 300  # errors of estimators beyond so many bounds are drawn there
LOGARITHMIC = ("slab thickness [bins]", "looks of a range line", "range lines of a flight")
# Marks of outcomes, in the order of how bad they are.
OUTCOMES = {"within": ("o", GREEN), "beyond": ("o", ORANGE), "refused": ("_", "0.4")}
OUTCOMES |= dict.fromkeys(("wrong", "not finite"), ("x", RED))


def atlas_phy(atlas_phy):
    """PHY: all sweeps on axes of their own, border cases on the last, one legend for all."""
    figure, axes = new_figure(3, 3, width=10, height=9)
    sweeps = [
        (name, rows) for name, rows in atlas_phy.groupby("setting", sort=False) if name != "borders"
    ]
    handles = {}
    for ax, (setting, rows) in zip(axes.flat, sweeps, strict=False):
        plot_methods(ax, setting, rows)
        handles |= {
            label: handle for handle, label in zip(*ax.get_legend_handles_labels(), strict=True)
        }
    for ax in axes[:, 0]:
        ax.set_ylabel("largest error [dB]", fontsize=7)
    # Limits of valid input as a grid of outcomes, a row a case, a column a public function.
    ax, rows = axes.flat[-1], atlas_phy[atlas_phy["setting"] == "borders"]
    cases, methods = list(rows["value"].unique()), list(rows["method"].unique())
    for outcome in ("within", "refused", "wrong"):
        chosen, (marker, colour) = rows[rows["outcome"] == outcome], OUTCOMES[outcome]
        x = [methods.index(method) for method in chosen["method"]]
        y = [cases.index(case) for case in chosen["value"]]
        ax.plot(
            x,
            y,
            marker,
            color=colour,
            markersize=5,
            markeredgewidth=1.5,
            linestyle="none",
            label=outcome,
        )
    ax.set_xticks(
        range(len(methods)),
        [METHOD_NAMES[name].replace(" ", "\n", 1) for name in methods],
        fontsize=6,
    )
    ax.set_yticks(range(len(cases)), cases, fontsize=6)
    ax.set(ylim=(len(cases) - 0.5, -0.5), xlim=(-0.5, len(methods) - 0.5))
    ax.legend(fontsize=6, loc="upper center", bbox_to_anchor=(0.5, -0.17), ncols=3)
    ax.set_title("limits of valid input", fontsize=8)
    labels = [name for name in METHOD_NAMES.values() if name in handles]
    figure.legend(
        [handles[label] for label in labels], labels, loc="outside lower left", ncols=4, fontsize=7
    )
    return note_source(figure, PLANTED)


def plot_methods(ax, setting, rows):
    """One sweep of PHY's atlas: error against the value swept; crosses are wrong, bars at the top refused."""
    rows = rows.assign(value=rows["value"].astype(float))
    methods = list(rows["method"].unique())
    for method in sorted(methods, key=lambda name: name in PUBLIC):
        line = rows[rows["method"] == method].sort_values("value")
        public = method in PUBLIC
        error = line["error_db"].clip(LEAST_ERROR, MOST_ERROR_DB)
        style = {"color": COLOURS[method], "zorder": 3 if public else 2}
        ax.plot(
            line["value"],
            error,
            linewidth=1.6 if public else 0.7,
            label=METHOD_NAMES[method],
            **style,
        )
        wrong, refused = line["outcome"] == "wrong", line["outcome"] == "refused"
        ax.plot(line["value"][wrong], error[wrong], "x", markersize=4, **style)
        height = 3 * MOST_ERROR_DB * 4 ** (methods.index(method) % 4)
        ax.plot(line["value"][refused], np.full(refused.sum(), height), "|", markersize=5, **style)
    limit = rows[rows["method"].isin(("planned", "gamma"))].sort_values("value")
    ax.plot(limit["value"], limit["limit_db"], color="0.5", linestyle=":", linewidth=0.9)
    positive = (rows["value"] > 0).all()
    ax.set_xscale(
        **({"value": "log"} if positive else {"value": "symlog", "linthresh": LINEAR_FROM[setting]})
    )
    ax.set_yscale("log")
    ax.set(ylim=(LEAST_ERROR / 3, 1e5), yticks=10.0 ** np.arange(-14, 3, 4))
    if setting in TICKS:
        ax.set_xticks(TICKS[setting])
        ax.set_xticks([], minor=True)
    ax.axhspan(1.5 * MOST_ERROR_DB, 1e5, color="0.93", zorder=0)
    ax.set_title(setting, fontsize=8)
    ax.tick_params(labelsize=6)


def atlas_statistics(atlas_statistics):
    """Estimators: all sweeps as columns, quantities as rows."""
    figure, axes = new_figure(3, 5, width=12, height=6.5)
    panels = [panel for panel in atlas_statistics["panel"].unique() if panel != "borders"]
    for row, (quantity, label) in zip(axes, QUANTITIES.items(), strict=True):
        for ax, panel in zip(row, panels, strict=False):
            plot_estimators(ax, atlas_statistics, panel, quantity)
        row[0].set_ylabel(f"error of {label}", fontsize=8)
    for ax, panel in zip(axes[-1], panels, strict=False):
        ax.set_xlabel(panel, fontsize=8)
    axes[0, 0].legend(fontsize=6)
    return note_source(figure, PLANTED)


def plot_estimators(ax, atlas, panel, quantity):
    """Mean error over layers of one quantity along a sweep, two claimed standard errors, and the bound in grey."""
    rows = atlas[(atlas["panel"] == panel) & atlas["quantity"].isin((quantity, "all"))]
    scale = 1 if quantity == "width_bins" else 100
    bound = scale * atlas.loc[atlas["quantity"] == quantity, "bound"].iloc[0]
    limit = MOST_BOUNDS * bound
    ax.axhspan(-bound, bound, color="0.9", zorder=0)
    for estimator, part in rows.groupby("estimator", sort=False):
        part = part.assign(value=part["value"].astype(float)).sort_values("value")
        colour = COLOURS[estimator]
        held = part[part["outcome"] != "refused"]
        error, reach = scale * held["error"], 2 * scale * held["standard_error"]
        low, high = np.maximum(error - reach, -limit), np.minimum(error + reach, limit)
        ax.vlines(held["value"], low, high, color=colour, alpha=0.4, linewidth=2)
        ax.plot(
            held["value"],
            error.clip(-limit, limit),
            "o-",
            color=colour,
            markersize=3,
            label=estimator,
        )
        refused = part.loc[part["outcome"] == "refused", "value"]
        ax.plot(refused, np.full(len(refused), limit), "x", color=colour, markersize=4)
    ax.set_yscale("symlog", linthresh=bound)
    ax.set_ylim(-1.5 * limit, 1.5 * limit)
    ticks = bound * np.array([-100, -10, -1, 0, 1, 10, 100])
    ax.set_yticks(ticks, [f"{tick:g}" for tick in ticks], fontsize=6)
    ax.set_yticks([], minor=True)
    values = sorted(rows["value"].astype(float).unique())
    if panel in LOGARITHMIC:
        ax.set_xscale("log")
    ax.set_xticks(values, [f"{value:g}" for value in values], fontsize=6)
    ax.set_xticks([], minor=True)


def atlas_statistics_borders(atlas_statistics):
    """Border cases: the worst outcome of each estimator as a mark, and the rule or the refusal in words."""
    rows = atlas_statistics[atlas_statistics["panel"] == "borders"]
    cases, estimators = list(rows["value"].unique()), ("deblended", "paper")
    order = ("within", "beyond", "refused", "not finite")
    figure, axes = new_figure(1, 1, width=8, height=4.5)
    ax = axes[0, 0]
    for j, estimator in enumerate(estimators):
        for i, case in enumerate(cases):
            held = rows[(rows["value"] == case) & (rows["estimator"] == estimator)]
            marker, colour = OUTCOMES[max(held["outcome"], key=order.index)]
            ax.plot(j, i, marker, color=colour, markersize=6, markeredgewidth=1.5)
            if j == 0:
                ax.text(1.6, i, held["note"].fillna("").iloc[0], fontsize=5.5, va="center")
    for outcome in order:
        marker, colour = OUTCOMES[outcome]
        ax.plot([], [], marker, color=colour, linestyle="none", label=outcome)
    ax.set_xticks(range(len(estimators)), estimators, fontsize=7, rotation=30, ha="right")
    ax.set_yticks(range(len(cases)), cases, fontsize=7)
    ax.set(xlim=(-0.5, 12), ylim=(len(cases) - 0.5, -0.5))
    ax.legend(fontsize=6, loc="upper center", bbox_to_anchor=(0.4, 1.08), ncols=4)
    return note_source(figure, PLANTED)
