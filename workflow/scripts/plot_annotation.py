"""A train scene, its semi-automatic annotation, and every layer there is, for the scene in the middle by share lost."""

import numpy as np
from job import job

from lib.figures.flight import plot_picks
from lib.figures.similarity import plot_echogram
from lib.figures.style import new_figure, note_source, write_figure
from snowsim.io.scenes import SceneSet


def complete_layers(scene):
    """Every layer of a scene; those annotated where no more are known."""
    return scene.layer_bins if scene.complete_layer_bins is None else scene.complete_layer_bins


def annotated_share(scene):
    """Share of a scene's layer pixels below the surface that are annotated; 1 where there are none."""
    whole = np.isfinite(complete_layers(scene)[1:]).sum()
    return np.isfinite(scene.layer_bins[1:]).sum() / whole if whole else 1.0


def plot(paths_to_train, path_to_figure, source):
    with SceneSet(paths_to_train) as scenes:
        shares = [annotated_share(scene) for scene in scenes]
        # Scenes of few layers have little to annotate.
        rich = [i for i, scene in enumerate(scenes) if complete_layers(scene).shape[0] > 6] or range(len(scenes))
        ranked = sorted(rich, key=lambda i: (shares[i], i))
        scene = scenes[ranked[len(ranked) // 2]]
        share = shares[ranked[len(ranked) // 2]]
    whole = scene.complete_layer_bins is not None
    annotated = f"semi-automatic annotation, {100 * share:.0f} %" if whole else "annotation"
    panels = [("echogram", None), (annotated, scene.layer_bins)]
    if whole:
        panels.append(("corrected annotation", scene.complete_layer_bins))
    figure, axes = new_figure(1, len(panels), width=2.5 * len(panels), height=3.4, sharey=True)
    for ax, (title, layer_bins) in zip(axes[0], panels, strict=True):
        plot_echogram(ax, scene.image, title)
        if layer_bins is not None:
            plot_picks(ax, layer_bins)
    axes[0, 0].set_ylabel("range bin")
    note_source(figure, f"{source}, train scene {scene.name}")
    write_figure(path_to_figure, figure)


if __name__ == "__main__":
    with job(snakemake):
        plot(snakemake.input.train, *snakemake.output, **snakemake.params)
