"""The stability atlas of the estimators: error against what makes estimation hard, and border cases.

The closed loop: error of what comes back by layer, slab and band, and conventions side by side.
"""

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


# Okabe & Ito (2008), as in the other figures.
BLACK, BLUE, RED, GREEN, ORANGE = "#000000", "#0072B2", "#D55E00", "#009E73", "#E69F00"
ZONE_COLOURS = (BLUE, GREEN, ORANGE, RED)
UNITS = {"relative": "%", "bins": "range bins", "dB": "dB"}
NAMES = {
    "peak_power": "peak power",
    "decay_rate": "decay rate",
    "width_bins": "1/e width",
    "noise_power": "noise",
    "offset_bins": "offset",
    "relative_thickness_mean": "thickness / slab 0",
}


def plot_layer_errors(ax, table, quantity):
    """Error of one quantity by layer with two standard errors; layers below the noise as open markers."""
    rows = table[table["quantity"] == quantity]
    scale, unit = _scale(rows)
    power = table[table["quantity"] == "peak_power"].set_index("layer")["given"]
    noise = table.loc[table["quantity"] == "noise_power", "given"].iloc[0]
    hidden = (rows["layer"].map(power) < noise).to_numpy()
    _bound(ax, rows, scale)
    error, reach = scale * rows["error"].to_numpy(), 2 * scale * rows["error_standard_error"].to_numpy()
    layer = rows["layer"].to_numpy()
    ax.vlines(layer, error - reach, error + reach, color="0.7", linewidth=0.8)
    ax.plot(layer[~hidden], error[~hidden], "o", color=BLUE, markersize=3)
    ax.plot(layer[hidden], error[hidden], "o", color=BLUE, markersize=3, markerfacecolor="white")
    _limit(ax, rows, scale)
    ax.set(xlabel="layer", ylabel=f"error of {NAMES[quantity]} [{unit}]")


def plot_slab_errors(ax, table, quantity):
    """Error of one quantity by slab, a colour a zone, with two standard errors."""
    rows = table[table["quantity"] == quantity]
    scale, unit = _scale(rows)
    _bound(ax, rows, scale)
    for zone, part in rows.groupby("zone"):
        error, reach = scale * part["error"], 2 * scale * part["error_standard_error"]
        at = part["slab"] + 0.18 * (zone - 1.5)
        ax.vlines(at, error - reach, error + reach, color=ZONE_COLOURS[zone], linewidth=0.6, alpha=0.6)
        ax.plot(at, error, "o", color=ZONE_COLOURS[zone], markersize=2.5, label=f"zone {zone}")
    _limit(ax, rows, scale)
    ax.set(xlabel="slab", ylabel=f"error of {NAMES[quantity]} [{unit}]")
    if len(rows):
        ax.legend(frameon=False, fontsize=6, ncols=2)


def plot_spectrum_errors(ax, table):
    """Error of thickness spectra by band of wavenumber: every zone and slab as a dot, their median as a bar."""
    rows = table[table["quantity"] == "thickness_psd"]
    _bound(ax, rows, 1)
    for band, part in rows.groupby("band"):
        spread = np.linspace(-0.3, 0.3, len(part))
        ax.scatter(band + spread, part["error"], c=[ZONE_COLOURS[zone] for zone in part["zone"]], s=3, alpha=0.6)
        ax.hlines(part["error"].median(), band - 0.35, band + 0.35, color=BLACK, linewidth=1.5)
    _limit(ax, rows, 1)
    ax.set_xticks(sorted(rows["band"].unique()))
    ax.set(xlabel="band of wavenumber", ylabel="error of thickness PSD [dB]")


def plot_conventions(ax, conventions):
    """Median error over bound of every quantity that conventions bear on, a row a convention."""
    marks = {
        "peak_power": (BLUE, "o"),
        "decay_rate": (RED, "s"),
        "width_bins": (GREEN, "^"),
        "offset_bins": (ORANGE, "v"),
        "noise_power": (BLACK, "x"),
    }
    rows = np.arange(len(conventions))
    for quantity, (colour, marker) in marks.items():
        share = conventions[f"{quantity}_median"] / conventions[f"{quantity}_bound"]
        ax.plot(np.maximum(share, 1e-3), rows, marker, color=colour, markersize=4, label=NAMES[quantity])
    ax.axvline(1, color="0.6", linewidth=1)
    labels = [f"{row.normalise}, {row.align}, {row.width}" for row in conventions.itertuples()]
    labels = [
        f"{label}\n({row.estimator}{', closest' if row.closest else ''})"
        for label, row in zip(labels, conventions.itertuples(), strict=True)
    ]
    ax.set_yticks(rows, labels, fontsize=6)
    ax.invert_yaxis()
    ax.set(xscale="log", xlabel="median error / bound")
    ax.legend(frameon=False, fontsize=5.5, loc="upper center", bbox_to_anchor=(0.4, 1.16), ncols=3)


def _scale(rows):
    """Factor and unit in which errors are shown."""
    unit = rows["unit"].iloc[0] if len(rows) else "relative"
    return 100 if unit == "relative" else 1, UNITS[unit]


def _bound(ax, rows, scale):
    """The bound as a grey band about zero; a word where there is nothing to show."""
    if rows.empty:
        ax.annotate("too few scenes", (0.5, 0.5), xycoords="axes fraction", ha="center", color="0.5")
        return
    bound = scale * rows["bound"].max()
    ax.axhspan(-bound, bound, color="0.92", zorder=0)
    ax.axhline(0, color="0.6", linewidth=0.8)


def _limit(ax, rows, scale):
    """Axis limits of six bounds, with an arrow on the edge for what lies beyond."""
    if rows.empty:
        return
    limit = 6 * scale * rows["bound"].max()
    at = "layer" if (rows["layer"] >= 0).any() else "slab" if (rows["band"] < 0).all() else "band"
    for row in rows[(scale * rows["error"]).abs() > limit].itertuples():
        up = row.error > 0
        ax.plot(getattr(row, at), 0.96 * limit if up else -0.96 * limit, "^" if up else "v", color="0.4", markersize=4)
    ax.set_ylim(-limit, limit)
