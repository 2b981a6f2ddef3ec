"""Figures of the similarity of renders to observed scenes: over scenes, and against depth."""

import numpy as np

from evaluation.lib.figures.style import (
    BLACK,
    GUIDE,
    colour_of,
    line_style,
    name_of,
    new_figure,
    new_panel,
)


def similarity_boxplots(images):
    """Box plots of the three metrics of every method."""
    figure, axes = new_figure(1, 3, width=7)
    # Identical images have an infinite PSNR and are left out.
    finite = images[np.isfinite(images["psnr"])]
    by_method = dict(list(finite.groupby("method")))
    names = list(map(name_of, by_method))
    for ax, metric in zip(axes.flat, ("ssim", "psnr", "rmse"), strict=True):
        values = [rows[metric] for rows in by_method.values()]
        ax.boxplot(values, tick_labels=names, widths=0.5, medianprops={"color": BLACK})
        ax.set_ylabel(name_of(metric))
    return figure


def ssim_depth(ssim_depth, scale):
    """SSIM against depth, row by row and smoothed; the surface is marked."""
    figure, ax = new_panel()
    for method, rows in ssim_depth.groupby("method"):
        depth_m = scale.depth_m(rows["range_bin"])
        ax.plot(depth_m, rows["ssim"], color=colour_of(method), alpha=0.25, linewidth=0.7)
        ax.plot(depth_m, rows["ssim_smooth"], **line_style(method))
    ax.axvline(0, label="snow surface", **GUIDE)
    ax.set(xlabel="depth [m]", ylabel="SSIM", title="means over renders of test scenes")
    ax.legend(fontsize=8)
    return figure
