"""Radiometry of one scene: powers along track, noise, decay, and which layers to label."""

import dataclasses
from dataclasses import dataclass

import numpy as np
import xarray as xr

from snowsim.echoes import Echoes, Kind
from snowsim.echogram import ROWS_BELOW_LAST_LAYER
from snowsim.labels.dress import Dress, with_background
from snowsim.labels.given import values_by_layer, values_of
from snowsim.phy.power import mean_power
from snowsim.rounding import on_grid, rounded

NEPERS = np.log(10) / 10  # per dB
# Over which the rise of a layer is averaged: four averaged lines, as for the deepest picks.
WINDOW_LINES = 80
STEPS_BETWEEN = 10  # samples from a layer above to a layer, where the valley is sought
LEAST_DENSITY = 1e-12  # of the spectrum of fading, of the largest
POWER_BITS = 16  # binary digits of powers: 7e-5 dB, and as many on any processor
BELOW_BITS = 16  # distances of further echoes are multiples of 2^-16 range bins, as thickness is

SPREADS = (
    "noise_spread_db",
    "surface_to_noise_spread_db",
    "common_spread_db",
    "layer_spread_db",
    "decay_spread",
    "background_spread_db",
    "further_spacing_bins",
    "further_rise_db",
    "end_contrast_db",
)
FADING = ("fading_spread_db", "fading_length_lines", "fading_exponent")
BY_LAYER = ("peak_power", "variance_bins2", "decay_rate")
# What a label model needs of the flight's statistics beside thickness.
NEEDED = (*SPREADS, *FADING, *BY_LAYER, "background_power", "noise_power")


@dataclass(frozen=True, eq=False)
class RadiometryModel:
    """What `add_radiometry` draws from, of `snowsim.statistics`; see there for the names."""

    statistics: xr.Dataset
    dress: Dress
    peak_power: np.ndarray  # (layer,)
    decay_rate: np.ndarray  # (layer,)
    noise_power: float
    fading: np.ndarray  # (surface or buried; spread [dB], length [lines], exponent)
    background_power: np.ndarray  # (fall,)
    fall: np.ndarray  # [bins]
    spread: dict  # by name, see `SPREADS`
    texture: tuple | None
    line_gain_spread_db: float
    missing: str  # names of quantities for which the flight was too short


def radiometry_model(statistics, choices):
    """`RadiometryModel` of flight statistics, ValueError that names what they lack."""
    spread = {name: values_of(statistics, name, ()).item() for name in SPREADS}
    fading = [values_of(statistics, name, ("interface",)) for name in FADING]
    texture = None
    line_gain_spread_db = 0.0
    # Statistics of images hold neither.
    if "texture_variance" in statistics:
        names = ("variance", "length_bins", "length_lines")
        texture = tuple(float(statistics[f"texture_{name}"]) for name in names)
        line_gain_spread_db = float(statistics["line_gain_spread_db"])
    return RadiometryModel(
        statistics=statistics,
        dress=choices,
        peak_power=values_by_layer(statistics, "peak_power"),
        decay_rate=values_by_layer(statistics, "decay_rate"),
        noise_power=values_of(statistics, "noise_power", ()).item(),
        fading=np.array(fading).T,
        background_power=values_of(statistics, "background_power", ("fall",)),
        fall=values_of(statistics, "fall", ("fall",)),
        spread=spread,
        texture=texture,
        line_gain_spread_db=line_gain_spread_db,
        missing=statistics.attrs.get("radiometry_missing", ""),
    )


