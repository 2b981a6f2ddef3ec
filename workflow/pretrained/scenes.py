"""What the shipped tracker is trained on: scenes of many climates and radars."""

import dataclasses

import numpy as np

from lib.phy_renders import render_by_phy
from pretrained.clutter import Clutter, bands, with_crusts
from pretrained.resizing import in_bins
from snowsim.echoes import Kind
from snowsim.labels import draw_scene, prepare
from snowsim.phy import mean_power
from snowsim.seeding import random_stream
from snowsim.statistics import Variation, changed, varied

# One in so many variants is the flight itself.
EVERY = 5
# Mean power of a layer, over all other power at its place, from which it is labelled [dB]: the
# layer then raises it by .5 dB. On tuning flights this is better than -6 dB.
SEEN_DB = -9.0


def varied_scenes(flight, variants, n_scenes, *, n_range_lines, phy, seed):
    """`n_scenes` scenes of each of some variants of a flight's statistics, rendered by PHY.

    Variants are numbers; looks and correlation of speckle are theirs, whatever `phy` says. So are
    crusts between layers and bands of coherent noise, which are not labelled, the distance of range
    lines, and the range bins that a scene is drawn in before it is resampled to the flight's. One
    variant in `EVERY` is the flight itself.
    """
    phy = phy | {"n_looks": None}
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
            drawn = labelled(on_lines(draw_scene(model, n_drawn, name=name, rng=rng), lines))
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
    kept = dataclasses.replace(echoes, bins=echoes.bins[:, lines], power=echoes.power[:, lines])
    layer_bins = scene.layer_bins[:, lines]
    return dataclasses.replace(
        scene, layer_bins=layer_bins, complete_layer_bins=layer_bins, echoes=kept
    )


def labelled(scene):
    """The scene with those layers labelled that stand above all else at their place, see `SEEN_DB`.

    Else are the noise, unpicked snow and the tails of other layers: where the surface's tail is
    long, a layer within it cannot be seen, and a network would learn to pick one in every tail.
    """
    echoes = scene.echoes
    shapes = (echoes.power, echoes.variance_bins2, echoes.decay_rate)
    power = mean_power(echoes.bins, *shapes, scene.n_range_bins) + echoes.noise_power
    row = np.rint(scene.layer_bins).astype(int)
    own = echoes.power[echoes.kind == Kind.LAYER]
    others = power[row, np.arange(row.shape[1])] - own
    seen = own.mean(axis=1) >= 10 ** (SEEN_DB / 10) * others.mean(axis=1)
    seen[0] = True  # the surface
    layer_bins = np.where(seen[:, None], scene.layer_bins, np.nan)
    return dataclasses.replace(scene, layer_bins=layer_bins)


def clutter_of(statistics):
    """`Clutter` that was drawn with varied statistics."""
    names = [field.name for field in dataclasses.fields(Clutter)]
    return Clutter(**{name: float(statistics.attrs[f"varied_{name}"]) for name in names})
