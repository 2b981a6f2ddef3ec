"""A real accumulation-radar echogram and what its texture is."""

from lib.figures.flight import plot_picks

COLOUR_ACROSS, COLOUR_DOWN = "#0072B2", "#D55E00"


def plot_surface(ax, image, surface_bins):
    """Image with its surface."""
    ax.imshow(image, cmap="gray", vmin=0, vmax=255, aspect="auto", interpolation="nearest")
    plot_picks(ax, surface_bins[None])
    ax.set(xlabel="range line", ylabel="range bin")


def plot_fall(ax, table):
    """Mean of the lines averaged about the surface, against depth, over the noise."""
    ax.plot(table["x"], table["value"], color="black", linewidth=0.8)
    ax.axhline(0, color="0.6", linewidth=0.8, linestyle=":")
    ax.set(xlabel="range bins below the surface", ylabel="power over noise [dB]")


def plot_autocorrelation(ax, across, down):
    """Autocorrelation along both axes against lag."""
    for table, label, colour in ((across, "along track", COLOUR_ACROSS), (down, "in range", COLOUR_DOWN)):
        ax.plot(table["x"], table["value"], ".-", color=colour, markersize=3, linewidth=0.8, label=label)
    ax.axhline(0, color="0.6", linewidth=0.8)
    ax.set(xlabel="lag [pixels]", ylabel="autocorrelation")
    ax.legend(fontsize=7)


def plot_ring_spectrum(ax, table):
    """Power spectral density averaged over rings of wavenumber."""
    ax.loglog(table["x"], table["value"], color="black", linewidth=0.8)
    ax.set(xlabel="wavenumber [cycles per pixel]", ylabel="PSD [grey levels² pixels²]")
