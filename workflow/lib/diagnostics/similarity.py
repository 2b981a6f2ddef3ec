"""Why the similarity of renders is what it is: bounds, what single faults cost, what complete annotation does."""

import dataclasses

import numpy as np
import pandas as pd

from lib.diagnostics.bounds import as_bytes, error_parts, with_other_speckle, without_speckle
from snowsim.metrics.image import similarity

DEPTHS = (("fewer than 6 layers", 0, 6), ("6 to 15 layers", 6, 16), ("16 layers or more", 16, np.inf))


def explain_scene(observed, rendered, n_looks, *, rng):
    """Similarity to one test scene, a row a case: of its bounds, and of renders by method with faults taken away."""
    n_layers = observed.layer_bins.shape[0] - 1
    depth = next(name for name, low, high in DEPTHS if low <= n_layers < high)
    here = {"scenes": "test", "layers": "complete", "depth": depth}
    rows = rows_of(bounds(observed, n_looks, rng), **here, method="bound")
    for method, scene in rendered.items():
        rows += rows_of(without_faults(scene, observed), **here, method=method)
    return rows


def explain_errors(observed, rendered):
    """Mean square errors of renders, by method, taken apart: a row a method."""
    return [{"method": method, **error_parts(scene.image, observed.image)} for method, scene in rendered.items()]


def explain_annotation(scene, renderers):
    """Similarity to a train scene set aside, rendered from the layers picked and, if known, from all there are."""
    rows = []
    for layers, layer_bins in (("as picked", scene.layer_bins), ("complete", scene.complete_layer_bins)):
        if layer_bins is None:
            continue
        annotated = dataclasses.replace(scene, layer_bins=layer_bins)
        for method, render_one in renderers.items():
            found = {"as rendered": similarity(render_one(annotated), scene.image)}
            rows += rows_of(found, scenes="train, set aside", layers=layers, method=method)
    return rows


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
    """A row a case."""
    return [{**columns, "case": case, **numbers} for case, numbers in similarities.items()]


def mean_similarity(rows):
    """Means over scenes of similarity by case, for all depths and for each."""
    table = pd.DataFrame(rows)
    both = pd.concat([table.assign(depth="all"), table.dropna(subset="depth")])
    groups = both.groupby(["scenes", "layers", "method", "case", "depth"], sort=False)
    return groups[["rmse", "psnr", "ssim"]].mean().assign(n_scenes=groups.size()).reset_index()


def mean_errors(rows):
    """Means over scenes of the parts of the error, by method."""
    shares = pd.DataFrame(rows).groupby("method").mean().rename_axis(columns="part").stack()
    return shares.rename("mean_square").reset_index()
