"""Synthetic layers and both renders of them, for scenes of few, some and many layers."""

from itertools import islice

import numpy as np
from job import job

from lib.figures.similarity import plot_echogram, plot_layers
from lib.figures.style import new_figure, note_source, write_figure
from snowsim.io.scenes import SceneSet


def plot(paths_to_labels, paths_to_phy, paths_to_cgan, path_to_figure, source, n_labels, n_scenes=3):
    with SceneSet(paths_to_labels) as labels, SceneSet(paths_to_phy) as phy, SceneSet(paths_to_cgan) as cgan:
        order = np.argsort([scene.layer_bins.shape[0] for scene in islice(labels, n_labels)], kind="stable")
        chosen = np.unique(np.rint(np.linspace(0, order.size - 1, n_scenes)).astype(int))
        figure, axes = new_figure(chosen.size, 3, width=6.5, height=2.5 * chosen.size)
        for row, i in zip(axes, order[chosen], strict=True):
            scene = labels[int(i)]
            plot_layers(row[0], scene.layer_bins, scene.n_range_bins, f"{scene.layer_bins.shape[0] - 1} layers drawn")
            plot_echogram(row[1], phy[int(i)].image, "PHY")
            plot_echogram(row[2], cgan[int(i)].image, "cGAN")
            row[0].set_ylabel("range bin")
    note_source(figure, f"synthetic layers from the statistics of: {source}")
    write_figure(path_to_figure, figure)


if __name__ == "__main__":
    with job(snakemake):
        plot(snakemake.input.labels, snakemake.input.phy, snakemake.input.cgan, *snakemake.output, **snakemake.params)
