"""Atlases of PHY and of the estimators: where errors grow, and limits of valid input."""

import numpy as np

from evaluation.lib.figures.style import (
    COLOURS,
    GREEN,
    ORANGE,
    PLANTED,
    RED,
    list_downwards,
    new_figure,
    new_panel,
    note_source,
)

METHOD_NAMES = {
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
LEAST_ERROR = 1e-14  # of PHY's atlas; beyond, drawn at the border
MOST_ERROR_DB = 1e2
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
OUTCOMES = {
    "within": {"marker": "o", "color": GREEN},
    "beyond": {"marker": "o", "color": ORANGE},
    "refused": {"marker": "_", "color": "0.4"},
    "wrong": {"marker": "x", "color": RED},
    "not finite": {"marker": "x", "color": RED},
}


def atlas_phy(atlas_phy):
    """PHY: all sweeps on axes of their own, border cases on the last, one legend for all."""
    figure, axes = new_figure(3, 3, width=10, height=9)
    handles = {}
    sweeps = atlas_phy.query("setting != 'borders'").groupby("setting", sort=False)
    for ax, (setting, rows) in zip(axes.flat, sweeps, strict=False):
        plot_methods(ax, setting, rows)
        of_panel, labels = ax.get_legend_handles_labels()
        handles |= dict(zip(labels, of_panel, strict=True))
    for ax in axes[:, 0]:
        ax.set_ylabel("largest error [dB]", fontsize=7)
    plot_borders(axes[-1, -1], atlas_phy.query("setting == 'borders'"))
    labels = [name for name in METHOD_NAMES.values() if name in handles]
    handles = [handles[label] for label in labels]
    figure.legend(handles, labels, loc="outside lower left", ncols=4, fontsize=7)
    return note_source(figure, PLANTED)


def plot_borders(ax, rows):
    """Limits of valid input as a grid of outcomes, a row a case, a column a public function."""
    cases = list(rows["value"].unique())
    methods = list(rows["method"].unique())
    style = {"markersize": 5, "markeredgewidth": 1.5, "linestyle": "none"}
    for outcome in ("within", "refused", "wrong"):
        chosen = rows.query("outcome == @outcome")
        x = chosen["method"].map(methods.index)
        y = chosen["value"].map(cases.index)
        ax.plot(x, y, label=outcome, **OUTCOMES[outcome], **style)
    names = [METHOD_NAMES[method].replace(" ", "\n", 1) for method in methods]
    ax.set_xticks(range(len(methods)), names, fontsize=6)
    list_downwards(ax, cases, fontsize=6)
    ax.set(xlim=(-0.5, len(methods) - 0.5), title="limits of valid input")
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.17), ncols=3)


def plot_methods(ax, setting, rows):
    """One sweep of PHY's atlas: error against the value swept.

    Crosses are wrong, bars at the top are refused.
    """
    rows = rows.assign(value=rows["value"].astype(float))
    methods = list(rows["method"].unique())
    for method in sorted(methods, key=lambda name: name in PUBLIC):
        # Bars of several methods stand one above the other.
        height = 3 * MOST_ERROR_DB * 4 ** (methods.index(method) % 4)
        plot_method(ax, method, rows.query("method == @method"), height)
    limit = rows.query("method in ('planned', 'gamma')").sort_values("value")
    ax.plot(limit["value"], limit["limit_db"], color="0.5", linestyle=":", linewidth=0.9)
    if (rows["value"] > 0).all():
        ax.set_xscale("log")
    else:
        ax.set_xscale("symlog", linthresh=LINEAR_FROM[setting])
    ax.set_yscale("log")
    ax.set(ylim=(LEAST_ERROR / 3, 1e5), yticks=10.0 ** np.arange(-14, 3, 4))
    if setting in TICKS:
        ax.set_xticks(TICKS[setting])
        ax.set_xticks([], minor=True)
    ax.axhspan(1.5 * MOST_ERROR_DB, 1e5, color="0.93", zorder=0)
    ax.set_title(setting)
    ax.tick_params(labelsize=6)


