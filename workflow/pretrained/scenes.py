"""What the shipped tracker is trained on: scenes of many climates and radars, and of clean firn."""

import dataclasses
from dataclasses import dataclass

import numpy as np

from lib.phy_renders import render_by_phy
from pretrained.clutter import Clutter, bands, with_crusts
from pretrained.resizing import in_bins
from reference import Settings
from reference.picks import visible_layers
from snowsim.echogram import Kind, Scene, to_uint8
from snowsim.labels import draw_scene, prepare
from snowsim.phy import mean_power_of
from snowsim.seeding import random_stream
from snowsim.snowpack import Climate, Radar, simulate
from snowsim.statistics import Variation, changed, varied

# One in so many variants is the flight itself.
EVERY = 3
# Mean power of a layer, over all other power at its place, from which it is labelled [dB]: the
# layer then raises it by .5 dB. On tuning flights this is better than -6 dB.
SEEN_DB = -9.0
# Labels end where layers rise less than this over the snow above, as the reference's truth does.
VISIBLE_DB = Settings().picks.visible_db


@dataclass(frozen=True)
class FirnRanges:
    """Within which climates and radars of clean firn are drawn, (least, most).

    Attributes
    ----------
    accumulation_m : (float, float)
        Annual mean [m w.e. / yr], log-uniform.
    variability : (float, float)
        Of its logarithm from year to year.
    bandwidth_hz : (float, float)
        Of the radar `snow-2012` otherwise [Hz], log-uniform.
    surface_to_noise_db : (float, float)
        Peak of the mean surface echo over the noise [dB].
    n_looks : (float, float)
        Looks, log-uniform.
    """

    accumulation_m: tuple = (0.1, 0.9)
    variability: tuple = (0.1, 0.4)
    bandwidth_hz: tuple = (2.5e9, 5.15e9)
    surface_to_noise_db: tuple = (18.0, 45.0)
    n_looks: tuple = (4.0, 40.0)

    def draw(self, *, rng, **radar):
        """A `Climate`, and a `Radar` with what is given of it."""
        accumulation_m = _log_uniform(self.accumulation_m, rng=rng)
        climate = Climate(accumulation_m=accumulation_m, variability=rng.uniform(*self.variability))
        drawn = {
            "bandwidth_hz": _log_uniform(self.bandwidth_hz, rng=rng),
            "surface_to_noise_db": rng.uniform(*self.surface_to_noise_db),
            "n_looks": _log_uniform(self.n_looks, rng=rng),
        }
        return climate, Radar.preset("snow-2012", **radar, **drawn)


def _log_uniform(limits, *, rng):
    return float(np.exp(rng.uniform(*np.log(limits))))


def training_scenes(flight, variants, n_scenes, *, n_varied, n_range_lines, phy, seed):
    """`n_scenes` scenes of each of some variants, which are numbers.

    From `n_varied` on they are clean firn, before that `varied_scenes` of a flight's statistics.
    """
    common = {"n_range_lines": n_range_lines, "seed": seed}
    for variant in variants:
        if variant < n_varied:
            yield from varied_scenes(flight, variant, n_scenes, phy=phy, **common)
        else:
            yield from firn_scenes(flight, variant, n_scenes, **common)


def firn_scenes(flight, variant, n_scenes, *, n_range_lines, seed):
    """Scenes of clean firn, each with a climate and a radar of its own, see `FirnRanges`.

    Range bins and the distance of range lines are those of a flight's statistics.
    """
    radar = {"bin_s": flight.attrs["bin_size_s"], "line_spacing_m": flight.attrs["line_spacing_m"]}
    for number in range(n_scenes):
        name = f"variant_{variant:03d}_{number:03d}"
        rng = random_stream(seed, "firn_scenes", name)
        drawn = FirnRanges().draw(rng=rng, **radar)
        yield firn_scene(name, *drawn, n_range_lines=n_range_lines, rng=rng)


def firn_scene(name, climate, radar, *, n_range_lines, rng):
    """What a radar sees of annual layers and nothing else, with the layers that can be seen."""
    echogram, layers = simulate(climate, radar, n_range_lines=n_range_lines, rng=rng)
    power = echogram["Data"].values
    layer_bins = (layers["peak_twtt"].values - float(echogram["twtt"][0])) / radar.bin_s
    own = 10 ** (layers["power_db"].values / 10)
    # Speckle of all range lines: the mean is known to 3 % at four looks.
    seen = seen_layers(own, power, layer_bins)
    image, noise_floor_db, maximum_db = to_uint8(power)
    return Scene(
        name=name,
        n_range_bins=len(image),
        layer_bins=np.where(seen[:, None], layer_bins, np.nan),
        image=image,
        noise_floor_db=noise_floor_db,
        maximum_db=maximum_db,
    )


def varied_scenes(flight, variant, n_scenes, *, n_range_lines, phy, seed):
    """`n_scenes` scenes of a variant of a flight's statistics, by its number, rendered by PHY.

    Looks and correlation of speckle are the variant's, whatever `phy` says. So are crusts between
    layers and bands of coherent noise, which are not labelled, the distance of range lines, and the
    range bins that a scene is drawn in before it is resampled to the flight's. One variant in
    `EVERY` is the flight itself.
    """
    phy = phy | {"n_looks": None}
    if variant % EVERY:
        statistics = varied(flight, rng=random_stream(seed, "varied", variant))
    else:
        statistics = changed(flight, Variation())
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


def on_lines(scene, lines):
    """A drawn scene on some of its range lines, (range_line,)."""
    echoes = scene.echoes
    kept = dataclasses.replace(echoes, bins=echoes.bins[:, lines], power=echoes.power[:, lines])
    layer_bins = scene.layer_bins[:, lines]
    return dataclasses.replace(
        scene, layer_bins=layer_bins, complete_layer_bins=layer_bins, echoes=kept
    )


def labelled(scene):
    """The scene with those layers labelled that can be seen, see `seen_layers`."""
    echoes = scene.echoes
    power = mean_power_of(echoes, scene.n_range_bins) + echoes.noise_power
    own = echoes.power[echoes.kind == Kind.LAYER]
    seen = seen_layers(own, power, scene.layer_bins)
    layer_bins = np.where(seen[:, None], scene.layer_bins, np.nan)
    return dataclasses.replace(scene, layer_bins=layer_bins)


def seen_layers(own, power, layer_bins):
    """Whether layers can be seen, (layer,): they stand out, down to where they fade.

    A layer stands out by `SEEN_DB` above all else at its place: the noise, unpicked snow and the
    tails of other layers. Where the surface's tail is long, a layer within it cannot be seen, and a
    network would learn to pick one in every tail. They end by `VISIBLE_DB`. `own` is the mean power
    of each, (layer, range_line), `power` that of the scene, (range_bin, range_line).
    """
    row = np.rint(layer_bins).astype(int)
    others = power[row, np.arange(row.shape[1])] - own
    seen = own.mean(axis=1) >= 10 ** (SEEN_DB / 10) * others.mean(axis=1)
    seen[len(visible_layers(power, layer_bins, VISIBLE_DB)) :] = False
    seen[0] = True
    return seen


def clutter_of(statistics):
    """`Clutter` that was drawn with varied statistics."""
    names = [field.name for field in dataclasses.fields(Clutter)]
    return Clutter(**{name: float(statistics.attrs[f"varied_{name}"]) for name in names})
