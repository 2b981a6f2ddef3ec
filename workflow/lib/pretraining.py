"""What the shipped tracker is trained on: scenes of many climates and radars."""

import dataclasses

import numpy as np
import pandas as pd

from lib.phy_renders import render_by_phy
from lib.resizing import in_bins
from snowsim.labels import draw_scene, prepare
from snowsim.labels.clutter import Clutter, bands, with_crusts
from snowsim.seeding import random_stream
from snowsim.statistics import Variation, changed, varied

# One in so many variants is the flight itself.
EVERY = 5


def varied_scenes(flight, variants, n_scenes, *, n_range_lines, phy, seed):
    """`n_scenes` scenes of each of some variants of a flight's statistics, rendered by PHY.

    Variants are numbers; looks and correlation of speckle are theirs, whatever `phy` says. So are
    crusts between layers and bands of coherent noise, which are not labelled, the distance of range
    lines, and the range bins that a scene is drawn in before it is resampled to the flight's. One
    variant in `EVERY` is the flight itself.
    """
    for variant in variants:
        statistics = variant_of(flight, variant, rng=random_stream(seed, "varied", variant))
        # Lines farther apart are lines left out.
        spacing = statistics.attrs["varied_line_spacing"]
        lines = (np.arange(n_range_lines) * spacing).astype(int)
        n_drawn = int(lines[-1]) + 1
        model = prepare(statistics, n_drawn)
        clutter = clutter_of(statistics)
        for number in range(n_scenes):
            name = f"variant_{variant:03d}_{number:03d}"
            # By scene, never by shard: how scenes are divided must not change them.
            rng = random_stream(seed, "varied_scenes", name)
            drawn = on_lines(draw_scene(model, n_drawn, name=name, rng=rng), lines)
            echoes = with_crusts(drawn.echoes, clutter, rng=rng)
            shape = (drawn.n_range_bins, n_range_lines)
            coherent = bands(shape, echoes.noise_power, clutter, rng=rng)
            cluttered = dataclasses.replace(drawn, echoes=echoes)
            rendered = render_by_phy(cluttered, statistics, phy, rng=rng, added_power=coherent)
            yield in_bins(rendered, statistics.attrs["varied_bin_size"])


def variant_of(flight, variant, *, rng):
    """Statistics of one variant, by its number."""
    if variant % EVERY:
        return varied(flight, rng=rng)
    return changed(flight, Variation())


def on_lines(scene, lines):
    """A drawn scene on some of its range lines, (range_line,)."""
    echoes = scene.echoes
    texture = echoes.texture
    if texture is not None:
        every = max(1, (lines[-1] - lines[0]) / (len(lines) - 1))
        variance, length_bins, length_lines = texture
        texture = (variance, length_bins, length_lines / every)
    kept = dataclasses.replace(
        echoes, bins=echoes.bins[:, lines], power=echoes.power[:, lines], texture=texture
    )
    complete = scene.complete_layer_bins
    return dataclasses.replace(
        scene,
        layer_bins=scene.layer_bins[:, lines],
        complete_layer_bins=None if complete is None else complete[:, lines],
        echoes=kept,
    )


def clutter_of(statistics):
    """`Clutter` that was drawn with varied statistics."""
    names = [field.name for field in dataclasses.fields(Clutter)]
    return Clutter(**{name: float(statistics.attrs[f"varied_{name}"]) for name in names})


def scores_for_card(paths):
    """Scores of the shipped tracker on unseen flights, a dict each, from a table if it was made."""
    for path in paths:
        table = pd.read_csv(path)
        kept = ["flight", "ods", "recall", "precision", "f", "missed_share", "false_share"]
        return table[kept].round(3).to_dict("records")
    return None
