"""Synthetic labels beside the flight they were drawn from, and simpler label models."""

import numpy as np
from matplotlib import colormaps

from evaluation.lib.figures.style import BLACK, COLOURS, name_of, named_style, new_figure

SPECTRA = ("white", "power_law", "ar1", "matern")  # of spectra, beside those as tabulated


def label_models(model_selection, model_selection_scenes, model_selection_spectra):
    """Label models: their information criterion, their spectra, and how far statistics change."""
    figure, axes = new_figure(1, 3, width=10, height=3.4)
    of_criterion, of_spectra, of_changes = axes[0]
    plot_criterion(of_criterion, model_selection)
    plot_laws(of_spectra, model_selection_spectra)
    plot_changes(of_changes, model_selection_scenes)
    return figure


def plot_criterion(ax, models):
    """BIC above its least by number of parameters, numbers of zones beside the points."""
    models = models.assign(above=np.maximum(models["bic"] - models["bic"].min(), 10))
    for psd, rows in models.groupby("psd", sort=False):
        ax.plot("n_parameters", "above", "o-", data=rows, **named_style(psd))
        for row in rows.itertuples():
            at = (row.n_parameters, row.above)
            ax.annotate(row.n_zones, at, xytext=(2, 2), textcoords="offset points", fontsize=5)
    ax.set(xscale="log", yscale="log", xlabel="parameters", ylabel="BIC above its least")
    ax.legend()


def plot_laws(ax, spectra):
    """Observed spectrum of slab 0 as points, and each law fitted to it."""
    rows = spectra.query("zone == 0")
    wavenumber = rows["wavenumber"]
    ax.loglog(wavenumber, rows["tabulated"], ".", color=COLOURS["tabulated"], markersize=2)
    for name in SPECTRA:
        ax.loglog(wavenumber, rows[name], linewidth=0.9, **named_style(name))
    ax.set_xlabel("wavenumber [cycles per range line]")
    ax.set_ylabel("PSD of slab 0, zone 0 [bins² line]")
    ax.legend()


def plot_changes(ax, models):
    """Statistics of scenes by each model against those of the paper's."""
    rows = models[~models["model"].isin(("paper", "in use"))]
    columns = [name for name in models.columns if name.endswith("_bins_change")]
    for i, (_, row) in enumerate(rows.iterrows()):
        options = f"{row['n_zones']} zones, {name_of(row['psd'])}, {row['n_parameters']} parameters"
        at = np.arange(len(columns)) + 0.25 * (i - (len(rows) - 1) / 2)
        percent = 100 * row[columns].astype(float)
        ax.plot(percent, at, "o", markersize=4, label=f"{row['model']}: {options}")
    ax.axvline(0, color="0.6", linewidth=0.8)
    names = [name_of(name.removesuffix("_bins_change")) for name in columns]
    ax.set_yticks(range(len(columns)), names, fontsize=6)
    ax.invert_yaxis()
    ax.set_xlabel("change against the paper's model [%]")
    ax.legend(fontsize=5.5, loc="upper center", bbox_to_anchor=(0.35, 1.22))


def labels(label_layers, label_moments, label_spectra, label_correlation):
    """Layers a scene, thickness, spectra and correlation: points flight, lines synthetic."""
    figure, axes = new_figure(2, 2, width=7, height=5)
    of_layers, of_thickness = axes[0]
    of_layers.bar("n_layers", "n_scenes", data=label_layers, color="0.5")
    of_layers.set(xlabel="layers below the surface", ylabel="scenes")
    for zone, rows in label_moments.groupby("zone"):
        colour = _zone_colour(zone, label_moments)
        slab = rows["slab"]
        of_thickness.plot(slab, rows["relative_mean_observed"], "o", color=colour, markersize=2.5)
        of_thickness.plot(slab, rows["relative_mean_synthetic"], color=colour, label=f"zone {zone}")
    of_thickness.set(xlabel="slab", ylabel="thickness / slab 0")
    of_thickness.legend(fontsize=7)
    plot_spectra(axes[1, 0], label_spectra, slab=0)
    plot_correlation(axes[1, 1], label_correlation)
    return figure


def plot_spectra(ax, spectra, slab):
    """Power spectral density of one slab's thickness by zone: points flight, lines synthetic."""
    for zone, rows in spectra.query("slab == @slab").groupby("zone"):
        colour = _zone_colour(zone, spectra)
        ax.loglog("wavenumber", "observed", ".", data=rows, color=colour, markersize=2)
        ax.loglog("wavenumber", "synthetic", data=rows, color=colour, linewidth=0.8)
    ax.set(xlabel="wavenumber [cycles per range line]", ylabel=f"PSD of slab {slab} [bins² line]")


def plot_correlation(ax, correlation):
    """Correlation of slabs by separation and band: flight as points, synthetic as lines."""
    for band, rows in correlation.groupby("band"):
        colour = BLACK if band < 0 else colormaps["plasma"](band / 5)
        label = "means" if band < 0 else f"band {band}"
        ax.plot(rows["separation"], rows["observed"], "o", color=colour, markersize=2.5)
        ax.plot(rows["separation"], rows["synthetic"], color=colour, label=label)
    ax.set(xlabel="slabs apart", ylabel="correlation")
    narrow = {"handlelength": 1, "columnspacing": 1}
    ax.legend(ncols=5, loc="lower center", bbox_to_anchor=(0.5, 1), **narrow)


def _zone_colour(zone, table):
    """Colour of a zone among those of a table; labels may have more zones than the flight."""
    return colormaps["viridis"](zone / max(table["zone"].max() + 1, 4))
