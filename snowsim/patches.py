"""Network inputs from scenes: random crops, copies of whole scenes, and grey levels as tensors."""

from functools import lru_cache

import numpy as np
import torch
from torch.nn import functional

from snowsim.seeding import random_stream


def check_trainable(scene, *, empty=False):
    """Raise ValueError unless a scene has an image with contrast, and a layer if not `empty`."""
    image = np.empty(0) if scene.image is None else scene.image
    shape = (scene.n_range_bins, scene.n_range_lines)
    is_image = image.shape == shape and image.dtype == np.uint8 and image.min() < image.max()
    if not is_image or not (empty or scene.mask().any()):
        msg = (
            f"scene {scene.name}: expected a uint8 image of shape {shape} with contrast and an "
            f"annotated pixel, got {image.dtype} of shape {image.shape}, "
            f"{scene.mask().sum()} annotated pixels"
        )
        raise ValueError(msg)


def draw_index(n, position, seed, *keys):
    """Number, from 0 to ``n - 1``, of the item at `position` of an endless random sequence.

    Every item appears once, in random order, before any appears again. `keys` name the sequence, as
    for `random_stream`. The result depends on the arguments alone, so a training that resumes at
    some position needs no saved sampler.
    """
    times_through, place = divmod(position, n)
    return int(_order(n, seed, *keys, times_through)[place])


@lru_cache(maxsize=32)
def _order(n, seed, *keys):
    return random_stream(seed, *keys).permutation(n)


def whole_copy(scene, scale, mirrored):
    """Image (uint8) and mask (bool) of a whole scene, resized by `scale`, and mirrored if asked.

    Mirroring swaps left and right. Resizing follows the published tracker code, which uses OpenCV.
    Sizes are truncated. Values are interpolated between the nearest two by two pixels without
    averaging, within a grey level of OpenCV's integers. The mask is true where its resized values
    are above zero. ValueError if `check_trainable` refuses the scene; a scene without layers is
    accepted.
    """
    check_trainable(scene, empty=True)
    both = np.stack([scene.image, np.uint8(255) * scene.mask()])
    if scale != 1:
        size = [int(n * scale) for n in both.shape[1:]]
        values = torch.from_numpy(both)[None].double()
        resized = functional.interpolate(values, size=size, mode="bilinear")[0]
        # Half a grey level is rounded up, even if rounding errors made it a little less.
        both = torch.floor(resized + (0.5 + 1e-6)).to(torch.uint8).numpy()
    image, mask = both[:, :, ::-1] if mirrored else both
    return image, mask > 0


def draw_patches(scenes, n_range_bins=None, n_range_lines=None, *, flip=True, known=None, rng):
    """One random crop of each scene, all of one size and each with at least one annotated pixel.

    Parameters
    ----------
    scenes : sequence of Scene
        ValueError if `check_trainable` refuses one.
    n_range_bins, n_range_lines : int, optional
        Size of the crops, which cannot exceed the smallest scene; by default, the size of that.
    flip : bool
        Mirror each crop left to right with probability 1/2.
    known : callable, optional
        ``known(scene)`` returns a further map of the scene, (range_bin, range_line), which is
        cropped like the mask. It does not use `rng`.
    rng : numpy.random.Generator

    Returns
    -------
    images, masks[, maps] : ndarray of uint8, of bool, of any, (patch, range_bin, range_line)
        `maps` are returned only if `known` is given.
    """
    whole = []
    for scene in scenes:
        check_trainable(scene)
        maps = [scene.image, scene.mask()]
        if known is not None:
            maps.append(known(scene))
        whole.append(maps)
    size = np.min([maps[0].shape for maps in whole], axis=0)
    if n_range_bins is not None:
        size[0] = min(size[0], n_range_bins)
    if n_range_lines is not None:
        size[1] = min(size[1], n_range_lines)
    patches = [_draw_patch(maps, size, flip, rng) for maps in whole]
    return tuple(np.stack(arrays) for arrays in zip(*patches, strict=True))


def _draw_patch(maps, size, flip, rng):
    """One random crop of all maps that holds a random true pixel of the mask, the second map."""
    mask = maps[1]
    annotated = np.flatnonzero(mask)
    pixel = np.unravel_index(annotated[rng.integers(annotated.size)], mask.shape)
    window = []
    for at, length, whole in zip(pixel, size, mask.shape, strict=True):
        earliest = max(0, at - length + 1)
        latest = min(at, whole - length)
        first = int(rng.integers(earliest, latest + 1))
        window.append(slice(first, first + length))
    step = -1 if flip and rng.random() < 0.5 else 1
    return tuple(array[tuple(window)][:, ::step] for array in maps)


def to_signed(array):
    """Images (0 to 255) or masks as float32 (patch, 1, range_bin, range_line) in [-1, 1]."""
    array = np.asarray(array)
    full = 1 if array.dtype == bool else 255
    signed = array.astype(np.float32) * np.float32(2 / full) - np.float32(1)
    return torch.from_numpy(signed)[:, None]


def from_signed(tensor):
    """Images (uint8) of a tensor (patch, 1, range_bin, range_line), the inverse of `to_signed`."""
    grey = torch.round((tensor[:, 0].float() + 1) * 127.5)
    return grey.to(torch.uint8).cpu().numpy()
