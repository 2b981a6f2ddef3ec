"""Why the similarity of renders is what it is: bounds, what single faults cost, what complete annotation does."""

import dataclasses

import numpy as np
import pandas as pd
import torch
from job import job, progress
from render_cgan import scene_renderer
from render_phy import render_scene

from lib.diagnostics.bounds import as_bytes, error_parts, with_other_speckle, without_speckle
from snowsim.cgan import held_out
from snowsim.io.files import read_dataset, write_table
from snowsim.io.scenes import SceneSet
from snowsim.metrics.image import similarity
from snowsim.seeding import random_stream

DEPTHS = (("fewer than 6 layers", 0, 6), ("6 to 15 layers", 6, 16), ("16 layers or more", 16, np.inf))


def bounds(observed, n_looks, rng):
    """Similarity to the observed scene of what no renderer can know better."""
    scale = observed.noise_floor_db, observed.maximum_db
    redrawn = with_other_speckle(observed.image, *scale, n_looks, rng=rng)
    return {
        "mean echo as observed, other speckle": similarity(redrawn, observed.image),
        "mean echo as observed, no speckle": similarity(as_bytes(without_speckle(observed.image)), observed.image),
    }


def without_faults(rendered, observed):
    """Similarity to the observed scene of a render, as it is and with single faults taken away."""
    image, truth = rendered.image.astype(float), observed.image.astype(float)
    by_row = truth.mean(axis=1, keepdims=True) - image.mean(axis=1, keepdims=True)
    changed = {
        "as rendered": image,
        "its speckle averaged away": without_speckle(image),
        "its grey level that of the scene": image + truth.mean() - image.mean(),
        "its mean by depth that of the scene": image + by_row,
    }
    return {case: similarity(as_bytes(grey), observed.image) for case, grey in changed.items()}


def rows_of(similarities, **columns):
    return [{**columns, "case": case, **numbers} for case, numbers in similarities.items()]


def compare_annotations(scenes, renderers):
    """Similarity of train scenes that were set aside, from the layers picked and, if known, from all there are."""
    rows = []
    for scene in progress(scenes, "annotation"):
        for layers, layer_bins in (("as picked", scene.layer_bins), ("complete", scene.complete_layer_bins)):
            if layer_bins is None:
                continue
            annotated = dataclasses.replace(scene, layer_bins=layer_bins)
            for method, render_one in renderers.items():
                found = {"as rendered": similarity(render_one(annotated), scene.image)}
                rows += rows_of(found, scenes="train, set aside", layers=layers, method=method)
    return rows


def explain(
    paths_to_observed, paths_to_cgan, paths_to_phy, paths_to_train, path_to_generator, path_to_statistics,
    path_to_bounds, path_to_parts, seed, n_looks, statistics, phy, validation, device,
):  # fmt: skip
    torch.set_num_threads(1)
    rows, parts = [], []
    with SceneSet(paths_to_observed) as test, SceneSet(paths_to_cgan) as cgan, SceneSet(paths_to_phy) as by_phy:
        for observed, *rendered in progress(zip(test, cgan, by_phy, strict=True), "bounds", total=len(test)):
            rng = random_stream(seed, "explain_similarity", observed.name)
            n_layers = observed.layer_bins.shape[0] - 1
            depth = next(name for name, low, high in DEPTHS if low <= n_layers < high)
            here = {"scenes": "test", "layers": "complete", "depth": depth}
            rows += rows_of(bounds(observed, n_looks, rng), **here, method="bound")
            for method, scene in zip(("cgan", "phy"), rendered, strict=True):
                rows += rows_of(without_faults(scene, observed), **here, method=method)
                parts.append({"method": method, **error_parts(scene.image, observed.image)})
    render_by_cgan = scene_renderer(path_to_generator, device, statistics)
    flight = read_dataset(path_to_statistics)
    renderers = {
        "cgan": lambda scene: render_by_cgan(scene, random_stream(seed, "explain_similarity", "cgan", scene.name)),
        "phy": lambda scene: (
            render_scene(scene, flight, phy, random_stream(seed, "explain_similarity", "phy", scene.name)).image
        ),
    }
    with SceneSet(paths_to_train) as train:
        _, numbers = held_out(len(train), validation["n_scenes"], seed=seed)
        rows += compare_annotations([train[number] for number in numbers], renderers)
    by = ["scenes", "layers", "method", "case"]
    table = pd.DataFrame(rows)
    both = pd.concat([table.assign(depth="all"), table.dropna(subset="depth")])
    groups = both.groupby([*by, "depth"], sort=False)
    write_table(path_to_bounds, groups[["rmse", "psnr", "ssim"]].mean().assign(n_scenes=groups.size()).reset_index())
    shares = pd.DataFrame(parts).groupby("method").mean().rename_axis(columns="part").stack().rename("mean_square")
    write_table(path_to_parts, shares.reset_index())


if __name__ == "__main__":
    with job(snakemake):
        given = snakemake.input
        explain(
            given.observed,
            given.cgan,
            given.phy,
            given.train,
            given.generator,
            given.statistics,
            *snakemake.output,
            **snakemake.params,
        )
