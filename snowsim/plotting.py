"""Figures: every plot_* draws one table on the axes it is given; colours and sizes are set here alone."""

import matplotlib as mpl
import numpy as np

mpl.use("Agg")

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
    "svg.hashsalt": "snowsim",  # otherwise element names differ from run to run
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
        mpl.rcParams["svg.hashsalt"] = STYLE["svg.hashsalt"]
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


def plot_label_thickness(ax, thickness):
    """Mean thickness of every slab, observed and drawn, a colour a zone."""
    for zone, rows in thickness.groupby("zone"):
        colour = plt.get_cmap("viridis")(zone / 4)
        ax.plot(rows["slab"], rows["observed_mean_bins"], "o", color=colour, markersize=3)
        ax.plot(rows["slab"], rows["drawn_mean_bins"], color=colour, label=f"zone {zone}")
    ax.set(xlabel="slab below the surface", ylabel="mean thickness [range bins]")
    ax.legend(fontsize=7)
