"""Synthetic labels beside the flight they were drawn from, and label models with fewer parameters."""

import numpy as np
from matplotlib import colormaps

from lib.figures.style import BLACK, COLOURS, name_of, new_figure

SPECTRA = ("white", "power_law", "ar1", "matern")  # of spectra, beside those as tabulated


def label_models(model_selection, model_selection_scenes, model_selection_spectra):
    """BIC above its least by kind of spectrum and number of zones; spectra by law; how far statistics change."""
    figure, axes = new_figure(1, 3, width=10, height=3.4)
    ax, least = axes[0, 0], model_selection["bic"].min()
    for psd, rows in model_selection.groupby("psd", sort=False):
        above = np.maximum(rows["bic"] - least, 10)
        ax.plot(
            rows["n_parameters"], above, "o-", color=COLOURS[psd], markersize=3, label=name_of(psd)
        )
        for row, y in zip(rows.itertuples(), above, strict=True):
            ax.annotate(
                f"{row.n_zones}",
                (row.n_parameters, y),
                xytext=(2, 2),
                textcoords="offset points",
                fontsize=5,
            )
    ax.set(xscale="log", yscale="log", xlabel="parameters", ylabel="BIC above its least")
    ax.legend(fontsize=6)
    # Observed as points, and each law fitted to it.
    ax, rows = axes[0, 1], model_selection_spectra[model_selection_spectra["zone"] == 0]
    ax.loglog(rows["wavenumber"], rows["tabulated"], ".", color=COLOURS["tabulated"], markersize=2)
    for name in SPECTRA:
        ax.loglog(
            rows["wavenumber"], rows[name], color=COLOURS[name], linewidth=0.9, label=name_of(name)
        )
    ax.set(xlabel="wavenumber [cycles per range line]", ylabel="PSD of slab 0, zone 0 [bins² line]")
    ax.legend(fontsize=6)
    # Statistics of scenes by each model against those of the first.
    ax = axes[0, 2]
    columns = [name for name in model_selection_scenes.columns if name.endswith("_bins_change")]
    rows = model_selection_scenes[~model_selection_scenes["model"].isin(("paper", "in use"))]
    for i, row in enumerate(rows.itertuples()):
        label = (
            f"{row.model}: {row.n_zones} zones, {name_of(row.psd)}, {row.n_parameters} parameters"
        )
        at = np.arange(len(columns)) + 0.25 * (i - (len(rows) - 1) / 2)
        ax.plot([100 * getattr(row, name) for name in columns], at, "o", markersize=4, label=label)
    ax.axvline(0, color="0.6", linewidth=0.8)
    names = [name.removesuffix("_bins_change").replace("_", " ") for name in columns]
    ax.set_yticks(range(len(columns)), names, fontsize=6)
    ax.invert_yaxis()
    ax.set(xlabel="change against the paper's model [%]")
    ax.legend(fontsize=5.5, loc="upper center", bbox_to_anchor=(0.35, 1.22))
    return figure


def labels(label_layers, label_moments, label_spectra, label_correlation):
    """Layers a scene, thickness by slab and zone, spectra and correlation of slabs: points flight, lines synthetic."""
    figure, axes = new_figure(2, 2, width=7, height=5)
    axes[0, 0].bar(label_layers["n_layers"], label_layers["n_scenes"], color="0.5")
    axes[0, 0].set(xlabel="layers below the surface", ylabel="scenes")
    ax = axes[0, 1]
    for zone, rows in label_moments.groupby("zone"):
        colour = _zone_colour(zone, label_moments)
        ax.plot(rows["slab"], rows["relative_mean_observed"], "o", color=colour, markersize=2.5)
        ax.plot(rows["slab"], rows["relative_mean_synthetic"], color=colour, label=f"zone {zone}")
    ax.set(xlabel="slab", ylabel="thickness / slab 0")
    ax.legend(fontsize=7)
    plot_spectra(axes[1, 0], label_spectra, slab=0)
    plot_correlation(axes[1, 1], label_correlation)
    return figure


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
        colour = BLACK if band < 0 else colormaps["plasma"](band / 5)
        ax.plot(rows["separation"], rows["observed"], "o", color=colour, markersize=2.5)
        ax.plot(
            rows["separation"],
            rows["synthetic"],
            color=colour,
            label="means" if band < 0 else f"band {band}",
        )
    ax.set(xlabel="slabs apart", ylabel="correlation")
    ax.legend(
        fontsize=6,
        ncols=5,
        handlelength=1,
        columnspacing=1,
        loc="lower center",
        bbox_to_anchor=(0.5, 1),
    )


def _zone_colour(zone, table):
    """Colour of a zone among those of a table; labels may have more zones than the flight."""
    return colormaps["viridis"](zone / max(table["zone"].max() + 1, 4))
