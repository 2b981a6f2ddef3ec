"""The closed loop: statistics of label sets and of PHY's renders beside those of the flight."""

import numpy as np

from evaluation.lib.figures.labels import plot_correlation, plot_spectra
from evaluation.lib.figures.style import (
    BLACK,
    BLUE,
    GREEN,
    ORANGE,
    RED,
    WHITE,
    ZONE_COLOURS,
    name_of,
    new_figure,
    new_panel,
    note_source,
)
from snowsim.echogram import to_db

UNITS = {"relative": "%", "bins": "range bins", "dB": "dB"}
MOST_BOUNDS = 6  # errors beyond so many bounds are arrows at the border
CONVENTION_MARKS = {
    "peak_power": {"color": BLUE, "marker": "o"},
    "decay_rate": {"color": RED, "marker": "s"},
    "width_bins": {"color": GREEN, "marker": "^"},
    "offset_bins": {"color": ORANGE, "marker": "v"},
    "noise_power": {"color": BLACK, "marker": "x"},
}
OBSERVED = "0.65"  # grey of the flight's bars
SHOWN_SLABS = (0, 4)
DRAWN_BELOW_NOISE_DB = 15
LEAST_POWER = 1e-30  # powers below are drawn there


def closed_loop(closed_loop, closed_loop_conventions, source):
    """Errors by layer, slab and band of wavenumber, and the conventions of PHY side by side."""
    figure, axes = new_figure(2, 3, width=9.5, height=5.5)
    for ax, quantity in zip(axes[0], ("peak_power", "decay_rate", "width_bins"), strict=True):
        plot_layer_errors(ax, closed_loop, quantity)
    of_slabs, of_spectra, of_conventions = axes[1]
    plot_slab_errors(of_slabs, closed_loop, "relative_thickness_mean")
    plot_spectrum_errors(of_spectra, closed_loop)
    plot_conventions(of_conventions, closed_loop_conventions)
    return note_source(figure, f"{source}, and PHY renders of its statistics")


def plot_conventions(ax, conventions):
    """Median error over bound of every quantity that conventions bear on, a row a convention."""
    rows = np.arange(len(conventions))
    for quantity, mark in CONVENTION_MARKS.items():
        share = conventions[f"{quantity}_median"] / conventions[f"{quantity}_bound"]
        share = np.maximum(share, 1e-3)
        style = {"linestyle": "none", "markersize": 4, "label": name_of(quantity)}
        ax.plot(share, rows, **mark, **style)
    ax.axvline(1, color="0.6", linewidth=1)
    labels = []
    for row in conventions.itertuples():
        closest = ", closest" if row.closest else ""
        options = f"{row.normalise}, {row.align}, {row.width}"
        labels.append(f"{options}\n({row.estimator}{closest})")
    ax.set_yticks(rows, labels, fontsize=6)
    ax.invert_yaxis()
    ax.set(xscale="log", xlabel="median error / bound")
    ax.legend(fontsize=5.5, loc="upper center", bbox_to_anchor=(0.4, 1.16), ncols=3)


def plot_layer_errors(ax, table, quantity):
    """Error of one quantity by layer with two standard errors; open: layers below the noise."""
    rows = table.query("quantity == @quantity")
    scale = _bound(ax, rows, quantity)
    power = table.query("quantity == 'peak_power'").set_index("layer")["given"]
    noise = table.query("quantity == 'noise_power'")["given"].iloc[0]
    hidden = rows["layer"].map(power) < noise
    error = scale * rows["error"]
    reach = 2 * scale * rows["error_standard_error"]
    layer = rows["layer"]
    ax.vlines(layer, error - reach, error + reach, color="0.7", linewidth=0.8)
    ax.plot(layer[~hidden], error[~hidden], "o", color=BLUE)
    ax.plot(layer[hidden], error[hidden], "o", color=BLUE, markerfacecolor=WHITE)
    _limit(ax, rows, scale, "layer")


def plot_slab_errors(ax, table, quantity):
    """Error of one quantity by slab, a colour a zone, with two standard errors."""
    rows = table.query("quantity == @quantity")
    scale = _bound(ax, rows, quantity)
    for zone, part in rows.groupby("zone"):
        colour = ZONE_COLOURS[zone]
        error = scale * part["error"]
        reach = 2 * scale * part["error_standard_error"]
        at = part["slab"] + 0.18 * (zone - 1.5)
        ax.vlines(at, error - reach, error + reach, color=colour, linewidth=0.6, alpha=0.6)
        ax.plot(at, error, "o", color=colour, markersize=2.5, label=f"zone {zone}")
    _limit(ax, rows, scale, "slab")
    if len(rows):
        ax.legend(ncols=2)


