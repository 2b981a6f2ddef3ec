"""Figures: every plot_* draws one table on the axes it is given; colours and sizes are set here alone."""

import matplotlib as mpl
import numpy as np

mpl.use("Agg")
mpl.rcParams["svg.hashsalt"] = "snowsim"  # otherwise names of SVG elements differ from run to run

from matplotlib import pyplot as plt  # noqa: E402 - the backend comes first

from snowsim.echogram import SURFACE_ROW  # noqa: E402

# Okabe & Ito (2008): told apart by colour-blind readers too.
COLOURS = {
    "cgan": "#D55E00",
    "phy": "#0072B2",
    "rd": "#000000",
    "rd_gd": "#D55E00",
    "rd_pd": "#0072B2",
    "rd_pd_gd": "#009E73",
}
NAMES = {
    "cgan": "cGAN",
    "phy": "PHY",
    "rd": "RD",
    "rd_gd": "RD+GD",
    "rd_pd": "RD+PD",
    "rd_pd_gd": "RD+PD+GD",
    "rmse": "RMSE",
    "psnr": "PSNR [dB]",
    "ssim": "SSIM",
    "ods": "ODS",
    "ois": "OIS",
    "ap": "AP",
    "fuse": "fuse",
}
STYLE = {
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "figure.constrained_layout.use": True,
    "legend.frameon": False,
    "image.cmap": "gray",
}


def new_figure(n_rows=1, n_columns=1, width=6.0, height=3.0, **keywords):
    """Figure and axes array (row, column) in the house style; sizes in inches."""
    with plt.style.context(STYLE):
        figure, axes = plt.subplots(n_rows, n_columns, figsize=(width, height), squeeze=False, **keywords)
    return figure, axes


def note_source(figure, source):
    """State what the data are in a corner of the figure: every figure of synthetic data says so."""
    figure.text(0.995, 0.002, source, ha="right", va="bottom", fontsize=6, color="0.4")


def plot_boxes(ax, images, metric):
    """One similarity metric of every method as box plots (Fig. 11)."""
    methods = sorted(images["method"].unique())
    values = [images.loc[images["method"] == method, metric] for method in methods]
    boxes = ax.boxplot([v[np.isfinite(v)] for v in values], tick_labels=[NAMES[m] for m in methods], widths=0.5)
    for box, median, method in zip(boxes["boxes"], boxes["medians"], methods, strict=True):
        box.set_color(COLOURS[method])
        median.set_color(COLOURS[method])
    ax.set_ylabel(NAMES[metric])


def plot_ssim_depth(ax, ssim_depth):
    """SSIM against range bin, smoothed, the surface marked (Fig. 12)."""
    for method, rows in ssim_depth.groupby("method"):
        ax.plot(rows["range_bin"], rows["ssim"], color=COLOURS[method], alpha=0.25, linewidth=0.7)
        ax.plot(rows["range_bin"], rows["ssim_smooth"], color=COLOURS[method], label=NAMES[method])
    ax.axvline(SURFACE_ROW, color="0.5", linestyle=":", linewidth=1)
    ax.annotate("snow surface", (SURFACE_ROW, 0.02), xycoords=("data", "axes fraction"), rotation=90, fontsize=7,
                ha="right", va="bottom")  # fmt: skip
    ax.set(xlabel="range bin", ylabel="SSIM")
    ax.legend()


def plot_echogram(ax, image, title=None):
    """8-bit echogram, range down, range lines across."""
    ax.imshow(image, vmin=0, vmax=255, cmap="gray", aspect="auto", interpolation="nearest")
    ax.set_xlabel("range line")
    if title:
        ax.set_title(title, fontsize=8)


def plot_layers(ax, layer_bins, n_range_bins, title=None):
    """Layers as lines on the frame of their image."""
    ax.plot(np.asarray(layer_bins).T, color="black", linewidth=0.6)
    ax.set(xlim=(-0.5, np.shape(layer_bins)[1] - 0.5), ylim=(n_range_bins - 0.5, -0.5), xlabel="range line")
    if title:
        ax.set_title(title, fontsize=8)


def plot_precision_recall(ax, curves):
    """Precision against recall of the fused output, a line a training set, mean over replicas."""
    for training_set, rows in curves.groupby("training_set", sort=False):
        ax.plot(rows["recall"], rows["precision"], color=COLOURS[training_set], label=NAMES[training_set])
    ax.set(xlabel="recall", ylabel="precision", xlim=(0, 1), ylim=(0, 1))
    ax.legend(loc="lower left")


def plot_scores(ax, intervals, metric):
    """One edge score of the fused output, a point with its 95 % interval a training set."""
    rows = intervals[(intervals["output"] == "fuse") & (intervals["metric"] == metric)]
    for x, row in enumerate(rows.itertuples()):
        ax.plot([x, x], [row.low, row.high], color=COLOURS[row.training_set])
        ax.plot(x, row.mean, "o", color=COLOURS[row.training_set])
    ax.set_xticks(range(len(rows)), [NAMES[name] for name in rows["training_set"]], rotation=30, ha="right")
    ax.set_ylabel(f"{NAMES[metric]} of fuse")


def plot_losses(ax, losses, columns, window=50):
    """Training losses against step as running means over `window` steps."""
    for column in columns:
        smooth = losses[column].rolling(window, min_periods=1).mean()
        ax.plot(losses["step"], smooth, linewidth=1, label=column)
    ax.set(xlabel="step", ylabel="loss")


def plot_picks(ax, layer_bins):
    """Picks as thin lines over an echogram."""
    ax.plot(np.asarray(layer_bins).T, color="#E69F00", linewidth=0.5)


