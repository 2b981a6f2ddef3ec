"""What the shipped tracker is trained on: scenes of many climates and radars."""

import dataclasses

import pandas as pd

from lib.phy_renders import render_by_phy
from snowsim.labels import Dress, draw_scene, prepare
from snowsim.labels.clutter import Clutter, bands, with_crusts
from snowsim.seeding import random_stream
from snowsim.statistics import varied


def varied_scenes(flight, variants, n_scenes, *, n_range_lines, phy, seed):
    """`n_scenes` scenes of each of some variants of a flight's statistics, rendered by PHY.

    Variants are numbers; looks and correlation of speckle are theirs, whatever `phy` says. So are
    crusts between layers and bands of coherent noise, which are not labelled.
    """
    phy = phy | {"n_looks": None, "speckle_correlation": "measured"}
    choices, _ = Dress.split(phy)
    for variant in variants:
        statistics = varied(flight, rng=random_stream(seed, "varied", variant))
        model = prepare(statistics, n_range_lines, dress=choices)
        clutter = clutter_of(statistics)
        for number in range(n_scenes):
            name = f"variant_{variant:03d}_{number:03d}"
            # By scene, never by shard: how scenes are divided must not change them.
            rng = random_stream(seed, "varied_scenes", name)
            drawn = draw_scene(model, n_range_lines, name=name, rng=rng)
            echoes = with_crusts(drawn.echoes, clutter, rng=rng)
            shape = (drawn.n_range_bins, n_range_lines)
            coherent = bands(shape, echoes.noise_power, clutter, rng=rng)
            cluttered = dataclasses.replace(drawn, echoes=echoes)
            yield render_by_phy(cluttered, statistics, phy, rng=rng, added_power=coherent)


def clutter_of(statistics):
    """`Clutter` that was drawn with varied statistics."""
    names = [field.name for field in dataclasses.fields(Clutter)]
    return Clutter(**{name: float(statistics.attrs[f"varied_{name}"]) for name in names})


def scores_for_card(paths):
    """Scores of the shipped tracker on unseen flights, a dict each, from a table if it was made."""
    for path in paths:
        table = pd.read_csv(path).query("tracker == 'universal'")
        kept = ["flight", "ods", "recall", "precision", "f", "missed_share", "false_share"]
        return table[kept].round(3).to_dict("records")
    return None
