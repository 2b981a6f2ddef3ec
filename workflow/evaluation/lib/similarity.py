"""Why the similarity of renders is what it is: parts of the error, its bound, cost of faults."""

import dataclasses

import numpy as np
import pandas as pd
from scipy.ndimage import gaussian_filter1d

from snowsim.echogram import DB_BELOW_NOISE_FLOOR
from snowsim.metrics.image import similarity

# Sigma of the mean along track [range lines]; layers move by less than a bin over as many.
SMOOTH_LINES = 6.0
PARTS = (
    "grey level",
    "mean by depth",
    "along track",
    "speckle of the render",
    "speckle observed",
    "speckle in common",
)
DEPTHS = (
    ("fewer than 6 layers", 0, 6),
    ("6 to 15 layers", 6, 16),
    ("16 layers or more", 16, np.inf),
)


def without_speckle(image):
    """Image averaged along track by a Gaussian of `SMOOTH_LINES`, float."""
    return gaussian_filter1d(np.asarray(image, dtype=float), SMOOTH_LINES, axis=1, mode="nearest")


def error_parts(image, reference):
    """Mean square error of an 8-bit image taken apart, by `PARTS` [grey levels squared].

    Parts sum to the error. Of the means, of row means without these, of averages along track
    without both; then what averaging takes from the render, from the observed image and, with its
    sign, what those have in common. Different sizes are refused.
    """
    image = np.asarray(image, dtype=float)
    reference = np.asarray(reference, dtype=float)
    if image.shape != reference.shape:
        msg = f"image and reference must have one size, got {image.shape} and {reference.shape}"
        raise ValueError(msg)
    smooth_image = without_speckle(image)
    smooth_reference = without_speckle(reference)
    smooth = smooth_image - smooth_reference
    by_row = smooth.mean(axis=1, keepdims=True)
    parts = [
        smooth.mean() ** 2,
        np.mean((by_row - smooth.mean()) ** 2),
        np.mean((smooth - by_row) ** 2),
        np.mean((image - smooth_image) ** 2),
        np.mean((reference - smooth_reference) ** 2),
    ]
    parts.append(np.mean((image - reference) ** 2) - sum(parts))
    return dict(zip(PARTS, map(float, parts), strict=True))


def with_other_speckle(image, noise_floor_db, maximum_db, n_looks, *, rng):
    """The observed 8-bit image as it might have come out of the same snow, under new speckle.

    Its similarity to the image is the best of any renderer whose speckle is as strong,
    Gamma(n_looks) by pixel. Mean power is the average along track, where a few per cent of speckle
    stay: the bound is that much too good.
    """
    bottom_db = noise_floor_db - DB_BELOW_NOISE_FLOOR
    grey_per_db = 255 / (maximum_db - bottom_db)
    power_db = np.asarray(image, dtype=float) / grey_per_db + bottom_db
    mean_power = without_speckle(10 ** (power_db / 10))
    redrawn = mean_power * rng.gamma(n_looks, 1 / n_looks, mean_power.shape)
    return as_bytes((10 * np.log10(redrawn) - bottom_db) * grey_per_db)


def as_bytes(grey):
    """Grey levels rounded to 8 bits; those beyond the ends become the ends."""
    return np.clip(np.rint(grey), 0, 255).astype(np.uint8)


def explain_scene(observed, rendered, n_looks, *, rng):
    """Similarity to one test scene, a row a case: of its bounds, and of renders without faults."""
    image = observed.image
    n_layers = observed.layer_bins.shape[0] - 1
    depth = next(name for name, low, high in DEPTHS if low <= n_layers < high)
    here = {"scenes": "test", "layers": "complete", "depth": depth}
    scale = (observed.noise_floor_db, observed.maximum_db)
    redrawn = with_other_speckle(image, *scale, n_looks, rng=rng)
    smooth = as_bytes(without_speckle(image))
    bounds = {
        "mean echo as observed, other speckle": redrawn,
        "mean echo as observed, no speckle": smooth,
    }
    by_method = {"bound": bounds}
    for method, scene in rendered.items():
        by_method[method] = without_faults(scene.image, image)
    rows = []
    for method, cases in by_method.items():
        for case, changed in cases.items():
            row = here | {"method": method, "case": case}
            rows.append(row | similarity(changed, image))
    return rows


def explain_errors(observed, rendered):
    """Mean square errors of renders, by method, taken apart: a row a method."""
    return [
        {"method": method} | error_parts(scene.image, observed.image)
        for method, scene in rendered.items()
    ]


def explain_annotation(scene, renderers):
    """Similarity to a held-out train scene, rendered from the layers picked and from all there are.

    From all only if these are known.
    """
    layer_sets = {"as picked": scene.layer_bins}
    if scene.complete_layer_bins is not None:
        layer_sets["complete"] = scene.complete_layer_bins
    rows = []
    for layers, layer_bins in layer_sets.items():
        annotated = dataclasses.replace(scene, layer_bins=layer_bins)
        here = {"scenes": "train, held out", "layers": layers}
        for method, render_one in renderers.items():
            numbers = similarity(render_one(annotated), scene.image)
            row = here | {"method": method, "case": "as rendered"}
            rows.append(row | numbers)
    return rows


def without_faults(rendered, observed):
    """Images by what of a render was made like the observed image."""
    image = rendered.astype(float)
    truth = observed.astype(float)
    by_row = truth.mean(axis=1, keepdims=True) - image.mean(axis=1, keepdims=True)
    changed = {
        "as rendered": image,
        "its speckle averaged away": without_speckle(image),
        "its grey level that of the scene": image + truth.mean() - image.mean(),
        "its mean by depth that of the scene": image + by_row,
    }
    return {case: as_bytes(grey) for case, grey in changed.items()}


def mean_similarity(rows):
    """Means over scenes of similarity by case, for all depths and for each."""
    table = pd.DataFrame(rows)
    both = pd.concat([table.assign(depth="all"), table.dropna(subset="depth")])
    groups = both.groupby(["scenes", "layers", "method", "case", "depth"], sort=False)
    means = groups[["rmse", "psnr", "ssim"]].mean()
    return means.assign(n_scenes=groups.size()).reset_index()


def mean_errors(rows):
    """Means over scenes of the parts of the error, by method."""
    means = pd.DataFrame(rows).groupby("method").mean()
    by_part = means.rename_axis(columns="part").stack()
    return by_part.rename("mean_square").reset_index()
