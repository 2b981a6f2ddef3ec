"""PHY's renders with a learned correction of their mean power: layers and speckle stay PHY's.

Trained without pairs, on the likeness of corrected renders to observed scenes (Shrivastava et al.
2017, CVPR): picks that lack layers teach it nothing about layers, and the mean absolute correction
keeps those PHY drew.
"""

from dataclasses import dataclass

import numpy as np

from snowsim.cgan.inputs import low_passed, place_map
from snowsim.echogram import DB_BELOW_NOISE_FLOOR, Scene, to_db, to_uint8

MOST = 0.25  # of half the grey range: the largest correction, about 5 dB


@dataclass
class Guide(Scene):
    """A scene as PHY renders it: `power` after looks and, from -1 to 1 on its image's scale, `mean` and `speckle`."""

    power: np.ndarray | None = None
    mean: np.ndarray | None = None
    speckle: np.ndarray | None = None


def guide_of(scene, mean_power, power):
    """`Guide` of a scene from PHY's mean power before looks and its power after them."""
    image, floor_db, maximum_db = to_uint8(power)
    bottom_db, mean_db = floor_db - DB_BELOW_NOISE_FLOOR, to_db(mean_power)
    scale = np.float32(2 / (maximum_db - bottom_db))
    maps = {"mean": (mean_db - bottom_db) * scale - 1, "speckle": (to_db(power) - mean_db) * scale}
    maps = {name: values.astype(np.float32) for name, values in maps.items()}
    maps |= {"image": image, "power": power, "noise_floor_db": floor_db, "maximum_db": maximum_db}
    return Guide(
        scene.name, scene.n_range_bins, scene.layer_bins, zone=scene.zone, notes=scene.notes, **maps
    )


def guide_map(guide, layer_bins, n_range_bins):
    """`place_map`, mean and speckle of a guide, float32 (range_bin, range_line, 5)."""
    maps = np.stack([guide.mean, guide.speckle], axis=2)
    return np.concatenate(
        [place_map(guide, layer_bins, n_range_bins).astype(np.float32), maps], axis=2
    )


def correction(output):
    """Of a generator's output in [-1, 1], (patch, 1, range_bin, range_line): at most `MOST`, and low-passed."""
    return MOST * low_passed(output)


def corrected(guide, output):
    """Image (uint8), noise floor and maximum [dB] of a guide, corrected by a generator's output for it."""
    span_db = guide.maximum_db - guide.noise_floor_db + DB_BELOW_NOISE_FLOOR
    db = correction(output)[0, 0].cpu().numpy() * (span_db / 2)
    return to_uint8(guide.power * 10 ** (db / 10))