def plot_spectrum_errors(ax, table):
    """Error of thickness spectra by band: every zone and slab as a dot, their median as a bar."""
    rows = table.query("quantity == 'thickness_psd'")
    scale = _bound(ax, rows, "thickness PSD", unit="dB")
    for band, part in rows.groupby("band"):
        at = band + np.linspace(-0.3, 0.3, len(part))
        colours = part["zone"].map(ZONE_COLOURS.__getitem__)
        ax.scatter(at, part["error"], c=colours, s=3, alpha=0.6)
        median = part["error"].median()
        ax.hlines(median, band - 0.35, band + 0.35, color=BLACK, linewidth=1.5)
    _limit(ax, rows, scale, "band")
    ax.set_xticks(sorted(rows["band"].unique()))
    ax.set_xlabel("band of wavenumber")


def _bound(ax, rows, quantity, unit="relative"):
    """The bound as a grey band about zero; gives the factor of the unit.

    A word stands where there is nothing to show.
    """
    unit = rows["unit"].iloc[0] if len(rows) else unit
    scale = 100 if unit == "relative" else 1
    if rows.empty:
        _say_too_few(ax)
    else:
        bound = scale * rows["bound"].max()
        ax.axhspan(-bound, bound, color="0.92", zorder=0)
        ax.axhline(0, color="0.6", linewidth=0.8)
    ax.set_ylabel(f"error of {name_of(quantity)} [{UNITS[unit]}]")
    return scale


def _say_too_few(ax):
    middle = (0.5, 0.5)
    ax.annotate("too few scenes", middle, xycoords="axes fraction", ha="center", color="0.5")


def _limit(ax, rows, scale, along):
    """Axis limits of six bounds, with an arrow on the edge for what lies beyond."""
    ax.set_xlabel(along)
    limit = MOST_BOUNDS * scale * rows["bound"].max()
    beyond = rows[(scale * rows["error"]).abs() > limit]
    for at, error in zip(beyond[along], beyond["error"], strict=True):
        marker = "^" if error > 0 else "v"
        ax.plot(at, np.sign(error) * (0.96 * limit), marker, color="0.4", markersize=4)
    if len(rows):
        ax.set_ylim(-limit, limit)


def validation_thickness(validation_thickness, validation_tests):
    """Thickness of two slabs by zone: flight with its Gaussian, and labels."""
    zones = sorted(validation_thickness.query("slab == 0")["zone"].unique())[:4]
    figure, axes = new_figure(len(SHOWN_SLABS), 4, width=10, height=4.6)
    for row, slab in zip(axes, SHOWN_SLABS, strict=True):
        for ax, zone in zip(row, zones, strict=False):
            plot_thickness_histogram(ax, validation_thickness, validation_tests, zone, slab)
        row[0].set_ylabel("share per bin")
    axes[0, 0].legend()
    return figure


def plot_thickness_histogram(ax, thickness, tests, zone, slab):
    """Thickness of one slab in one zone: flight as bars with their Gaussian, labels as a line."""
    rows = thickness.query("zone == @zone and slab == @slab")
    middle = rows["low_bins"] + 0.5
    n_observed = rows["n_observed"]
    if n_observed.any():
        share = n_observed / n_observed.sum()
        ax.bar(middle, share, width=1, color=OBSERVED, label="flight")
        mean = (share * middle).sum()
        variance = (share * (middle - mean) ** 2).sum()
        deviation = np.sqrt(max(variance, 1e-6))
        x = np.linspace(middle.min() - 0.5, middle.max() + 0.5, 200)
        bell = np.exp(-((x - mean) ** 2) / (2 * deviation**2))
        density = bell / (deviation * np.sqrt(2 * np.pi))
        ax.plot(x, density, color=BLACK, linewidth=1, label="its Gaussian")
    n_synthetic = rows["n_synthetic"]
    if n_synthetic.any():
        share = n_synthetic / n_synthetic.sum()
        ax.step(middle, share, where="mid", color=BLUE, linewidth=1, label="labels")
    of_slab = tests.query("zone == @zone and slab == @slab and of == 'undulation'")
    for test in of_slab.itertuples():
        title = f"undulations: p = {test.p_value_correlated:.2g} (n about {test.n_effective:.0f})"
        ax.set_title(title, fontsize=6.5)
    ax.set_xlabel(f"slab {slab}, zone {zone} [bins]", fontsize=8)


def validation(
    validation_distributions,
    validation_thickness,
    validation_tests,
    label_spectra,
    label_correlation,
    closed_loop,
):
    """The flight beside label sets, and beside PHY's renders of them."""
    figure, axes = new_figure(3, 3, width=10, height=7.5)
    of_scenes, of_spectra, of_renders = axes
    distributions = dict(list(validation_distributions.groupby("quantity")))
    plot_shares(of_scenes[0], distributions["n_layers"], "flight", "labels")
    of_scenes[0].set(xlabel="layers below the surface", ylabel="share per unit")
    plot_first_slab(of_scenes[1], validation_thickness)
    plot_normality(of_scenes[2], validation_tests)
    for ax, slab in zip(of_spectra, SHOWN_SLABS, strict=False):
        plot_spectra(ax, label_spectra, slab)
    plot_correlation(of_spectra[2], label_correlation)
    plot_recovered_power(of_renders[0], closed_loop)
    plot_recovered_decay(of_renders[1], closed_loop)
    plot_shares(of_renders[2], distributions["width_bins"], "flight", "renders")
    of_renders[2].set(xlabel="1/e width of averaged lines [bins]", ylabel="share per unit")
    return figure


