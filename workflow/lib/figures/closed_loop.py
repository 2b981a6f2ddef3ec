"""The closed loop and its validation: statistics of label sets and of PHY's renders beside those of the flight."""

import numpy as np

from lib.figures.labels import plot_correlation, plot_spectra
from lib.figures.style import (
    BLACK,
    BLUE,
    GREEN,
    ORANGE,
    RED,
    WHITE,
    ZONE_COLOURS,
    name_of,
    new_figure,
    note_source,
)

UNITS = {"relative": "%", "bins": "range bins", "dB": "dB"}
MOST_BOUNDS = 6  # errors beyond so many bounds are arrows at the border
CONVENTION_MARKS = {"peak_power": (BLUE, "o"), "decay_rate": (RED, "s"), "width_bins": (GREEN, "^")}
CONVENTION_MARKS |= {"offset_bins": (ORANGE, "v"), "noise_power": (BLACK, "x")}
OBSERVED = "0.65"  # grey of the flight's bars
SHOWN_SLABS = (0, 4)
DRAWN_BELOW_NOISE_DB = 15


def closed_loop(closed_loop, closed_loop_conventions, source):
    """Errors by layer, slab and band of wavenumber, and the conventions of PHY side by side."""
    figure, axes = new_figure(2, 3, width=9.5, height=5.5)
    for ax, quantity in zip(axes.flat, ("peak_power", "decay_rate", "width_bins"), strict=False):
        plot_layer_errors(ax, closed_loop, quantity)
    plot_slab_errors(axes[1, 0], closed_loop, "relative_thickness_mean")
    plot_spectrum_errors(axes[1, 1], closed_loop)
    # Median error over bound of every quantity that conventions bear on, a row a convention.
    ax = axes[1, 2]
    rows = np.arange(len(closed_loop_conventions))
    for quantity, (colour, marker) in CONVENTION_MARKS.items():
        share = (
            closed_loop_conventions[f"{quantity}_median"]
            / closed_loop_conventions[f"{quantity}_bound"]
        )
        ax.plot(
            np.maximum(share, 1e-3),
            rows,
            marker,
            color=colour,
            markersize=4,
            label=name_of(quantity),
        )
    ax.axvline(1, color="0.6", linewidth=1)
    labels = [
        f"{row.normalise}, {row.align}, {row.width}\n({row.estimator}{', closest' if row.closest else ''})"
        for row in closed_loop_conventions.itertuples()
    ]
    ax.set_yticks(rows, labels, fontsize=6)
    ax.invert_yaxis()
    ax.set(xscale="log", xlabel="median error / bound")
    ax.legend(fontsize=5.5, loc="upper center", bbox_to_anchor=(0.4, 1.16), ncols=3)
    return note_source(figure, f"{source}, and PHY renders of its statistics")


def plot_layer_errors(ax, table, quantity):
    """Error of one quantity by layer with two standard errors; layers below the noise as open markers."""
    rows = table[table["quantity"] == quantity]
    scale = _bound(ax, rows, quantity)
    power = table[table["quantity"] == "peak_power"].set_index("layer")["given"]
    noise = table.loc[table["quantity"] == "noise_power", "given"].iloc[0]
    hidden = (rows["layer"].map(power) < noise).to_numpy()
    error, reach = (
        scale * rows["error"].to_numpy(),
        2 * scale * rows["error_standard_error"].to_numpy(),
    )
    layer = rows["layer"].to_numpy()
    ax.vlines(layer, error - reach, error + reach, color="0.7", linewidth=0.8)
    ax.plot(layer[~hidden], error[~hidden], "o", color=BLUE, markersize=3)
    ax.plot(layer[hidden], error[hidden], "o", color=BLUE, markersize=3, markerfacecolor=WHITE)
    _limit(ax, rows, scale, "layer")


def plot_slab_errors(ax, table, quantity):
    """Error of one quantity by slab, a colour a zone, with two standard errors."""
    rows = table[table["quantity"] == quantity]
    scale = _bound(ax, rows, quantity)
    for zone, part in rows.groupby("zone"):
        error, reach = scale * part["error"], 2 * scale * part["error_standard_error"]
        at = part["slab"] + 0.18 * (zone - 1.5)
        ax.vlines(
            at, error - reach, error + reach, color=ZONE_COLOURS[zone], linewidth=0.6, alpha=0.6
        )
        ax.plot(at, error, "o", color=ZONE_COLOURS[zone], markersize=2.5, label=f"zone {zone}")
    _limit(ax, rows, scale, "slab")
    if len(rows):
        ax.legend(fontsize=6, ncols=2)


