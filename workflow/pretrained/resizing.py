"""Images and scenes resampled to other numbers of range bins and range lines."""

import dataclasses

import torch
from torch.nn import functional

from snowsim.io.scenes import SceneSet

AS_THEY_ARE = (1, 1)


def resized(image, scale):
    """An image resampled by the factors `scale` (range bins, range lines)."""
    if tuple(scale) == AS_THEY_ARE:
        return image
    size = [round(n * factor) for n, factor in zip(image.shape, scale, strict=True)]
    batch = torch.from_numpy(image)[None, None]
    return functional.interpolate(batch, size=size, mode="bilinear", antialias=True)[0, 0].numpy()


def resized_rows(row, n_rows, n_resized):
    """Rows of an image of `n_rows`, as rows of the image resampled to `n_resized`.

    A whole number is the middle of a pixel.
    """
    return (row + 0.5) * n_resized / n_rows - 0.5


def in_bins(scene, share):
    """An annotated scene resampled to a `share` of its range bins."""
    if share == 1:
        return scene
    image = resized(scene.image, (share, 1))
    n_rows = len(image)
    layer_bins = resized_rows(scene.layer_bins, scene.n_range_bins, n_rows)
    complete = scene.complete_layer_bins
    if complete is not None:
        complete = resized_rows(complete, scene.n_range_bins, n_rows)
    return dataclasses.replace(
        scene,
        image=image,
        n_range_bins=n_rows,
        layer_bins=layer_bins,
        complete_layer_bins=complete,
    )


def scenes_in_bins(paths, shares):
    """Scenes of some files, resampled to a share of their range bins, one share for each file."""
    scenes = []
    for path, share in zip(paths, shares, strict=True):
        with SceneSet([path]) as annotated:
            scenes += [in_bins(scene, share) for scene in annotated]
    return scenes
