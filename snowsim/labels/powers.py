"""Powers of one scene's echoes: along track, from layer to layer, noise, decay and background."""

import dataclasses
from dataclasses import dataclass

import numpy as np

from snowsim.echoes import Echoes, Kind
from snowsim.echogram import ROWS_BELOW_LAST_LAYER
from snowsim.labels.dress import with_background
from snowsim.labels.flight_values import radar_of, values_by_layer, values_of
from snowsim.labels.undulations import draw_stationary, lags_on_circle

NEPERS = np.log(10) / 10  # per dB
SPREADS = (
    "noise_spread_db",
    "surface_to_noise_spread_db",
    "common_spread_db",
    "layer_spread_db",
    "decay_spread",
    "background_spread_db",
    "further_spacing_bins",
    "further_rise_db",
)
FADING = ("fading_spread_db", "fading_length_lines", "fading_exponent")


@dataclass(frozen=True, eq=False)
class PowerModel:
    """What `add_echoes` draws from, of `snowsim.statistics`; see there for the names."""

    peak_power: np.ndarray  # (layer,)
    variance_bins2: np.ndarray  # (layer,)
    decay_rate: np.ndarray  # (layer,)
    noise_power: float
    fading: np.ndarray  # (surface or buried; spread [dB], length [lines], exponent)
    background_power: np.ndarray  # (fall,)
    fall: np.ndarray  # [bins]
    spread: dict  # by name, see `SPREADS`
    radar: dict  # of all scenes, arguments of `Echoes`


def power_model(statistics):
    """`PowerModel` of flight statistics, ValueError that names what they lack."""
    radar = radar_of(statistics)
    # Statistics of images hold none.
    if "line_gain_spread_db" in statistics:
        radar["line_gain_spread_db"] = values_of(statistics, "line_gain_spread_db", ()).item()
    fading = [values_of(statistics, name, ("interface",)) for name in FADING]
    return PowerModel(
        spread={name: values_of(statistics, name, ()).item() for name in SPREADS},
        peak_power=values_by_layer(statistics, "peak_power"),
        variance_bins2=values_by_layer(statistics, "variance_bins2"),
        decay_rate=values_by_layer(statistics, "decay_rate"),
        noise_power=values_of(statistics, "noise_power", ()).item(),
        fading=np.transpose(fading),
        background_power=values_of(statistics, "background_power", ("fall",)),
        fall=values_of(statistics, "fall", ("fall",)),
        radar=radar,
    )


def add_echoes(scene, model, *, rng):
    """The scene with its `echoes`.

    Power varies in dB about the flight's mean, which each layer keeps: surface and noise; buried
    layers together; each layer; and its fading along track, a Gaussian process of autocorrelation
    ``exp(-(h / l)^p)`` about its mean. Unpicked snow is a background, one row just below the
    surface for each of its e-folding depths, and echoes at random distances below the last layer,
    which rise out of it as in the flight.
    """
    layers = _draw_layers(scene.layer_bins, model, rng=rng)
    # Background of the scene relative to the flight's mean.
    spread_db = model.spread["background_spread_db"]
    strength = _about_mean(spread_db * rng.standard_normal(), spread_db**2)
    echoes = _draw_further(layers, strength, model, rng=rng)
    echoes = with_background(echoes, strength * model.background_power, model.fall)
    return dataclasses.replace(scene, echoes=echoes)


