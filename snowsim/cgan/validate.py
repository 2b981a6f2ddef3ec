"""Similarity of a generator's renders to scenes it was not trained on, while it is being trained."""

import numpy as np

from snowsim.cgan.render import render
from snowsim.metrics.image import similarity
from snowsim.patches import draw_index
from snowsim.seeding import random_stream


class Collapsed(ValueError):
    """A training that detectors found collapsed."""


def held_out(n_scenes, n_held, *, seed):
    """Which of a number of scenes to train on and which to set aside, two sorted lists of numbers.

    Raises
    ------
    ValueError
        If none would be left to train on.
    """
    if n_held >= n_scenes:
        msg = f"validation sets {n_held} train scenes aside, there are {n_scenes}: none is left to train on"
        raise ValueError(msg)
    held = {draw_index(n_scenes, position, seed, "cgan", "held out") for position in range(n_held)}
    return [number for number in range(n_scenes) if number not in held], sorted(held)


def validate(generator, scenes, *, dropout, statistics, precision, seed):
    """Render scenes and compare them with what was observed.

    Parameters
    ----------
    generator : UNetGenerator
    scenes : sequence of Scene
        With images.
    dropout, statistics, precision
        As for `render`.
    seed : int

    Returns
    -------
    scores : dict of float
        `rmse`, `psnr`, `ssim`: means over the scenes.
    images : list of ndarray of uint8, (range_bin, range_line)
        The renders.
    """
    images = [
        render(
            generator,
            scene.mask(),
            dropout=dropout,
            statistics=statistics,
            precision=precision,
            rng=random_stream(seed, "cgan", "validation", scene.name),
        )
        for scene in scenes
    ]
    scores = [similarity(image, scene.image) for image, scene in zip(images, scenes, strict=True)]
    return {name: float(np.mean([score[name] for score in scores])) for name in ("rmse", "psnr", "ssim")}, images
