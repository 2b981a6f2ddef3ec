"""What the shipped tracker is trained on: scenes of many climates and radars."""

import dataclasses

import numpy as np
import pandas as pd
from scipy.ndimage import gaussian_filter1d

from lib.phy_renders import render_by_phy
from snowsim.echogram import DB_BELOW_NOISE_FLOOR, to_uint8
from snowsim.labels import Dress, draw_scene, prepare
from snowsim.seeding import random_stream
from snowsim.statistics import varied

# Horizontal bands of coherent noise, which are no layers: of this share of scenes.
BANDED_SHARE = 0.5
BAND_SPACING_BINS = (40.0, 250.0)
BAND_NOISE_DB = (-8.0, 5.0)  # mean power over the noise floor
BAND_WIDTH_BINS = (0.7, 4.0)  # standard deviation of a band's shape
BAND_WANDER_BINS = (0.0, 4.0)  # where levelling by the surface bends bands
WANDER_LINES = 30.0


def varied_scenes(flight, variants, n_scenes, *, n_range_lines, phy, seed):
    """`n_scenes` scenes of each of some variants of a flight's statistics, rendered by PHY.

    Variants are numbers; looks and correlation of speckle are theirs, whatever `phy` says. A share
    of the scenes lies under bands of coherent noise.
    """
    phy = phy | {"n_looks": None, "speckle_correlation": "measured"}
    choices, _ = Dress.split(phy)
    for variant in variants:
        statistics = varied(flight, rng=random_stream(seed, "varied", variant))
        model = prepare(statistics, n_range_lines, dress=choices)
        for number in range(n_scenes):
            name = f"variant_{variant:03d}_{number:03d}"
            # By scene, never by shard: how scenes are divided must not change them.
            rng = random_stream(seed, "varied_scenes", name)
            drawn = draw_scene(model, n_range_lines, name=name, rng=rng)
            rendered = render_by_phy(drawn, statistics, phy, rng=rng)
            if rng.uniform() < BANDED_SHARE:
                rendered = banded(rendered, statistics.attrs["n_looks"], rng=rng)
            yield rendered


def banded(scene, n_looks, *, rng):
    """The scene under horizontal bands of coherent noise of `n_looks`, at random rows."""
    n_rows, n_lines = scene.image.shape
    bottom_db = scene.noise_floor_db - DB_BELOW_NOISE_FLOOR
    step_db = (scene.maximum_db - bottom_db) / 255
    power = 10 ** ((bottom_db + step_db * scene.image) / 10)
    n_bands = rng.poisson(n_rows / rng.uniform(*BAND_SPACING_BINS))
    level_db = scene.noise_floor_db + rng.uniform(*BAND_NOISE_DB)
    strength = 10 ** (level_db / 10) * rng.exponential(1, n_bands)
    width = rng.uniform(*BAND_WIDTH_BINS, n_bands)
    centre = rng.uniform(0, n_rows, n_bands)
    wander = gaussian_filter1d(rng.standard_normal(n_lines), WANDER_LINES, mode="nearest")
    wander *= rng.uniform(*BAND_WANDER_BINS) / max(wander.std(), 1e-6)
    row = np.arange(n_rows)[:, None] - wander
    mean = np.zeros(scene.image.shape)
    for band in range(n_bands):
        mean += strength[band] * np.exp(-(((row - centre[band]) / width[band]) ** 2) / 2)
    power += mean * rng.gamma(n_looks, 1 / n_looks, mean.shape)
    image, noise_floor_db, maximum_db = to_uint8(power)
    return dataclasses.replace(
        scene, image=image, noise_floor_db=noise_floor_db, maximum_db=maximum_db
    )


def scores_for_card(paths):
    """Scores of the shipped tracker on unseen flights, a dict each, from a table if it was made."""
    for path in paths:
        table = pd.read_csv(path).query("tracker == 'universal'")
        kept = ["flight", "ods", "recall", "precision", "f", "missed_share", "false_share"]
        return table[kept].round(3).to_dict("records")
    return None