def plot_spectrum_errors(ax, table):
    """Error of thickness spectra by band of wavenumber: every zone and slab as a dot, their median as a bar."""
    rows = table[table["quantity"] == "thickness_psd"]
    scale = _bound(ax, rows, "thickness PSD", unit="dB")
    for band, part in rows.groupby("band"):
        spread = np.linspace(-0.3, 0.3, len(part))
        ax.scatter(
            band + spread,
            part["error"],
            c=[ZONE_COLOURS[zone] for zone in part["zone"]],
            s=3,
            alpha=0.6,
        )
        ax.hlines(part["error"].median(), band - 0.35, band + 0.35, color=BLACK, linewidth=1.5)
    _limit(ax, rows, scale, "band")
    ax.set_xticks(sorted(rows["band"].unique()))
    ax.set_xlabel("band of wavenumber")


def _bound(ax, rows, quantity, unit="relative"):
    """The bound as a grey band about zero, a word where there is nothing to show; gives the factor of the unit."""
    unit = rows["unit"].iloc[0] if len(rows) else unit
    scale = 100 if unit == "relative" else 1
    if rows.empty:
        ax.annotate(
            "too few scenes", (0.5, 0.5), xycoords="axes fraction", ha="center", color="0.5"
        )
    else:
        bound = scale * rows["bound"].max()
        ax.axhspan(-bound, bound, color="0.92", zorder=0)
        ax.axhline(0, color="0.6", linewidth=0.8)
    ax.set_ylabel(f"error of {name_of(quantity)} [{UNITS[unit]}]")
    return scale


def _limit(ax, rows, scale, along):
    """Axis limits of six bounds, with an arrow on the edge for what lies beyond."""
    ax.set_xlabel(along)
    limit = MOST_BOUNDS * scale * rows["bound"].max()
    for row in rows[(scale * rows["error"]).abs() > limit].itertuples():
        at, marker = (0.96 * limit, "^") if row.error > 0 else (-0.96 * limit, "v")
        ax.plot(getattr(row, along), at, marker, color="0.4", markersize=4)
    if len(rows):
        ax.set_ylim(-limit, limit)


def validation_thickness(validation_thickness, validation_tests):
    """Thickness of two slabs by zone: flight with its Gaussian, and labels."""
    zones = sorted(validation_thickness.loc[validation_thickness["slab"] == 0, "zone"].unique())[:4]
    figure, axes = new_figure(len(SHOWN_SLABS), 4, width=10, height=4.6)
    for row, slab in zip(axes, SHOWN_SLABS, strict=True):
        for ax, zone in zip(row, zones, strict=False):
            plot_thickness_histogram(ax, validation_thickness, validation_tests, zone, slab)
        row[0].set_ylabel("share per bin")
    axes[0, 0].legend(fontsize=6)
    return figure


def plot_thickness_histogram(ax, thickness, tests, zone, slab):
    """Thickness of one slab in one zone: lines of the flight as bars with their Gaussian, labels as a line."""
    rows = thickness[(thickness["zone"] == zone) & (thickness["slab"] == slab)]
    low = rows["low_bins"].to_numpy()
    if rows["n_observed"].sum():
        share = (rows["n_observed"] / rows["n_observed"].sum()).to_numpy()
        ax.bar(low + 0.5, share, width=1, color=OBSERVED, label="flight")
        mean = (share * (low + 0.5)).sum()
        deviation = np.sqrt(max((share * (low + 0.5 - mean) ** 2).sum(), 1e-6))
        x = np.linspace(low.min(), low.max() + 1, 200)
        gaussian = np.exp(-((x - mean) ** 2) / (2 * deviation**2)) / (
            deviation * np.sqrt(2 * np.pi)
        )
        ax.plot(x, gaussian, color=BLACK, linewidth=1, label="its Gaussian")
    if rows["n_synthetic"].sum():
        share = rows["n_synthetic"] / rows["n_synthetic"].sum()
        ax.step(low + 0.5, share, where="mid", color=BLUE, linewidth=1, label="labels")
    held = tests[(tests["zone"] == zone) & (tests["slab"] == slab) & (tests["of"] == "undulation")]
    if len(held):
        p_value, n = held[["p_value_correlated", "n_effective"]].iloc[0]
        ax.set_title(f"undulations: p = {p_value:.2g} (n about {n:.0f})", fontsize=6.5)
    ax.set_xlabel(f"slab {slab}, zone {zone} [bins]", fontsize=8)