def plot_method(ax, method, rows, refused_at):
    """Error of one method over a sweep: public functions thick, and above the others."""
    rows = rows.sort_values("value")
    error = rows["error_db"].clip(LEAST_ERROR, MOST_ERROR_DB)
    public = method in PUBLIC
    style = {"color": COLOURS[method], "zorder": 3 if public else 2}
    linewidth = 1.6 if public else 0.7
    ax.plot(rows["value"], error, linewidth=linewidth, label=METHOD_NAMES[method], **style)
    wrong = rows.query("outcome == 'wrong'")
    ax.plot(wrong["value"], error[wrong.index], "x", markersize=4, **style)
    refused = rows.query("outcome == 'refused'")["value"]
    ax.plot(refused, np.full(len(refused), refused_at), "|", markersize=5, **style)


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
    axes[0, 0].legend()
    return note_source(figure, PLANTED)


def plot_estimators(ax, atlas, panel, quantity):
    """Mean error over layers of one quantity along a sweep.

    With two claimed standard errors, and the bound in grey.
    """
    scale = 1 if quantity == "width_bins" else 100
    bound = scale * atlas.query("quantity == @quantity")["bound"].iloc[0]
    limit = MOST_BOUNDS * bound
    ax.axhspan(-bound, bound, color="0.9", zorder=0)
    rows = atlas.query("panel == @panel and quantity in (@quantity, 'all')")
    rows = rows.assign(value=rows["value"].astype(float))
    for estimator, part in rows.groupby("estimator", sort=False):
        part = part.sort_values("value")
        colour = COLOURS[estimator]
        held = part.query("outcome != 'refused'")
        error = scale * held["error"]
        reach = 2 * scale * held["standard_error"]
        low = np.maximum(error - reach, -limit)
        high = np.minimum(error + reach, limit)
        ax.vlines(held["value"], low, high, color=colour, alpha=0.4, linewidth=2)
        error = error.clip(-limit, limit)
        ax.plot(held["value"], error, "o-", color=colour, label=estimator)
        refused = part.query("outcome == 'refused'")["value"]
        ax.plot(refused, np.full(len(refused), limit), "x", color=colour, markersize=4)
    ax.set_yscale("symlog", linthresh=bound)
    ax.set_ylim(-1.5 * limit, 1.5 * limit)
    ticks = bound * np.array([-100, -10, -1, 0, 1, 10, 100])
    ax.set_yticks(ticks, [f"{tick:g}" for tick in ticks], fontsize=6)
    ax.set_yticks([], minor=True)
    if panel in LOGARITHMIC:
        ax.set_xscale("log")
    values = sorted(rows["value"].unique())
    ax.set_xticks(values, [f"{value:g}" for value in values], fontsize=6)
    ax.set_xticks([], minor=True)


def atlas_statistics_borders(atlas_statistics):
    """Border cases: the worst outcome of each estimator, and the rule or the refusal in words."""
    rows = atlas_statistics.query("panel == 'borders'")
    by_case = rows.groupby(["value", "estimator"])
    cases = list(rows["value"].unique())
    estimators = ["deblended", "paper"]
    order = ["within", "beyond", "refused", "not finite"]
    figure, ax = new_panel(width=8, height=4.5)
    style = {"markersize": 6, "linestyle": "none"}
    for j, estimator in enumerate(estimators):
        for i, case in enumerate(cases):
            held = by_case.get_group((case, estimator))
            worst = max(held["outcome"], key=order.index)
            ax.plot(j, i, markeredgewidth=1.5, **style, **OUTCOMES[worst])
            if j == 0:
                note = held["note"].fillna("").iloc[0]
                ax.text(1.6, i, note, fontsize=5.5, va="center")
    for outcome in order:
        ax.plot([], [], label=outcome, **style, **OUTCOMES[outcome])
    ax.set_xticks(range(len(estimators)), estimators, fontsize=7, rotation=30, ha="right")
    list_downwards(ax, cases, fontsize=7)
    ax.set_xlim(-0.5, 12)
    ax.legend(loc="upper center", bbox_to_anchor=(0.4, 1.08), ncols=4)
    return note_source(figure, PLANTED)
