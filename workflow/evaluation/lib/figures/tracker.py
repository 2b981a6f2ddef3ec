"""Figures of the trackers: precision and recall, and picks."""

import numpy as np

from evaluation.lib.figures.style import line_style, name_of, new_figure, new_panel
from snowsim.echogram import MINIMUM_ROWS


def precision_recall(precision_recall):
    """Precision against recall of the fused output, a line for each training set."""
    figure, ax = new_panel(width=4, height=3.5)
    for training_set, rows in precision_recall.groupby("training_set", sort=False):
        ax.plot(rows["recall"], rows["precision"], **line_style(training_set))
    ax.set(xlabel="recall", ylabel="precision", xlim=(0, 1), ylim=(0, 1), title="fused output")
    ax.legend(loc="center left", bbox_to_anchor=(1, 0.5), fontsize=8)
    return figure


def picks(scene, picked, picks_by_depth, scale):
    """Layers of a scene, what every training set's tracker picks, and the share picked by depth.

    Layers are all there are where they are known, else those that are annotated.
    """
    figure, axes = new_figure(1, len(picked) + 2, width=13, height=3.2)
    of_truth, *on_scene, of_shares = axes[0]
    truth = {"truth": scene.complete_layer_bins}
    if scene.complete_layer_bins is None:
        truth = {"annotated": scene.layer_bins}
    layers = truth | picked
    for ax, (name, layer_bins) in zip((of_truth, *on_scene), layers.items(), strict=True):
        scale.plot_image(ax, scene.image[:MINIMUM_ROWS])
        top, bottom = scale.depth_m(np.array([0, MINIMUM_ROWS - 1]))
        scale.plot_layers(ax, layer_bins)
        ax.set(xlabel="along track [km]", title=name_of(name), ylim=(bottom, top))
    of_truth.set_ylabel("depth [m]")
    for training_set, rows in picks_by_depth.groupby("training_set", sort=False):
        percent = 100 * rows.groupby("depth_from_bins")["share_found"].mean()
        depth_m = percent.index * scale.bin_m
        of_shares.step(depth_m, percent, where="post", **line_style(training_set))
    of_shares.set(xlabel="depth [m]", ylabel="true layers picked [%]", title="all test scenes")
    of_shares.legend()
    return figure