def add_radiometry(scene, model, *, rng):
    """The scene with its `echoes`, labelled as far down as layers show.

    Power varies in dB about the flight's mean, which each layer keeps: surface and noise; buried
    layers together; each layer; and its fading along track, a Gaussian process of autocorrelation
    ``exp(-(h / l)^p)`` about its mean. Unpicked snow is a background, one row just below the
    surface for each of its e-folding depths, and echoes at random distances below the last label,
    which rise out of it as in the flight. Layers are labelled down to the deepest that shows, see
    `_labelled`; weaker ones between are labelled too, as a reader who follows the years would.
    """
    drawn = _draw_layers(scene.layer_bins, model, rng=rng)
    strength = _draw_strength(model, rng=rng)
    echoes = _draw_further(drawn, strength, model, rng=rng)
    echoes = with_background(echoes, strength * model.background_power, model.fall)
    layer_bins, rise_db = _labelled(scene, echoes, model.spread["end_contrast_db"])
    kind = echoes.kind.copy()
    labelled = np.isfinite(layer_bins).any(axis=1)
    at_layers = np.flatnonzero(kind != Kind.BACKGROUND)[: labelled.size]
    kind[at_layers[labelled]] = Kind.LAYER
    power = rounded(echoes.power, POWER_BITS)
    # As files hold layers: a scene is the same before and after it was written.
    echoes = dataclasses.replace(echoes, kind=kind, bins=_to_float32(echoes.bins), power=power)
    notes = {
        "radiometry_missing": model.missing,
        "n_pixels_unlabelled": int(np.isnan(layer_bins).sum()),
        "median_rise_db": round(float(np.median(rise_db)), 2),
    }
    return dataclasses.replace(
        scene,
        layer_bins=_to_float32(layer_bins),
        complete_layer_bins=echoes.layer_bins(),
        echoes=echoes,
        notes=scene.notes | notes,
    )


def _draw_layers(layer_bins, model, *, rng):
    """Echoes of layers (layer, range_line) with noise and decay of their scene; none labelled."""
    spread = model.spread
    n_layers, n_lines = layer_bins.shape
    noise_db = spread["noise_spread_db"]
    surface_db = np.sqrt(max(spread["surface_to_noise_spread_db"] ** 2 - noise_db**2, 0.0))
    common_db = spread["common_spread_db"] * rng.standard_normal()
    block_db = common_db + spread["layer_spread_db"] * rng.standard_normal((n_layers, 1))
    block_db[0] = surface_db * rng.standard_normal()
    buried_variance = spread["common_spread_db"] ** 2 + spread["layer_spread_db"] ** 2
    block_variance = np.full((n_layers, 1), buried_variance)
    block_variance[0] = surface_db**2
    faded_db, fading_variance = _draw_fading(model, n_layers, n_lines, rng=rng)
    factor = _about_mean(block_db + faded_db, block_variance + fading_variance)
    noise_factor = _about_mean(noise_db * rng.standard_normal(), noise_db**2)
    decay_factor = np.exp(spread["decay_spread"] * rng.standard_normal())
    decay_factor = float(rounded(decay_factor, POWER_BITS))
    # Layers deeper than the flight shows look like its deepest.
    level = np.minimum(np.arange(n_layers), model.peak_power.size - 1)
    variance = model.dress.variance_bins2(model.statistics, int(level[-1]) + 1, rng=rng)
    return Echoes(
        bins=layer_bins,
        power=model.peak_power[level, None] * factor,
        variance_bins2=variance[level],
        decay_rate=model.decay_rate[level] * decay_factor,
        kind=np.full(n_layers, Kind.BELOW, dtype=np.int8),
        noise_power=float(rounded(model.noise_power * noise_factor, POWER_BITS)),
        texture=model.texture,
        line_gain_spread_db=model.line_gain_spread_db,
        decay_factor=decay_factor,
        **model.dress.radar(model.statistics),
    )


def _draw_strength(model, *, rng):
    """Background of a scene relative to the flight's mean."""
    spread_db = model.spread["background_spread_db"]
    return _about_mean(spread_db * rng.standard_normal(), spread_db**2)


def _draw_further(layers, strength, model, *, rng):
    """The echoes with further ones below, of the last layer's waveform."""
    surface = layers.bins[0]
    deepest = layers.bins[-1]
    below = _draw_distances(model.spread["further_spacing_bins"], rng=rng)
    depth = below + (deepest - surface).mean()
    fallen = model.background_power * np.exp(-depth[:, None] / model.fall)
    behind = strength * fallen.sum(axis=1)
    rise = 10 ** (model.spread["further_rise_db"] / 10) - 1
    # The first row of fading is the surface's, which is none of them.
    faded_db, fading_variance = _draw_fading(model, below.size + 1, deepest.size, rng=rng)
    factor = _about_mean(faded_db, fading_variance)[1:]
    power = rise * (behind + layers.noise_power)[:, None] * factor
    return dataclasses.replace(
        layers,
        bins=np.concatenate([layers.bins, deepest + on_grid(below, BELOW_BITS)[:, None]]),
        power=np.concatenate([layers.power, power]),
        variance_bins2=_last_repeated(layers.variance_bins2, below.size),
        decay_rate=_last_repeated(layers.decay_rate, below.size),
        kind=_last_repeated(layers.kind, below.size),
    )


