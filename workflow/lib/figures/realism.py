"""How real a flight looks: its profile, texture, histogram, visibility and thickness, with observed values."""

from lib.figures.style import BLACK, BLUE, GREY, RED, WHITE, new_figure

OTHER_BAND = "observed, other band"  # what the table of curves calls real accumulation-radar echograms
DIRECTIONS = {"range_line": ("along track", BLUE), "range_bin": ("down", RED)}


def realism(realism, realism_curves):
    """Curves of the flight in its own units, then in standard deviations, and single figures by what is observed."""
    curves = realism_curves
    figure, axes = new_figure(2, 4, width=13, height=5.5)
    profile, histogram, autocorrelation, visibility, standard_profile, standard_histogram, thickness, levels = axes.flat
    plot_curve(profile, curves, "row profile", BLACK)
    profile.axvline(0, color="0.5", linestyle=":", linewidth=1)
    profile.set(xlabel="range bins below the surface", ylabel="mean power / noise [dB]")
    plot_curve(histogram, curves, "histogram", BLACK)
    histogram.set(xlabel="power / noise [dB]", ylabel="density [1/dB]", ylim=(0, None))
    plot_autocorrelation(autocorrelation, curves, realism)
    plot_curve(visibility, curves, "visibility", BLACK, marker="o")
    visibility.axhline(0, color="0.5", linestyle=":", linewidth=1)
    visibility.set(xlabel="range bins below the surface", ylabel="rise over the snow around [dB]")
    plot_standard(standard_profile, curves, "standard profile")
    standard_profile.set(xlabel="row of the snow", ylabel="mean of the row [s.d.]")
    plot_standard(standard_histogram, curves, "standard histogram")
    standard_histogram.set(xlabel="decibels less their mean [s.d.]", ylabel="density", ylim=(0, None))
    plot_curve(thickness, curves, "thickness PSD", BLACK)
    thickness.set(xscale="log", yscale="log", xlabel="wavenumber [cycles per range line]")
    thickness.set_ylabel("thickness PSD [bins²]")
    plot_levels(levels, realism)
    return figure


def plot_curve(ax, curves, name, colour, other=False, **keywords):
    """Median and band of one curve, of the flight or of the real echograms of another band."""
    rows = curves[(curves["curve"] == name) & ((curves["data"] == OTHER_BAND) == other)].sort_values("x")
    ax.fill_between(rows["x"], rows["low"], rows["high"], color=colour, alpha=0.15, linewidth=0)
    ax.plot(rows["x"], rows["value"], color=colour, linewidth=1.2, markersize=3, **keywords)


def plot_standard(ax, curves, name):
    """A curve in standard deviations, the real echograms of another band beside it where given."""
    plot_curve(ax, curves, name, BLACK, label="flight")
    if (curves["data"] == OTHER_BAND).any():
        plot_curve(ax, curves, name, GREY, other=True, label=OTHER_BAND, linestyle="--")
    ax.legend(fontsize=6)


def plot_autocorrelation(ax, curves, table):
    """Autocorrelation by lag along track and down, observed ranges as bars with a cap."""
    for direction, (label, colour) in DIRECTIONS.items():
        name = f"autocorrelation along {direction}"
        plot_curve(ax, curves, name, colour, label=f"{label}, flight")
        observed = table[table["quantity"].str.startswith(f"{name}, lag ")]
        lag = observed["quantity"].str.rsplit(" ", n=1).str[-1].astype(float)
        lag = lag * (1.04 if direction == "range_bin" else 0.96)  # both have a lag 1
        middle = (observed["observed_low"] + observed["observed_high"]) / 2
        reach = (observed["observed_high"] - observed["observed_low"]) / 2
        style = {"fmt": "s", "markersize": 3.5, "capsize": 3, "markerfacecolor": WHITE, "linewidth": 1}
        ax.errorbar(lag, middle, yerr=reach, color=colour, label=f"{label}, observed (other band)", **style)
    ax.set(xscale="log", xlabel="lag [pixels]", ylabel="autocorrelation", ylim=(0, 1))
    ax.legend(fontsize=6, loc="lower left")


def plot_levels(ax, table):
    """Every quantity with an observed value, as a ratio to the middle of the observed range."""
    rows = table[table["observed_low"].notna() & ~table["quantity"].str.contains(", lag |of a frame")].iloc[::-1]
    top = rows["observed_high"].fillna(rows["observed_low"])
    middle = (rows["observed_low"] + top) / 2
    y = range(len(rows))
    reach = [(rows["value"] - rows["low"]) / middle, (rows["high"] - rows["value"]) / middle]
    ax.errorbar(rows["value"] / middle, y, xerr=reach, fmt="o", markersize=3, color=BLACK, linewidth=1)
    ax.hlines(y, rows["observed_low"] / middle, top / middle, color=BLUE, linewidth=5, alpha=0.4)
    ax.axvline(1, color="0.5", linestyle=":", linewidth=1)
    ax.set_yticks(y, rows["quantity"], fontsize=5)
    ax.set(xlabel="value / observed")
