"""Synthetic labels beside the flight they were drawn from.

The flight beside what was made of its statistics: thickness, number of layers, widths, powers, one line's layers.
"""

import numpy as np
from matplotlib import colormaps

# Okabe & Ito (2008), as in the other figures.
FAMILY_COLOURS = {
    "tabulated": "#000000",
    "white": "#999999",
    "power_law": "#0072B2",
    "ar1": "#D55E00",
    "matern": "#009E73",
}
FAMILY_NAMES = {
    "tabulated": "tabulated",
    "white": "white",
    "power_law": "power law",
    "ar1": "AR(1)",
    "matern": "Matérn",
}


def plot_layer_counts(ax, layers):
    """Number of scenes by number of layers."""
    ax.bar(layers["n_layers"], layers["n_scenes"], color="0.5")
    ax.axhline(layers["n_scenes"].sum() / len(layers), color="black", linestyle=":", linewidth=1)
    ax.set(xlabel="layers below the surface", ylabel="scenes")


def plot_thickness(ax, moments):
    """Mean thickness relative to slab 0 by slab and zone: flight as points, synthetic as lines."""
    for zone, rows in moments.groupby("zone"):
        colour = _zone_colour(zone, moments)
        ax.plot(rows["slab"], rows["relative_mean_observed"], "o", color=colour, markersize=2.5)
        ax.plot(rows["slab"], rows["relative_mean_synthetic"], color=colour, label=f"zone {zone}")
    ax.set(xlabel="slab", ylabel="thickness / slab 0")
    ax.legend(fontsize=7)


def plot_spectra(ax, spectra, slab):
    """Power spectral density of one slab's thickness by zone: flight as points, synthetic as lines."""
    for zone, rows in spectra[spectra["slab"] == slab].groupby("zone"):
        colour = _zone_colour(zone, spectra)
        ax.loglog(rows["wavenumber"], rows["observed"], ".", color=colour, markersize=2)
        ax.loglog(rows["wavenumber"], rows["synthetic"], color=colour, linewidth=0.8)
    ax.set(xlabel="wavenumber [cycles per range line]", ylabel=f"PSD of slab {slab} [bins² line]")


def plot_correlation(ax, correlation):
    """Correlation of slabs by separation: flight as points, synthetic as lines, a colour a band of wavenumbers."""
    for band, rows in correlation.groupby("band"):
        colour = "black" if band < 0 else colormaps["plasma"](band / 5)
        ax.plot(rows["separation"], rows["observed"], "o", color=colour, markersize=2.5)
        ax.plot(rows["separation"], rows["synthetic"], color=colour, label="means" if band < 0 else f"band {band}")
    ax.set(xlabel="slabs apart", ylabel="correlation")
    ax.legend(fontsize=6, ncols=5, handlelength=1, columnspacing=1, loc="lower center", bbox_to_anchor=(0.5, 1))


def plot_criterion(ax, criteria, criterion):
    """A criterion above its least against parameters: a line a kind of spectrum, a point a number of zones."""
    least = criteria[criterion].min()
    for psd, rows in criteria.groupby("psd", sort=False):
        above = np.maximum(rows[criterion] - least, 10)
        ax.plot(rows["n_parameters"], above, "o-", color=FAMILY_COLOURS[psd], markersize=3, label=FAMILY_NAMES[psd])
        for row, y in zip(rows.itertuples(), above, strict=True):
            ax.annotate(f"{row.n_zones}", (row.n_parameters, y), xytext=(2, 2), textcoords="offset points", fontsize=5)
    ax.set(xscale="log", yscale="log", xlabel="parameters", ylabel=f"{criterion.upper()} above its least")
    ax.legend(fontsize=6)


def plot_families(ax, families, zone):
    """Spectrum of slab 0 in one zone, observed as points, and what each family makes of it."""
    rows = families[families["zone"] == zone]
    ax.loglog(rows["wavenumber"], rows["tabulated"], ".", color=FAMILY_COLOURS["tabulated"], markersize=2)
    for name in list(FAMILY_COLOURS)[1:]:
        ax.loglog(rows["wavenumber"], rows[name], color=FAMILY_COLOURS[name], linewidth=0.9, label=FAMILY_NAMES[name])
    ax.set(xlabel="wavenumber [cycles per range line]", ylabel=f"PSD of slab 0, zone {zone} [bins² line]")
    ax.legend(fontsize=6)


def plot_changes(ax, savings):
    """Thickness statistics of scenes by each label model against those of the first, in per cent."""
    columns = [name for name in savings.columns if name.endswith("_bins_change")]
    rows = savings[~savings["model"].isin(("paper", "in use"))]
    for i, row in enumerate(rows.itertuples()):
        label = f"{row.model}: {row.n_zones} zones, {FAMILY_NAMES[row.psd]}, {row.n_parameters} parameters"
        at = np.arange(len(columns)) + 0.25 * (i - (len(rows) - 1) / 2)
        ax.plot([100 * getattr(row, name) for name in columns], at, "o", markersize=4, label=label)
    ax.axvline(0, color="0.6", linewidth=0.8)
    names = [name.removesuffix("_bins_change").replace("_", " ") for name in columns]
    ax.set_yticks(range(len(columns)), names, fontsize=6)
    ax.invert_yaxis()
    ax.set(xlabel="change against the paper's model [%]")
    ax.legend(fontsize=5.5, loc="upper center", bbox_to_anchor=(0.35, 1.22))


def _zone_colour(zone, table):
    """Colour of a zone among those of a table."""
    return colormaps["viridis"](zone / max(table["zone"].max() + 1, 4))


