"""The flight beside what was made of its statistics: thickness, number of layers, widths, powers, one line's layers."""

import numpy as np

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