def plot_first_slab(ax, thickness):
    """Mean thickness of slab 0: blocks of the flight, label scenes."""
    of_blocks = thickness.query("slab == -1").groupby("low_bins")
    shares = of_blocks[["n_observed", "n_synthetic"]].sum().reset_index(names="low")
    shares["high"] = shares["low"] + 1
    plot_shares(ax, shares, "blocks of the flight", "label scenes")
    ax.set(xlabel="mean thickness of slab 0 [bins]", ylabel="share per bin")


def plot_normality(ax, tests):
    """Probabilities of normality in order, by kind, beside what Gaussian thickness would give."""
    for of, colour in {"relative block mean": BLUE, "undulation": RED}.items():
        p_value = np.sort(tests.query("of == @of")["p_value_correlated"])
        if p_value.size:
            share = (np.arange(p_value.size) + 0.5) / p_value.size
            ax.plot(share, p_value, ".", color=colour, label=of)
    ax.plot([0, 1], [0, 1], color="0.7", linewidth=1)
    ax.axhline(0.05, color="0.7", linestyle=":", linewidth=1)
    ax.set(xlabel="share of zones and slabs", ylabel="p of normality")
    if len(tests):
        ax.legend()


def plot_shares(ax, rows, observed, synthetic):
    """Histogram of shares per unit, observed as bars, synthetic as a line, both named."""
    middle = (rows["low"] + rows["high"]) / 2
    width = rows["high"] - rows["low"]

    def share(count):
        return count / max(count.sum(), 1) / width

    ax.bar(middle, share(rows["n_observed"]), width=width, color=OBSERVED, label=observed)
    style = {"color": BLUE, "linewidth": 1, "label": synthetic}
    ax.step(middle, share(rows["n_synthetic"]), where="mid", **style)
    ax.legend()


def plot_recovered_power(ax, loop):
    """Peak power by layer, of the flight and of the renders."""
    rows = loop.query("quantity == 'peak_power'")
    error = 2 * rows["given_standard_error"]
    given = rows["given"]
    low = np.maximum(given - error, 0.1 * given)
    plot_given_and_recovered(ax, rows, low, given + error, _power_db)
    ax.set_ylabel("peak power [dB]")


def plot_recovered_decay(ax, loop):
    """Decay rate by layer, of the flight and of the renders."""
    rows = loop.query("quantity == 'decay_rate'")
    error = 2 * rows["given_standard_error"]
    plot_given_and_recovered(ax, rows, rows["given"] - error, rows["given"] + error, np.asarray)
    ax.set(ylabel="decay rate [1 / bin]", ylim=(0, 1.2 * rows[["given", "recovered"]].max().max()))


def plot_given_and_recovered(ax, rows, low, high, scale):
    """One quantity by layer: of the flight with its interval, and of the renders."""
    if rows.empty:
        _say_too_few(ax)
        return
    layer = rows["layer"]
    ax.vlines(layer, scale(low), scale(high), color=OBSERVED, linewidth=2)
    ax.plot(layer, scale(rows["given"]), "o", color=BLACK, markersize=2.5, label="flight")
    ax.plot(layer, scale(rows["recovered"]), "x", color=BLUE, label="renders of labels")
    ax.set_xlabel("layer")
    ax.legend()


def _power_db(power):
    return to_db(np.maximum(power, LEAST_POWER))


def superposition(superposition):
    """One averaged range line, the fitted sum of its layers, and every layer alone."""
    row = superposition["row"]
    observed_db = to_db(superposition["observed"])
    floor_db = observed_db.min() - DRAWN_BELOW_NOISE_DB
    figure, ax = new_panel(width=8, height=3.4)
    ax.plot(row, observed_db, color="0.6", linewidth=1.2, label="averaged line")
    for _, power in superposition.filter(like="layer_").items():
        alone_db = _power_db(power)
        ax.plot(row, alone_db.where(alone_db > floor_db), color=RED, linewidth=0.6)
    ax.plot([], [], color=RED, linewidth=0.6, label="each layer")
    ax.plot(row, _power_db(superposition["model"]), color=BLUE, linewidth=1, label="sum")
    ax.set(xlabel="range bins below the surface", ylabel="power [dB]", ylim=(floor_db, None))
    ax.legend()
    return figure
