"""Scenes as network inputs.

Full-resolution crops, flips, scaled copies, and 8-bit values as tensors.
"""

from functools import lru_cache

import numpy as np
import torch
from torch.nn import functional

from snowsim.echogram import layer_mask
from snowsim.seeding import random_stream


def check_trainable(scene, *, empty=False):
    """ValueError unless an image has contrast, fits its layers and shows one, or is `empty`."""
    image = np.empty(0) if scene.image is None else scene.image
    shape = (scene.n_range_bins, scene.n_range_lines)
    is_image = image.shape == shape and image.dtype == np.uint8 and image.min() < image.max()
    if not is_image or not (empty or scene.mask().any()):
        msg = f"scene {scene.name}: expected a uint8 image of shape {shape} with contrast and an "
        msg += f"annotated pixel, got {image.dtype} of shape {image.shape}, "
        msg += f"{scene.mask().sum()} annotated pixels"
        raise ValueError(msg)


def draw_index(n, position, seed, *keys):
    """Which of `n` items the draw at `position` gives.

    Every one once, in random order, before any comes again.

    `keys` say what is drawn, as for `random_stream`. A function of its arguments alone: a training
    that resumes at a position needs no saved sampler.
    """
    times_through, place = divmod(position, n)
    return int(_order(n, seed, *keys, times_through)[place])


@lru_cache(maxsize=32)
def _order(n, seed, *keys):
    return random_stream(seed, *keys).permutation(n)


def scaled(image, layer_bins, scale):
    """A scene at another size, its layers still one pixel thick.

    The image is averaged down, layers are moved as curves: a mask resized like an image loses or
    thickens them.

    Parameters
    ----------
    image : ndarray of uint8, (range_bin, range_line)
    layer_bins : ndarray, (layer, range_line)
        Fractional range bins; NaN where absent.
    scale : float
        0.5 halves both sides; at most 1.

    Returns
    -------
    image : ndarray of uint8, (range_bin, range_line)
    layer_bins : ndarray, (layer, range_line)
        NaN where one of the two range lines a value lies between has none.
    """
    if scale == 1:
        return image, layer_bins
    size = tuple(max(1, round(n * scale)) for n in image.shape)
    n_range_bins, n_range_lines = size
    tensor = torch.from_numpy(np.ascontiguousarray(image))[None, None]
    smaller = functional.interpolate(tensor, size=size, mode="bilinear", antialias=True)
    # Pixel centres: bin b of n lies at (b + 1/2) / n of the height, whatever n is.
    line = (np.arange(n_range_lines) + 0.5) * (image.shape[1] / n_range_lines) - 0.5
    left = np.floor(line).astype(int)
    right = np.minimum(left + 1, image.shape[1] - 1)
    weight = line - left
    at_line = (1 - weight) * layer_bins[:, left] + weight * layer_bins[:, right]
    bins = (at_line + 0.5) * (n_range_bins / image.shape[0]) - 0.5
    return smaller[0, 0].numpy(), bins


def whole_copy(scene, scale, mirrored):
    """Image (uint8) and mask (bool) of a whole scene, resized alike or turned left to right.

    As the published tracker code does it with OpenCV: sizes are truncated, values interpolated
    between the nearest two by two pixels without averaging (within a grey level of OpenCV's
    integers), masks too, and on where above zero. ValueError unless `check_trainable` passes the
    scene, with or without layers.
    """
    check_trainable(scene, empty=True)
    both = np.stack([scene.image, np.uint8(255) * scene.mask()])
    if scale != 1:
        size = [int(n * scale) for n in both.shape[1:]]
        values = torch.from_numpy(both)[None].double()
        resized = functional.interpolate(values, size=size, mode="bilinear")[0]
        # Half a level goes up, however it was rounded.
        both = torch.floor(resized + (0.5 + 1e-6)).to(torch.uint8).numpy()
    image, mask = both[:, :, ::-1] if mirrored else both
    return image, mask > 0


def draw_patches(
    scenes, n_range_bins=None, n_range_lines=None, *, scale=1.0, flip=True, known=None, rng
):
    """One random crop of each scene, all of one size, each holding at least one annotated pixel.

    Parameters
    ----------
    scenes : sequence of Scene
        ValueError unless `check_trainable` passes them.
    n_range_bins, n_range_lines : int, optional
        Size of the crops; the smallest scene bounds it, and so does None.
    scale : float
        Size of the scenes before they are cut, in (0, 1].
    flip : bool
        Turn left and right about with probability 1/2, scene by scene.
    known : callable, optional
        ``known(scene, layer_bins, n_range_bins)``, layers as scaled, gives a map of bool
        (range_bin, range_line) to be cut like the mask. It consumes nothing of `rng`.
    rng : numpy.random.Generator

    Returns
    -------
    images, masks[, known] : ndarray of uint8, of bool, of bool, (patch, range_bin, range_line)
        The third if `known` was given.
    """
    whole = []
    for scene in scenes:
        check_trainable(scene)
        image, layer_bins = scaled(scene.image, scene.layer_bins, scale)
        mask = layer_mask(layer_bins, image.shape[0])
        maps = [image, mask]
        if known is not None:
            maps.append(known(scene, layer_bins, image.shape[0]))
        whole.append(maps)
    size = np.min([maps[0].shape for maps in whole], axis=0)
    if n_range_bins is not None:
        size[0] = min(size[0], n_range_bins)
    if n_range_lines is not None:
        size[1] = min(size[1], n_range_lines)
    patches = [_draw_patch(maps, size, flip, rng) for maps in whole]
    return tuple(np.stack(arrays) for arrays in zip(*patches, strict=True))


def _draw_patch(maps, size, flip, rng):
    """Cut a window out of image, mask and so on, around a drawn pixel of the mask."""
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
    """Float32 (patch, 1, range_bin, range_line) in [-1, 1] of images (0 to 255) or masks."""
    array = np.asarray(array)
    full = 1 if array.dtype == bool else 255
    signed = array.astype(np.float32) * np.float32(2 / full) - np.float32(1)
    return torch.from_numpy(signed)[:, None]


def from_signed(tensor):
    """Images of uint8 of a tensor in [-1, 1], (patch, 1, range_bin, range_line).

    The inverse of `to_signed`.
    """
    grey = torch.round((tensor[:, 0].float() + 1) * 127.5)
    return grey.to(torch.uint8).cpu().numpy()
