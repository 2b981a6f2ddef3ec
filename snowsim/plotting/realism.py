"""How real a flight looks: its profile, texture, histogram and visibility with published values."""

# Okabe & Ito (2008), as in the other figures.
BLUE, RED, BLACK = "#0072B2", "#D55E00", "#000000"
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


def _median_and_band(ax, curves, name, colour, **keywords):
    rows = curves[curves["curve"] == name].sort_values("x")
    ax.fill_between(rows["x"], rows["low"], rows["high"], color=colour, alpha=0.15, linewidth=0)
    ax.plot(rows["x"], rows["value"], color=colour, linewidth=1.2, markersize=3, **keywords)