# Okabe & Ito (2008), as in the other figures.
OBSERVED, SYNTHETIC, FIT, FAINT = "0.65", "#0072B2", "#000000", "#D55E00"
DRAWN_BELOW_NOISE_DB = 15


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
        gaussian = np.exp(-((x - mean) ** 2) / (2 * deviation**2)) / (deviation * np.sqrt(2 * np.pi))
        ax.plot(x, gaussian, color=FIT, linewidth=1, label="its Gaussian")
    if rows["n_synthetic"].sum():
        share = rows["n_synthetic"] / rows["n_synthetic"].sum()
        ax.step(low + 0.5, share, where="mid", color=SYNTHETIC, linewidth=1, label="labels")
    held = tests[(tests["zone"] == zone) & (tests["slab"] == slab) & (tests["of"] == "undulation")]
    if len(held):
        p_value, n = held[["p_value_correlated", "n_effective"]].iloc[0]
        ax.set_title(f"undulations: p = {p_value:.2g} (n about {n:.0f})", fontsize=6.5)
    ax.set_xlabel(f"slab {slab}, zone {zone} [bins]", fontsize=8)


def plot_test_values(ax, tests):
    """Probabilities of the tests of normality in order, by kind, beside what Gaussian thickness would give."""
    for of, colour in (("relative block mean", SYNTHETIC), ("undulation", FAINT)):
        p_value = np.sort(tests.loc[tests["of"] == of, "p_value_correlated"])
        if p_value.size:
            ax.plot((np.arange(p_value.size) + 0.5) / p_value.size, p_value, ".", color=colour, markersize=3, label=of)
    ax.plot([0, 1], [0, 1], color="0.7", linewidth=1)
    ax.axhline(0.05, color="0.7", linestyle=":", linewidth=1)
    ax.set(xlabel="share of zones and slabs", ylabel="p of normality")
    if len(tests):
        ax.legend(fontsize=6)


def plot_distribution(ax, distributions, quantity, xlabel, names=("flight", "renders")):
    """One quantity as shares, observed as bars, synthetic as a line."""
    rows = distributions[distributions["quantity"] == quantity]
    middle, width = (rows["low"] + rows["high"]) / 2, rows["high"] - rows["low"]
    for column, label in zip(("n_observed", "n_synthetic"), names, strict=True):
        share = rows[column] / max(rows[column].sum(), 1) / width
        if column == "n_observed":
            ax.bar(middle, share, width=width, color=OBSERVED, label=label)
        else:
            ax.step(middle, share, where="mid", color=SYNTHETIC, linewidth=1, label=label)
    ax.set(xlabel=xlabel, ylabel="share per unit")
    ax.legend(fontsize=6)


def plot_first_thickness(ax, thickness):
    """Mean thickness of the first slab: blocks of the flight as bars, label scenes as a line."""
    rows = thickness[thickness["slab"] == -1].groupby("low_bins")[["n_observed", "n_synthetic"]].sum()
    for column, label in (("n_observed", "blocks of the flight"), ("n_synthetic", "label scenes")):
        share = rows[column] / max(rows[column].sum(), 1)
        if column == "n_observed":
            ax.bar(rows.index + 0.5, share, width=1, color=OBSERVED, label=label)
        else:
            ax.step(rows.index + 0.5, share, where="mid", color=SYNTHETIC, linewidth=1, label=label)
    ax.set(xlabel="mean thickness of the first slab [bins]", ylabel="share per bin")
    ax.legend(fontsize=6)


def plot_given_and_recovered(ax, loop, quantity, ylabel, *, decibels=False):
    """One quantity by layer: of the flight with two standard errors, and of the renders."""
    rows = loop[loop["quantity"] == quantity]
    if rows.empty:
        ax.annotate("too few scenes", (0.5, 0.5), xycoords="axes fraction", ha="center", color="0.5")
        return
    scale = (lambda value: 10 * np.log10(np.maximum(value, 1e-30))) if decibels else (lambda value: value)
    given, error = rows["given"], 2 * rows["given_standard_error"]
    low = np.maximum(given - error, 0.1 * given) if decibels else given - error
    ax.vlines(rows["layer"], scale(low), scale(given + error), color=OBSERVED, linewidth=2)
    ax.plot(rows["layer"], scale(given), "o", color=FIT, markersize=2.5, label="flight")
    ax.plot(rows["layer"], scale(rows["recovered"]), "x", color=SYNTHETIC, markersize=3, label="renders of labels")
    ax.set(xlabel="layer", ylabel=ylabel)
    if not decibels:
        ax.set_ylim(0, 1.2 * rows[["given", "recovered"]].max().max())
    ax.legend(fontsize=6)


def plot_superposition(ax, line):
    """One averaged range line, the fitted sum of its layers, and every layer alone (Fig. 7)."""
    ax.plot(line["row"], 10 * np.log10(line["observed"]), color="0.6", linewidth=1.2, label="averaged line")
    floor = 10 * np.log10(line["observed"].min()) - DRAWN_BELOW_NOISE_DB
    for name in (name for name in line.columns if name.startswith("layer_")):
        alone = 10 * np.log10(np.maximum(line[name], 1e-30))
        ax.plot(line["row"], np.where(alone > floor, alone, np.nan), color=FAINT, linewidth=0.6)
    ax.plot([], [], color=FAINT, linewidth=0.6, label="each layer")
    ax.plot(line["row"], 10 * np.log10(np.maximum(line["model"], 1e-30)), color=SYNTHETIC, linewidth=1, label="sum")
    ax.set(xlabel="range bins below the surface", ylabel="power [dB]", ylim=(floor, None))
    ax.legend(fontsize=6)