def validation(validation_distributions, validation_thickness, validation_tests, label_spectra, label_correlation,
               closed_loop):  # fmt: skip
    """The flight beside label sets, and beside PHY's renders of them."""
    figure, axes = new_figure(3, 3, width=10, height=7.5)
    quantity = validation_distributions["quantity"]
    plot_shares(axes[0, 0], validation_distributions[quantity == "n_layers"], "flight", "labels")
    axes[0, 0].set(xlabel="layers below the surface", ylabel="share per unit")
    first = validation_thickness[validation_thickness["slab"] == -1]
    first = first.groupby("low_bins")[["n_observed", "n_synthetic"]].sum().reset_index(names="low")
    plot_shares(
        axes[0, 1], first.assign(high=first["low"] + 1), "blocks of the flight", "label scenes"
    )
    axes[0, 1].set(xlabel="mean thickness of slab 0 [bins]", ylabel="share per bin")
    # Probabilities of normality in order, by kind, beside what Gaussian thickness would give.
    ax = axes[0, 2]
    for of, colour in (("relative block mean", BLUE), ("undulation", RED)):
        p_value = np.sort(validation_tests.loc[validation_tests["of"] == of, "p_value_correlated"])
        if p_value.size:
            ax.plot(
                (np.arange(p_value.size) + 0.5) / p_value.size,
                p_value,
                ".",
                color=colour,
                markersize=3,
                label=of,
            )
    ax.plot([0, 1], [0, 1], color="0.7", linewidth=1)
    ax.axhline(0.05, color="0.7", linestyle=":", linewidth=1)
    ax.set(xlabel="share of zones and slabs", ylabel="p of normality")
    if len(validation_tests):
        ax.legend(fontsize=6)
    for ax, slab in zip(axes[1], SHOWN_SLABS, strict=False):
        plot_spectra(ax, label_spectra, slab)
    plot_correlation(axes[1, 2], label_correlation)
    plot_given_and_recovered(
        axes[2, 0], closed_loop, "peak_power", "peak power [dB]", decibels=True
    )
    plot_given_and_recovered(axes[2, 1], closed_loop, "decay_rate", "decay rate [1 / bin]")
    plot_shares(axes[2, 2], validation_distributions[quantity == "width_bins"], "flight", "renders")
    axes[2, 2].set(xlabel="1/e width of averaged lines [bins]", ylabel="share per unit")
    return figure


def plot_shares(ax, rows, observed, synthetic):
    """Histogram of shares per unit, observed as bars, synthetic as a line, both named."""
    middle, width = (rows["low"] + rows["high"]) / 2, rows["high"] - rows["low"]
    share = {
        column: rows[column] / max(rows[column].sum(), 1) / width
        for column in ("n_observed", "n_synthetic")
    }
    ax.bar(middle, share["n_observed"], width=width, color=OBSERVED, label=observed)
    ax.step(middle, share["n_synthetic"], where="mid", color=BLUE, linewidth=1, label=synthetic)
    ax.legend(fontsize=6)


def plot_given_and_recovered(ax, loop, quantity, ylabel, *, decibels=False):
    """One quantity by layer: of the flight with two standard errors, and of the renders."""
    rows = loop[loop["quantity"] == quantity]
    if rows.empty:
        ax.annotate(
            "too few scenes", (0.5, 0.5), xycoords="axes fraction", ha="center", color="0.5"
        )
        return
    scale = (
        (lambda value: 10 * np.log10(np.maximum(value, 1e-30)))
        if decibels
        else (lambda value: value)
    )
    given, error = rows["given"], 2 * rows["given_standard_error"]
    low = np.maximum(given - error, 0.1 * given) if decibels else given - error
    ax.vlines(rows["layer"], scale(low), scale(given + error), color=OBSERVED, linewidth=2)
    ax.plot(rows["layer"], scale(given), "o", color=BLACK, markersize=2.5, label="flight")
    ax.plot(
        rows["layer"],
        scale(rows["recovered"]),
        "x",
        color=BLUE,
        markersize=3,
        label="renders of labels",
    )
    ax.set(xlabel="layer", ylabel=ylabel)
    if not decibels:
        ax.set_ylim(0, 1.2 * rows[["given", "recovered"]].max().max())
    ax.legend(fontsize=6)


def superposition(superposition):
    """One averaged range line, the fitted sum of its layers, and every layer alone."""
    line = superposition
    figure, axes = new_figure(1, 1, width=8, height=3.4)
    ax = axes[0, 0]
    ax.plot(
        line["row"],
        10 * np.log10(line["observed"]),
        color="0.6",
        linewidth=1.2,
        label="averaged line",
    )
    floor = 10 * np.log10(line["observed"].min()) - DRAWN_BELOW_NOISE_DB
    for name in (name for name in line.columns if name.startswith("layer_")):
        alone = 10 * np.log10(np.maximum(line[name], 1e-30))
        ax.plot(line["row"], np.where(alone > floor, alone, np.nan), color=RED, linewidth=0.6)
    ax.plot([], [], color=RED, linewidth=0.6, label="each layer")
    ax.plot(
        line["row"],
        10 * np.log10(np.maximum(line["model"], 1e-30)),
        color=BLUE,
        linewidth=1,
        label="sum",
    )
    ax.set(xlabel="range bins below the surface", ylabel="power [dB]", ylim=(floor, None))
    ax.legend(fontsize=6)
    return figure
