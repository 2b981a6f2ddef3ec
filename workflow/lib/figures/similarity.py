"""Similarity of renders to observed scenes, and the scenes themselves."""

import numpy as np

from lib.figures.style import COLOURS, NAMES
from snowsim.echogram import SURFACE_ROW


def plot_boxes(ax, images, metric):
    """One similarity metric of every method as box plots (Fig. 11)."""
    methods = sorted(images["method"].unique())
    values = [images.loc[images["method"] == method, metric] for method in methods]
    boxes = ax.boxplot([v[np.isfinite(v)] for v in values], tick_labels=[NAMES[m] for m in methods], widths=0.5,
                       flierprops={"marker": ".", "markersize": 4})  # fmt: skip
    for box, median, method in zip(boxes["boxes"], boxes["medians"], methods, strict=True):
        box.set_color(COLOURS[method])
        median.set(color=COLOURS[method], linewidth=2)
    ax.set_ylabel(f"{NAMES[metric]}{' [grey levels]' if metric == 'rmse' else ''}")


def plot_position_error(ax, positions, against):
    """Distance from layers to the peak near them, by classes of their slope or curvature: means over scenes, 95 %."""
    chosen = positions[positions["against"] == against]
    for k, (method, rows) in enumerate(chosen.groupby("method")):
        groups = rows.groupby("shape_class")["mean_abs_error_bins"]
        error = 2 * groups.std() / np.sqrt(groups.count())
        ax.errorbar(groups.mean().index + 0.08 * (k - 1), groups.mean(), error, fmt="o-", color=COLOURS[method],
                    markersize=4, label=NAMES[method])  # fmt: skip
    edges = chosen.drop_duplicates("shape_class").sort_values("shape_class")
    labels = [f"below {high:.2g}" if low == 0 else f"above {low:.2g}" if np.isinf(high) else f"{low:.2g} to {high:.2g}"
              for low, high in zip(edges["shape_low"], edges["shape_high"], strict=True)]  # fmt: skip
    ax.set_xticks(range(len(labels)), labels, fontsize=7)
    unit = "range bins per range line" + ("²" if against == "curvature" else "")
    ax.set(xlabel=f"{against} [{unit}]", ylabel="distance to the peak [range bins]", ylim=(0, None))


def plot_texture(ax, textures, column, label):
    """One measure of texture above and below the surface: every scene a point, the mean a bar."""
    regions, methods = ("above", "below"), [m for m in ("observed", "cgan", "phy") if m in set(textures["method"])]
    for i, region in enumerate(regions):
        for k, method in enumerate(methods):
            rows = textures[(textures["region"] == region) & (textures["method"] == method)]
            values = rows.sort_values("scene")[column].dropna()
            x = i + 0.26 * (k - (len(methods) - 1) / 2)
            spread = np.linspace(-0.08, 0.08, values.size) if values.size > 1 else np.zeros(values.size)
            ax.plot(x + spread, values, ".", color=COLOURS[method], markersize=2.5, alpha=0.5)
            ax.hlines(values.mean(), x - 0.11, x + 0.11, color=COLOURS[method], linewidth=2,
                      label=NAMES[method] if i == 0 else None)  # fmt: skip
    ax.set_xticks(range(len(regions)), [f"{region} the surface" for region in regions])
    ax.set_ylabel(label)


def plot_ssim_depth(ax, ssim_depth):
    """SSIM against range bin, smoothed, the surface marked (Fig. 12)."""
    for method, rows in ssim_depth.groupby("method"):
        ax.plot(rows["range_bin"], rows["ssim"], color=COLOURS[method], alpha=0.25, linewidth=0.7)
        ax.plot(rows["range_bin"], rows["ssim_smooth"], color=COLOURS[method], label=NAMES[method])
    ax.axvline(SURFACE_ROW, color="0.5", linestyle=":", linewidth=1)
    ax.annotate("snow surface", (SURFACE_ROW, 0.98), xycoords=("data", "axes fraction"), fontsize=7, va="top",
                xytext=(4, 0), textcoords="offset points")  # fmt: skip
    ax.set(xlabel="range bin", ylabel="SSIM")
    ax.legend()


def plot_echogram(ax, image, title=None):
    """8-bit echogram, range down, range lines across."""
    # Uninterpolated: vector files then hold the image's own pixels.
    ax.imshow(image, vmin=0, vmax=255, cmap="gray", aspect="auto", interpolation="none")
    ax.set_xlabel("range line")
    if title:
        ax.set_title(title, fontsize=8)


def plot_layers(ax, layer_bins, n_range_bins, title=None):
    """Layers as lines on the frame of their image."""
    ax.plot(np.asarray(layer_bins).T, color="black", linewidth=0.6)
    ax.set(xlim=(-0.5, np.shape(layer_bins)[1] - 0.5), ylim=(n_range_bins - 0.5, -0.5), xlabel="range line")
    if title:
        ax.set_title(title, fontsize=8)
