"""Figures of the trackers: precision and recall, outputs on a scene, and picks."""

import numpy as np

from evaluation.lib.figures.style import RED, line_style, name_of, new_figure, new_panel
from snowsim.constants import OUTPUTS
from snowsim.echogram import MINIMUM_ROWS


def precision_recall(precision_recall):
    """Precision against recall of the fused output, a line for each training set."""
    figure, ax = new_panel(width=4, height=3.5)
    for training_set, rows in precision_recall.groupby("training_set", sort=False):
        ax.plot(rows["recall"], rows["precision"], **line_style(training_set))
    ax.set(xlabel="recall", ylabel="precision", xlim=(0, 1), ylim=(0, 1), title="fused output")
    ax.legend(loc="lower left", fontsize=8)
    return figure


def side_outputs(scene, outputs):
    """A scene with its layers, and beside it every output, a row for each training set.

    `outputs` maps training sets to probabilities (output, range_bin, range_line).
    """
    size = {"width": 9, "height": 1.2 * len(outputs)}
    figure, axes = new_figure(len(outputs), 1 + len(OUTPUTS), **size)
    bins, lines = np.nonzero(scene.mask()[:MINIMUM_ROWS])
    for row, (training_set, probabilities) in zip(axes, outputs.items(), strict=True):
        of_image, *of_outputs = row
        of_image.imshow(scene.image[:MINIMUM_ROWS], vmin=0, vmax=255)
        of_image.plot(lines, bins, ",", color=RED)
        of_image.set_title(scene.name)
        of_image.set_ylabel(name_of(training_set))
        for ax, output, probability in zip(of_outputs, OUTPUTS, probabilities, strict=True):
            ax.imshow(probability[:MINIMUM_ROWS], vmin=0, vmax=1, cmap="gray_r")
            ax.set_title(name_of(output))
        for ax in row:
            ax.set(xticks=[], yticks=[])
    return figure


def picks(scene, picked, picks_by_depth, scale):
    """Picks of every training set on a scene, and the share of layers' pixels picked by depth."""
    figure, axes = new_figure(1, len(picked) + 1, width=12, height=3.2)
    *on_scene, of_shares = axes[0]
    for ax, (training_set, layer_bins) in zip(on_scene, picked.items(), strict=True):
        scale.plot_layers(ax, layer_bins)
        scale.plot_image(ax, scene.image[:MINIMUM_ROWS])
        ax.set(xlabel="along track [km]", title=f"{name_of(training_set)}, {scene.name}")
    on_scene[0].set_ylabel("depth [m]")
    for training_set, rows in picks_by_depth.groupby("training_set", sort=False):
        percent = 100 * rows.groupby("depth_from_bins")["share_found"].mean()
        depth_m = percent.index * scale.bin_m
        of_shares.step(depth_m, percent, where="post", **line_style(training_set))
    of_shares.set(xlabel="depth [m]", ylabel="pixels picked [%]", title="all test scenes")
    of_shares.legend()
    return figure
