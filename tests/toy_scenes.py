"""Scenes for network tests.

Bright curved layers with decaying tails and speckle, made here from nothing else.
"""

from dataclasses import replace

import numpy as np
from scipy.special import expit

from snowsim.echogram import Echoes, Kind, Scene


def toy_scene(number, n_range_bins=96, n_range_lines=64, n_layers=4):
    """One scene, the same for the same number.

    Wavy layers 3 rows wide over a dim, speckled ground.
    """
    rng = np.random.default_rng(number)
    line = np.arange(n_range_lines)
    height_bins = rng.uniform(2, 5)
    n_waves = rng.uniform(0.5, 1.5)
    phase = line / n_range_lines * n_waves + rng.random()
    wave = height_bins * np.sin(2 * np.pi * phase)
    depths = np.cumsum(rng.uniform(12, 18, n_layers))
    layer_bins = depths[:, None] + wave * np.linspace(0.3, 1, n_layers)[:, None]
    below = np.arange(n_range_bins)[:, None] - layer_bins[:, None, :]
    decay = np.where(below < 0, 4 * below**2, below / 3)
    level = 40 + 140 * np.exp(-decay).max(axis=0)
    image = level * rng.gamma(16, 1 / 16, level.shape)
    return Scene(
        f"toy {number}", n_range_bins, layer_bins, np.minimum(np.rint(image), 255).astype(np.uint8)
    )


def toy_scenes(n):
    """As many scenes."""
    return [toy_scene(number) for number in range(n)]


def logits_at(scene, moved_bins=0.0):
    """Logits of a tracker that sees every layer of a scene so many bins too deep."""
    row = np.arange(scene.n_range_bins)[:, None]
    below = np.abs(row - scene.layer_bins[:, None, :] - moved_bins).min(axis=0)
    return (6 - 4 * below).astype(np.float32)


def with_ridges(scene):
    """The scene with an image of its layers alone: the probability that `logits_at` tells."""
    return replace(scene, image=np.uint8(255 * expit(logits_at(scene))))


def with_echoes(scene):
    """The scene with echoes of its layers: each weaker than the one above, 30 dB over the noise."""
    n_layers = len(scene.layer_bins)
    power = np.repeat(0.5 ** np.arange(n_layers)[:, None], scene.n_range_lines, axis=1)
    echoes = Echoes(
        bins=scene.layer_bins,
        power=power,
        variance_bins2=np.full(n_layers, 2.0),
        decay_rate=np.full(n_layers, 0.3),
        kind=np.full(n_layers, Kind.LAYER, dtype=np.int8),
        noise_power=1e-3,
        n_looks=16,
    )
    return replace(scene, echoes=echoes)
