"""The stability atlas of the estimators: error against what makes estimation hard, and border cases."""

import numpy as np

# Okabe & Ito (2008), as in the other figures.
COLOURS = {"deblended": "#0072B2", "paper": "#D55E00"}
QUANTITIES = {"peak_power": "peak power [%]", "decay_rate": "decay rate [%]", "width_bins": "1/e width [bins]"}
MOST_BOUNDS = 300  # errors beyond so many bounds are drawn there
LOGARITHMIC = ("slab thickness [bins]", "looks of a range line", "range lines of a flight")
OUTCOMES = {
    "within": ("o", "#009E73"),
    "beyond": ("o", "#E69F00"),
    "refused": ("_", "0.4"),
    "not finite": ("x", "#D55E00"),
}


def plot_sweep(ax, atlas, panel, quantity):
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
        ax.plot(held["value"], error.clip(-limit, limit), "o-", color=colour, markersize=3, label=estimator)
        refused = part.loc[part["outcome"] == "refused", "value"]
        ax.plot(refused, np.full(len(refused), limit), "x", color=colour, markersize=4)
    ax.set_yscale("symlog", linthresh=bound)
    ax.set_ylim(-1.5 * limit, 1.5 * limit)
    ax.set_yticks([-100 * bound, -10 * bound, -bound, 0, bound, 10 * bound, 100 * bound])
    ax.set_yticklabels([f"{tick:g}" for tick in ax.get_yticks()], fontsize=6)
    ax.set_yticks([], minor=True)
    values = sorted(rows["value"].astype(float).unique())
    if panel in LOGARITHMIC:
        ax.set_xscale("log")
    ax.set_xticks(values, [f"{value:g}" for value in values], fontsize=6)
    ax.set_xticks([], minor=True)


def plot_sweeps(axes, atlas):
    """All sweeps as columns, quantities as rows, on an array of axes."""
    panels = [panel for panel in atlas["panel"].unique() if panel != "borders"]
    for i, (quantity, label) in enumerate(QUANTITIES.items()):
        for j, panel in enumerate(panels):
            plot_sweep(axes[i, j], atlas, panel, quantity)
            if i == len(QUANTITIES) - 1:
                axes[i, j].set_xlabel(panel, fontsize=8)
        axes[i, 0].set_ylabel(f"error of {label}", fontsize=8)
    axes[0, 0].legend(fontsize=6)


def plot_borders(ax, atlas):
    """Border cases: the worst outcome of each estimator as a mark, and the rule or the refusal in words."""
    rows = atlas[atlas["panel"] == "borders"]
    cases = list(rows["value"].unique())
    order = list(OUTCOMES)
    for j, estimator in enumerate(COLOURS):
        for i, case in enumerate(cases):
            held = rows[(rows["value"] == case) & (rows["estimator"] == estimator)]
            marker, colour = OUTCOMES[max(held["outcome"], key=order.index)]
            ax.plot(j, i, marker, color=colour, markersize=6, markeredgewidth=1.5)
            if j == 0:
                ax.text(1.6, i, held["note"].fillna("").iloc[0], fontsize=5.5, va="center")
    for outcome, (marker, colour) in OUTCOMES.items():
        ax.plot([], [], marker, color=colour, linestyle="none", label=outcome)
    ax.set_xticks(range(len(COLOURS)), COLOURS, fontsize=7, rotation=30, ha="right")
    ax.set_yticks(range(len(cases)), cases, fontsize=7)
    ax.set(xlim=(-0.5, 12), ylim=(len(cases) - 0.5, -0.5))
    ax.legend(fontsize=6, loc="upper center", bbox_to_anchor=(0.4, 1.08), ncols=4)
