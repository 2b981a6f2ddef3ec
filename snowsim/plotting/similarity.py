"""Similarity of renders to observed scenes, and the scenes themselves."""

import numpy as np

from snowsim.echogram import SURFACE_ROW
from snowsim.plotting.style import COLOURS, NAMES


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