def plot_positions(ax, table):
    """Frames of the flight by longitude and latitude, coloured by the thickness of the first slab (Fig. 4)."""
    ax.plot(table["longitude_deg"], table["latitude_deg"], color="0.7", linewidth=1, zorder=1)
    points = ax.scatter(table["longitude_deg"], table["latitude_deg"], c=table["first_slab_bins"], s=20, zorder=2)
    ax.figure.colorbar(points, label="first slab [range bins]")
    ax.set(xlabel="longitude [deg]", ylabel="latitude [deg]")


def plot_waveform(ax, statistics, layer):
    """Mean waveform about one layer: averaged range lines, the model of all layers, the layer alone (Figs 6 and 7)."""
    rows = statistics.sel(layer=layer) if "layer" in statistics.coords else statistics.isel(layer=layer)
    lag = statistics["lag"]
    noise = float(statistics["noise_power"])
    ax.plot(lag, 10 * np.log10(rows["mean_waveform"]), color="black", label="averaged lines")
    ax.plot(lag, 10 * np.log10(rows["model_waveform"]), color=COLOURS["phy"], linestyle="--", label="all layers")
    ax.plot(lag, 10 * np.log10(rows["layer_waveform"] + noise), color=COLOURS["cgan"], label="this layer and noise")
    ax.set(xlabel=f"range bins below layer {layer}", ylabel="power [dB]")
    ax.legend(fontsize=6)


def plot_layer_powers(ax, statistics):
    """Peak power of each layer above the noise, with two standard errors."""
    power = statistics["peak_power"].values
    error = 2 * statistics["peak_power_standard_error"].values
    low = np.maximum(power - error, 1e-3 * power)
    layer = np.arange(power.size)
    ax.vlines(layer, 10 * np.log10(low), 10 * np.log10(power + error), color="0.6")
    ax.plot(layer, 10 * np.log10(power), "o", color="black", markersize=3)
    ax.axhline(10 * np.log10(float(statistics["noise_power"])), color="0.5", linestyle=":", linewidth=1)
    ax.set(xlabel="layer", ylabel="peak power [dB]")


def plot_track_spectra(ax, statistics):
    """Spectra along track under the picks: complex echoes of a segment where there is one, else detected power."""
    if "doppler_layer_1" in statistics:
        x, names = statistics["doppler_wavenumber"], ("doppler_layer_1", "doppler_layer_mean")
        ax.set_ylabel("Doppler spectrum / mean [dB]")
    else:
        x, names = (
            statistics["wavenumber"][1:],
            ("detected_power_spectrum_layer_1", "detected_power_spectrum_layer_mean"),
        )
        ax.set_ylabel("spectrum of detected power / mean [dB]")
    for name, label, colour in zip(names, ("layer 1", "mean of layers 1-15"), ("0.6", "black"), strict=True):
        if name in statistics:
            density = statistics[name].values[-x.size :]
            ax.plot(x, 10 * np.log10(np.maximum(density, 1e-4)), color=colour, linewidth=0.8, label=label)
    ax.set_xlabel("wavenumber [cycles per range line]" if x.name == "wavenumber" else "wavenumber [cycles per m]")
    ax.legend(fontsize=7)


def plot_looks(ax, statistics):
    """Quantiles of tracked power against those of Gamma(M) (the paper's chi-square)."""
    expected, observed = statistics["gamma_quantile"].values, statistics["tracked_power_quantile"].values
    ax.plot(expected, expected, color="0.6", linewidth=1)
    ax.plot(expected, observed, ".", color="black", markersize=3)
    ax.set(xlabel=f"Gamma quantile, {statistics.attrs['n_looks']:.1f} looks", ylabel="tracked power / group mean")


def plot_layer_counts(ax, layers):
    """Number of scenes by number of layers."""
    ax.bar(layers["n_layers"], layers["n_scenes"], color="0.5")
    ax.axhline(layers["n_scenes"].sum() / len(layers), color="black", linestyle=":", linewidth=1)
    ax.set(xlabel="layers below the surface", ylabel="scenes")


def plot_thickness(ax, moments):
    """Mean thickness relative to slab 0 by slab and zone: flight as points, synthetic as lines."""
    for zone, rows in moments.groupby("zone"):
        colour = plt.get_cmap("viridis")(zone / 4)
        ax.plot(rows["slab"], rows["relative_mean_observed"], "o", color=colour, markersize=2.5)
        ax.plot(rows["slab"], rows["relative_mean_synthetic"], color=colour, label=f"zone {zone}")
    ax.set(xlabel="slab", ylabel="thickness / slab 0")
    ax.legend(fontsize=7)


def plot_spectra(ax, spectra, slab):
    """Power spectral density of one slab's thickness by zone: flight as points, synthetic as lines."""
    for zone, rows in spectra[spectra["slab"] == slab].groupby("zone"):
        colour = plt.get_cmap("viridis")(zone / 4)
        ax.loglog(rows["wavenumber"], rows["observed"], ".", color=colour, markersize=2)
        ax.loglog(rows["wavenumber"], rows["synthetic"], color=colour, linewidth=0.8)
    ax.set(xlabel="wavenumber [cycles per range line]", ylabel=f"PSD of slab {slab} [bins² line]")


def plot_correlation(ax, correlation):
    """Correlation of slabs by separation: flight as points, synthetic as lines, a colour a band of wavenumbers."""
    for band, rows in correlation.groupby("band"):
        colour = "black" if band < 0 else plt.get_cmap("plasma")(band / 5)
        ax.plot(rows["separation"], rows["observed"], "o", color=colour, markersize=2.5)
        ax.plot(rows["separation"], rows["synthetic"], color=colour, label="means" if band < 0 else f"band {band}")
    ax.set(xlabel="slabs apart", ylabel="correlation")
    ax.legend(fontsize=6)
