"""How real a flight looks: its profile, texture, histogram, visibility and thickness, with observed values."""

# Okabe & Ito (2008), as in the other figures.
BLUE, RED, BLACK, GREY = "#0072B2", "#D55E00", "#000000", "#999999"
OTHER_BAND = "observed, other band"  # what the table of curves calls real accumulation-radar echograms
DIRECTIONS = {"range_line": ("along track", BLUE), "range_bin": ("down", RED)}


def plot_profile(ax, curves):
    """Mean power by row below the surface over the noise."""
    _median_and_band(ax, curves, "row profile", BLACK)
    ax.axvline(0, color="0.5", linestyle=":", linewidth=1)
    ax.set(xlabel="range bins below the surface", ylabel="mean power / noise [dB]")


def plot_autocorrelation(ax, curves, table):
    """Autocorrelation by lag along track and down, observed ranges as bars with a cap."""
    for direction, (label, colour) in DIRECTIONS.items():
        name = f"autocorrelation along {direction}"
        _median_and_band(ax, curves, name, colour, label=f"{label}, flight")
        observed = table[table["quantity"].str.startswith(f"{name}, lag ")]
        lag = observed["quantity"].str.rsplit(" ", n=1).str[-1].astype(float)
        lag = lag * (1.04 if direction == "range_bin" else 0.96)  # both have a lag 1
        middle = (observed["observed_low"] + observed["observed_high"]) / 2
        reach = (observed["observed_high"] - observed["observed_low"]) / 2
        ax.errorbar(
            lag, middle, yerr=reach, fmt="s", markersize=3.5, capsize=3, color=colour, markerfacecolor="white",
            linewidth=1, label=f"{label}, observed (other band)",
        )  # fmt: skip
    ax.set(xscale="log", xlabel="lag [pixels]", ylabel="autocorrelation", ylim=(0, 1))
    ax.legend(frameon=False, fontsize=6, loc="lower left")


def plot_histogram(ax, curves):
    """Density of decibels in the snow."""
    _median_and_band(ax, curves, "histogram", BLACK)
    ax.set(xlabel="power / noise [dB]", ylabel="density [1/dB]", ylim=(0, None))


def plot_visibility(ax, curves):
    """Rise of layers over the snow around by depth: median, and the band of all layers of all blocks."""
    _median_and_band(ax, curves, "visibility", BLACK, marker="o")
    ax.axhline(0, color="0.5", linestyle=":", linewidth=1)
    ax.set(xlabel="range bins below the surface", ylabel="rise over the snow around [dB]")


def plot_standard_histogram(ax, curves):
    """Histogram in standard deviations from the mean, the real echograms of another band beside it where given."""
    _median_and_band(ax, curves, "standard histogram", BLACK, label="flight")
    if (curves["data"] == OTHER_BAND).any():
        _median_and_band(ax, curves, "standard histogram", GREY, data=OTHER_BAND, label=OTHER_BAND, linestyle="--")
    ax.set(xlabel="decibels less their mean [s.d.]", ylabel="density", ylim=(0, None))
    ax.legend(frameon=False, fontsize=6)


def plot_standard_profile(ax, curves):
    """Mean of every snow row in standard deviations of all, beside the real echograms of another band where given."""
    _median_and_band(ax, curves, "standard profile", BLACK, label="flight")
    if (curves["data"] == OTHER_BAND).any():
        _median_and_band(ax, curves, "standard profile", GREY, data=OTHER_BAND, label=OTHER_BAND, linestyle="--")
    ax.set(xlabel="row of the snow", ylabel="mean of the row [s.d.]")
    ax.legend(frameon=False, fontsize=6)


def plot_thickness_spectrum(ax, curves):
    """Power spectral density of the thickness of the first slab: median and band of the accumulation zones."""
    _median_and_band(ax, curves, "thickness PSD", BLACK)
    ax.set(xscale="log", yscale="log", xlabel="wavenumber [cycles per range line]", ylabel="thickness PSD [bins²]")


def _median_and_band(ax, curves, name, colour, data=None, **keywords):
    chosen = curves["data"] == data if data else curves["data"] != OTHER_BAND
    rows = curves[(curves["curve"] == name) & chosen].sort_values("x")
    ax.fill_between(rows["x"], rows["low"], rows["high"], color=colour, alpha=0.15, linewidth=0)
    ax.plot(rows["x"], rows["value"], color=colour, linewidth=1.2, markersize=3, **keywords)


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
