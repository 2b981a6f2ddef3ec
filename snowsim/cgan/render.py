"""Layer masks to 8-bit echograms with a trained generator, and how near they come to scenes it was not trained on."""

import numpy as np
import torch

from snowsim.cgan.networks import UNetGenerator
from snowsim.echogram import check_choice
from snowsim.metrics.image import similarity
from snowsim.patches import draw_index, from_signed, to_signed
from snowsim.seeding import random_stream
from snowsim.training import arithmetic, load_weights

STATISTICS = ("training", "scene")


def render(generator, mask, *, dropout=0.5, statistics="training", precision="float32", rng):
    """Echogram of one layer mask, the whole scene at once: uint8, of the shape of the mask (range_bin, range_line).

    A scene does not depend on which others are rendered, in what order or by how many processes; any size.

    Parameters
    ----------
    generator : UNetGenerator
    mask : ndarray of bool, (range_bin, range_line)
        ValueError if it holds no layer.
    dropout : float
        As in training: it stays on, as in pix2pix, drawn from `rng`.
    statistics : str
        Normalise by `training`, averages over what was trained on, or by `scene`, those of the image, as pix2pix does:
        they change with the height, so that the same layers in a taller scene are another render.
    precision : str
        Arithmetic, `float32` or `bfloat16`; FloatingPointError if a pixel is not finite.
    rng : numpy.random.Generator
    """
    mask = np.asarray(mask)
    if mask.dtype != bool or mask.ndim != 2:
        msg = f"mask must be bool (range_bin, range_line), got {mask.dtype} of shape {mask.shape}"
        raise ValueError(msg)
    if not mask.any():
        msg = f"mask without layers: expected at least one annotated pixel in {mask.shape}"
        raise ValueError(msg)
    check_choice("statistics", statistics, STATISTICS)
    if statistics == "training" and not generator.is_settled:
        msg = "generator has no statistics of its training to normalise by: they are set by settle_statistics"
        raise ValueError(msg)
    generator.eval()
    device = next(generator.parameters()).device
    noise = generator.draw_noise(1, *mask.shape, dropout=dropout, rng=rng)
    with torch.inference_mode(), arithmetic(device, precision):
        image = generator(to_signed(mask[None]).to(device), noise, own_statistics=statistics == "scene")
        if not torch.isfinite(image).all():
            msg = "generator renders values that are not finite: its training diverged"
            raise FloatingPointError(msg)
        return from_signed(image)[0]


def trained_generator(weights, settings, *, device="cpu"):
    """Generator for `render`, of weights (dict of arrays) and the `Settings` they were trained with."""
    generator = UNetGenerator(settings.width, settings.depth)
    load_weights(generator, weights, "generator")
    return generator.to(device=device, memory_format=torch.channels_last).eval()


class Collapsed(ValueError):
    """A training that detectors found collapsed."""


def held_out(n_scenes, n_held, *, seed):
    """Numbers of the scenes to train on and of those to validate with, two sorted lists; ValueError if none is left."""
    if n_held >= n_scenes:
        msg = f"validation holds {n_held} train scenes out, there are {n_scenes}: none is left to train on"
        raise ValueError(msg)
    held = {draw_index(n_scenes, position, seed, "cgan", "held out") for position in range(n_held)}
    return [number for number in range(n_scenes) if number not in held], sorted(held)


def validate(generator, scenes, *, dropout, statistics, precision, seed):
    """Render observed scenes and compare: means of `rmse`, `psnr`, `ssim` as a dict, and the renders as a list.

    `dropout`, `statistics` and `precision` as for `render`.
    """
    how = {"dropout": dropout, "statistics": statistics, "precision": precision}
    streams = (random_stream(seed, "cgan", "validation", scene.name) for scene in scenes)
    images = [render(generator, s.mask(), **how, rng=rng) for s, rng in zip(scenes, streams, strict=True)]
    scores = [similarity(image, scene.image) for image, scene in zip(images, scenes, strict=True)]
    return {name: float(np.mean([score[name] for score in scores])) for name in ("rmse", "psnr", "ssim")}, images