def _draw_layers(layer_bins, model, *, rng):
    """Echoes of layers (layer, range_line) with noise and decay of their scene."""
    spread = model.spread
    n_layers, n_lines = layer_bins.shape
    interface = np.minimum(np.arange(n_layers), 1)
    noise_db = spread["noise_spread_db"]
    surface_db = np.sqrt(max(spread["surface_to_noise_spread_db"] ** 2 - noise_db**2, 0.0))
    common_db = spread["common_spread_db"] * rng.standard_normal()
    block_db = common_db + spread["layer_spread_db"] * rng.standard_normal((n_layers, 1))
    block_db[0] = surface_db * rng.standard_normal()
    block_variance = spread["common_spread_db"] ** 2 + spread["layer_spread_db"] ** 2
    block_variance = np.where(interface[:, None] > 0, block_variance, surface_db**2)
    faded_db, fading_variance = _draw_fading(model, interface, n_lines, rng=rng)
    factor = _about_mean(block_db + faded_db, block_variance + fading_variance)
    noise_factor = _about_mean(noise_db * rng.standard_normal(), noise_db**2)
    decay_factor = float(np.exp(spread["decay_spread"] * rng.standard_normal()))
    # Layers deeper than the flight shows look like its deepest.
    level = np.minimum(np.arange(n_layers), model.peak_power.size - 1)
    return Echoes(
        bins=layer_bins,
        power=model.peak_power[level, None] * factor,
        variance_bins2=model.variance_bins2[level],
        decay_rate=model.decay_rate[level] * decay_factor,
        kind=np.full(n_layers, Kind.LAYER, dtype=np.int8),
        noise_power=float(model.noise_power * noise_factor),
        decay_factor=decay_factor,
        **model.radar,
    )


def _draw_further(layers, strength, model, *, rng):
    """The echoes with further ones below, of the last layer's waveform."""
    surface, deepest = layers.bins[0], layers.bins[-1]
    below = _draw_distances(model.spread["further_spacing_bins"], rng=rng)
    depth = below + (deepest - surface).mean()
    fallen = model.background_power * np.exp(-depth[:, None] / model.fall)
    behind = strength * fallen.sum(axis=1)
    rise = 10 ** (model.spread["further_rise_db"] / 10) - 1
    buried = np.ones(below.size, dtype=int)
    factor = _about_mean(*_draw_fading(model, buried, deepest.size, rng=rng))
    power = rise * (behind + layers.noise_power)[:, None] * factor
    waveform = {
        name: np.append(getattr(layers, name), np.repeat(getattr(layers, name)[-1], below.size))
        for name in ("variance_bins2", "decay_rate")
    }
    return dataclasses.replace(
        layers,
        bins=np.concatenate([layers.bins, deepest + below[:, None]]),
        power=np.concatenate([layers.power, power]),
        kind=np.append(layers.kind, np.full(below.size, Kind.BELOW, dtype=np.int8)),
        **waveform,
    )


def _about_mean(deviation_db, variance_db2):
    """Factors of power with mean 1 for Gaussian deviations in dB of that variance."""
    return np.exp(NEPERS * deviation_db - NEPERS**2 * variance_db2 / 2)


def _draw_distances(spacing, *, rng):
    """Distances below the last layer of further echoes, `spacing` bins apart on average."""
    enough = int(4 * ROWS_BELOW_LAST_LAYER / spacing) + 8
    distances = np.cumsum(1 + rng.exponential(max(spacing - 1, 0.1), enough))
    return distances[distances < ROWS_BELOW_LAST_LAYER]


def _draw_fading(model, interface, n_lines, *, rng):
    """Fading [dB] about their means of layers, surface or buried, (layer, range_line); variance."""
    spread_db, length_lines, exponent = model.fading.T[..., None]
    lag = lags_on_circle(n_lines, length_lines.max())
    shape = np.exp(-((lag / length_lines) ** exponent))
    covariance = (spread_db**2 * shape)[interface]
    series = draw_stationary(covariance, n_lines, rng=rng)
    lines = lag[:n_lines]
    share_of_pairs = np.where(lines > 0, 2, 1) * (n_lines - lines) / n_lines**2
    kept = 1 - shape[:, :n_lines] @ share_of_pairs
    variance = (spread_db[:, 0] ** 2 * kept)[interface]
    return series - series.mean(axis=1, keepdims=True), variance[:, None]