def _last_repeated(values, n):
    """Values with the last one `n` times more."""
    return np.concatenate([values, np.repeat(values[-1:], n)])


def _to_float32(values):
    """Values, float64, as float32 holds them."""
    return values.astype(np.float32).astype(float)


def _about_mean(deviation_db, variance_db2):
    """Factors of power with mean 1 for Gaussian deviations in dB of that variance."""
    return np.exp(NEPERS * deviation_db - NEPERS**2 * variance_db2 / 2)


def _draw_distances(spacing, *, rng):
    """Distances below the last layer of further echoes, `spacing` bins apart on average."""
    enough = int(4 * ROWS_BELOW_LAST_LAYER / spacing) + 8
    distances = np.cumsum(1 + rng.exponential(max(spacing - 1, 0.1), enough))
    return distances[distances < ROWS_BELOW_LAST_LAYER]


def _draw_fading(model, n_layers, n_lines, *, rng):
    """Fading [dB] of layers about their means, (layer, range_line), and its variance."""
    spread_db, length_lines, _ = model.fading.T
    n_long = 2 * max(n_lines, int(4 * length_lines.max()))
    lag = np.minimum(np.arange(n_long), n_long - np.arange(n_long))
    shapes = [np.exp(-((lag / length) ** exponent)) for _, length, exponent in model.fading]
    # The kernel is wrapped around a long circle: negative parts of its spectrum are negligible, and
    # the root of what is rounding is not the same on all processors.
    density = np.fft.fft(shapes).real
    density = np.where(density > LEAST_DENSITY * density.max(), density, 0)
    interface = np.minimum(np.arange(n_layers), 1)
    white = np.fft.fft(rng.standard_normal((n_layers, n_long)))
    unit = np.fft.ifft(white * np.sqrt(density[interface])).real[:, :n_lines]
    series = unit * spread_db[interface, None]
    lines = np.arange(n_lines)
    n_pairs = np.where(lines > 0, 2, 1) * (n_lines - lines)
    share_of_pairs = n_pairs / n_lines**2
    kept = np.array([1 - (share_of_pairs * shape[:n_lines]).sum() for shape in shapes])
    variance = spread_db[interface] ** 2 * kept[interface]
    return series - series.mean(axis=1, keepdims=True), variance[:, None]


def _labelled(scene, echoes, end_contrast_db):
    """Layers, NaN below the deepest that shows, and the rise of buried ones [dB].

    A layer shows if in half or more of its lines its mean power, averaged along it over
    `WINDOW_LINES`, rises over the minimum between it and the layer above by `end_contrast_db`.
    """
    layer_bins = scene.layer_bins.copy()
    n_layers, n_lines = layer_bins.shape
    if n_layers == 1:
        return layer_bins, np.zeros((1, n_lines))
    power = mean_power(
        echoes.bins,
        echoes.power,
        echoes.variance_bins2,
        echoes.decay_rate,
        scene.n_range_bins,
    )
    power += echoes.noise_power
    rise_db = _rise_db(power, layer_bins)
    n_rising = (rise_db >= end_contrast_db).sum(axis=1)
    shows = np.flatnonzero(2 * n_rising >= n_lines)
    deepest = 1 + shows[-1] if shows.size else 0
    layer_bins[deepest + 1 :] = np.nan
    return layer_bins, rise_db


def _rise_db(power, layer_bins):
    """Rise of averaged power at buried layers over the valley above [dB], (slab, range_line)."""
    n_lines = layer_bins.shape[1]
    lines = np.arange(n_lines)
    step = np.arange(1, STEPS_BETWEEN + 1) / STEPS_BETWEEN
    thickness = np.diff(layer_bins, axis=0)
    rows = layer_bins[:-1, None] + step[:, None] * thickness[:, None]  # (slab, step, line)
    above = np.clip(np.floor(rows).astype(int), 0, power.shape[0] - 2)
    share = rows - above
    sampled = (1 - share) * power[above, lines] + share * power[above + 1, lines]
    n_windows = max(n_lines // WINDOW_LINES, 1)
    edges = np.linspace(0, n_lines, n_windows + 1).astype(int)
    profile = np.add.reduceat(sampled, edges[:-1], axis=2) / np.diff(edges)
    rise_db = 10 * np.log10(profile[:, -1] / profile.min(axis=1))
    centres = (edges[:-1] + edges[1:] - 1) / 2
    return np.array([np.interp(lines, centres, row) for row in rise_db])
