"""Observed scene, its layers, and both renders of them, for the test scenes at the quartiles of cGAN's SSIM."""

import numpy as np
from job import job

from lib.figures.similarity import plot_echogram, plot_layers
from lib.figures.style import new_figure, note_source, write_figure
from snowsim.io.files import read_table
from snowsim.io.scenes import SceneSet


def choose_scenes(images, n_scenes=3):
    """Names of the scenes at evenly spaced ranks of cGAN's SSIM: neither the best nor the worst."""
    ranked = images[images["method"] == "cgan"].sort_values(["ssim", "scene"])["scene"].to_list()
    return [ranked[round(rank)] for rank in np.linspace(0, len(ranked) - 1, n_scenes + 2)[1:-1]]


def plot(paths_to_observed, paths_to_cgan, paths_to_phy, path_to_images, path_to_figure, source):
    names = choose_scenes(read_table(path_to_images))
    figure, axes = new_figure(len(names), 4, width=8, height=2.6 * len(names))
    for column, (paths, title) in enumerate(
        [(paths_to_observed, "observed"), (None, "layers"), (paths_to_cgan, "cGAN"), (paths_to_phy, "PHY")]
    ):
        with SceneSet(paths or paths_to_observed) as scenes:
            chosen = {scene.name: scene for scene in scenes if scene.name in names}
        for ax, name in zip(axes[:, column], names, strict=True):
            if paths is None:
                plot_layers(ax, chosen[name].layer_bins, chosen[name].n_range_bins, f"{title} of {name}")
            else:
                plot_echogram(ax, chosen[name].image, title)
    for ax in axes[:, 0]:
        ax.set_ylabel("range bin")
    note_source(figure, source)
    write_figure(path_to_figure, figure)


if __name__ == "__main__":
    with job(snakemake):
        plot(
            snakemake.input.observed,
            snakemake.input.cgan,
            snakemake.input.phy,
            snakemake.input.images,
            *snakemake.output,
            **snakemake.params,
        )
