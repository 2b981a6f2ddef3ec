"""The trackers: edge scores, what every output shows, and picks."""

import numpy as np

from evaluation.lib.figures.style import (
    BLACK,
    RED,
    dashed_style,
    evenly_spaced,
    name_of,
    new_figure,
    new_panel,
)
from snowsim.constants import OUTPUTS
from snowsim.echogram import MINIMUM_ROWS


def precision_recall(precision_recall):
    """Precision against recall of the fused output, a line a training set, mean over replicas."""
    figure, ax = new_panel(width=4, height=3.5)
    for training_set, rows in precision_recall.groupby("training_set", sort=False):
        ax.plot(rows["recall"], rows["precision"], **dashed_style(training_set))
    ax.set(xlabel="recall", ylabel="precision", xlim=(0, 1), ylim=(0, 1), title="fused output")
    ax.legend(loc="lower left", fontsize=8)
    return figure


def scenes_to_show(scenes):
    """A scene of a median number of layers, and one of the most."""
    places = evenly_spaced([len(scene.layer_bins) for scene in scenes], 3)
    return [scenes[int(place)] for place in places[-2:]]


def side_outputs(scenes, outputs):
    """The image with its layers, then every output on it, a row a scene and a training set.

    `outputs` maps training sets to probabilities of each scene, (output, range_bin, range_line).
    """
    shown = [
        (scene, training_set, of_scenes[number])
        for number, scene in enumerate(scenes)
        for training_set, of_scenes in outputs.items()
    ]
    figure, axes = new_figure(len(shown), 1 + len(OUTPUTS), width=9, height=1.2 * len(shown))
    for row, (scene, training_set, probabilities) in zip(axes, shown, strict=True):
        row[0].imshow(scene.image[:MINIMUM_ROWS], vmin=0, vmax=255)
        bins, lines = np.nonzero(scene.mask()[:MINIMUM_ROWS])
        row[0].plot(lines, bins, ",", color=RED)
        row[0].set_ylabel(f"{name_of(training_set)}\n{scene.name}", fontsize=7)
        for ax, output, probability in zip(row[1:], OUTPUTS, probabilities, strict=True):
            ax.imshow(probability[:MINIMUM_ROWS], vmin=0, vmax=1, cmap="gray_r")
            ax.set_title(name_of(output), fontsize=7)
        for ax in row:
            ax.set(xticks=[], yticks=[])
    return figure


def picks(picks, picks_by_depth, scene, picked, scale):
    """Picks of every training set on a scene; errors of picks; share picked against depth."""
    figure, axes = new_figure(2, len(picked), width=10, height=5.5)
    on_scene, (of_depth, of_thickness, of_layers, of_shares) = axes
    for ax, (training_set, layer_bins) in zip(on_scene, picked.items(), strict=True):
        scale.plot_image(ax, scene.image[:MINIMUM_ROWS])
        bottom_and_top = ax.get_ylim()
        scale.plot_layers(ax, layer_bins)
        title = f"{name_of(training_set)}, {scene.name}"
        ax.set(xlabel="along track [km]", ylim=bottom_and_top, title=title)
    on_scene[0].set_ylabel("depth [m]")
    names = picks["training_set"].map(name_of)
    of_depth.plot(names, 100 * picks["mean_absolute_error_m"], "o", color=BLACK)
    of_depth.set_title("mean error of depth [cm]")
    of_thickness.plot(names, 100 * picks["thickness_mean_absolute_error_m"], "o", color=BLACK)
    of_thickness.set_title("mean error of annual thickness [cm]")
    of_layers.plot(names, picks["n_missed_layers"], "o", color=BLACK, label="missed")
    of_layers.plot(names, picks["n_false_layers"], "x", color=RED, label="false")
    of_layers.set_title("layers missed, and false ones")
    of_layers.legend()
    for ax in (of_depth, of_thickness, of_layers):
        ax.tick_params("x", rotation=30)
        ax.set_ylim(0, None)
    for training_set, rows in picks_by_depth.groupby("training_set", sort=False):
        percent = 100 * rows.groupby("depth_from_bins")["share_found"].mean()
        depth_m = percent.index * scale.bin_m
        of_shares.step(depth_m, percent, where="post", **dashed_style(training_set))
    of_shares.set(xlabel="depth [m]", title="share of layer pixels picked [%]")
    of_shares.legend()
    return figure
