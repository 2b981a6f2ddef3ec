"""Synthetic labels beside the flight they were drawn from."""

from matplotlib import colormaps


def plot_layer_counts(ax, layers):
    """Number of scenes by number of layers."""
    ax.bar(layers["n_layers"], layers["n_scenes"], color="0.5")
    ax.axhline(layers["n_scenes"].sum() / len(layers), color="black", linestyle=":", linewidth=1)
    ax.set(xlabel="layers below the surface", ylabel="scenes")


def plot_thickness(ax, moments):
    """Mean thickness relative to slab 0 by slab and zone: flight as points, synthetic as lines."""
    for zone, rows in moments.groupby("zone"):
        colour = colormaps["viridis"](zone / 4)
        ax.plot(rows["slab"], rows["relative_mean_observed"], "o", color=colour, markersize=2.5)
        ax.plot(rows["slab"], rows["relative_mean_synthetic"], color=colour, label=f"zone {zone}")
    ax.set(xlabel="slab", ylabel="thickness / slab 0")
    ax.legend(fontsize=7)


def plot_spectra(ax, spectra, slab):
    """Power spectral density of one slab's thickness by zone: flight as points, synthetic as lines."""
    for zone, rows in spectra[spectra["slab"] == slab].groupby("zone"):
        colour = colormaps["viridis"](zone / 4)
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
    ax.legend(fontsize=6)
