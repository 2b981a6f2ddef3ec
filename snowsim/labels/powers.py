"""Powers of one scene's echoes: along track, from layer to layer, noise, decay and background."""

import dataclasses
from dataclasses import dataclass

import numpy as np
import xarray as xr

from snowsim.echogram import ROWS_BELOW_LAST_LAYER, Kind
from snowsim.labels.dressing import background_below, dress, values_of
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

    statistics: xr.Dataset
    spread: dict  # by name, see `SPREADS`
    fading: np.ndarray  # (surface or buried; spread [dB], length [lines], exponent)
    line_gain_spread_db: float


def power_model(statistics):
    """`PowerModel` of flight statistics, ValueError that names what they lack."""
    dress(np.zeros((1, 1)), statistics)  # refuses what every scene would
    line_gain_spread_db = 0.0
    # Statistics of images hold none.
    if "line_gain_spread_db" in statistics:
        line_gain_spread_db = values_of(statistics, "line_gain_spread_db", ()).item()
    fading = [values_of(statistics, name, ("interface",)) for name in FADING]
    return PowerModel(
        statistics=statistics,
        spread={name: values_of(statistics, name, ()).item() for name in SPREADS},
        fading=np.transpose(fading),
        line_gain_spread_db=line_gain_spread_db,
    )


def add_echoes(scene, model, *, rng):
    """The scene with its `echoes`.

    Power varies in dB about the flight's mean, which each layer keeps: surface and noise; buried
    layers together; each layer; and its fading along track, a Gaussian process of autocorrelation
    ``exp(-(h / l)^p)`` about its mean. Unpicked snow is a background, one row just below the
    surface for each of its e-folding depths, and echoes at random distances below the last layer,
    which rise out of it as in the flight.
    """
    spread = model.spread
    flight = dress(scene.layer_bins, model.statistics)
    is_layer = flight.kind == Kind.LAYER
    noise_db = spread["noise_spread_db"]
    background_db = spread["background_spread_db"]
    factor = np.empty(flight.power.shape)
    factor[is_layer] = _layer_factors(scene.layer_bins.shape, model, rng=rng)
    noise_factor = _about_mean(noise_db * rng.standard_normal(), noise_db**2)
    decay_factor = float(np.exp(spread["decay_spread"] * rng.standard_normal()))
    factor[~is_layer] = _about_mean(background_db * rng.standard_normal(), background_db**2)
    echoes = dataclasses.replace(
        flight,
        power=flight.power * factor,
        decay_rate=flight.decay_rate * np.where(is_layer, decay_factor, 1.0),
        noise_power=float(flight.noise_power * noise_factor),
        line_gain_spread_db=model.line_gain_spread_db,
        decay_factor=decay_factor,
    )
    return dataclasses.replace(scene, echoes=_with_further(echoes, model, rng=rng))


def _layer_factors(shape, model, *, rng):
    """Powers of layers over the flight's, (layer, range_line)."""
    spread = model.spread
    n_layers, n_lines = shape
    interface = np.minimum(np.arange(n_layers), 1)
    surface_variance = spread["surface_to_noise_spread_db"] ** 2 - spread["noise_spread_db"] ** 2
    surface_db = np.sqrt(max(surface_variance, 0.0))
    block_db = spread["common_spread_db"] * rng.standard_normal()
    block_db = block_db + spread["layer_spread_db"] * rng.standard_normal((n_layers, 1))
    block_db[0] = surface_db * rng.standard_normal()
    variance = spread["common_spread_db"] ** 2 + spread["layer_spread_db"] ** 2
    variance = np.where(interface[:, None] > 0, variance, surface_db**2)
    faded_db, fading_variance = _draw_fading(model, interface, n_lines, rng=rng)
    return _about_mean(block_db + faded_db, variance + fading_variance)


def _with_further(echoes, model, *, rng):
    """The echoes with further ones below, of the last layer's waveform."""
    last = np.flatnonzero(echoes.kind == Kind.LAYER)[-1]
    deepest = echoes.bins[last]
    below = _draw_distances(model.spread["further_spacing_bins"], rng=rng)
    behind = background_below(echoes, below + (deepest - echoes.bins[0]).mean())
    rise = 10 ** (model.spread["further_rise_db"] / 10) - 1
    buried = np.ones(below.size, dtype=int)
    factor = _about_mean(*_draw_fading(model, buried, deepest.size, rng=rng))
    power = rise * (behind + echoes.noise_power)[:, None] * factor
    rows = np.append(np.arange(len(echoes.kind)), np.full(below.size, last))
    return dataclasses.replace(
        echoes,
        bins=np.concatenate([echoes.bins, deepest + below[:, None]]),
        power=np.concatenate([echoes.power, power]),
        variance_bins2=echoes.variance_bins2[rows],
        decay_rate=echoes.decay_rate[rows],
        kind=np.append(echoes.kind, np.full(below.size, Kind.BELOW, dtype=np.int8)),
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
    series = draw_stationary((spread_db**2 * shape)[interface], n_lines, rng=rng)
    lines = lag[:n_lines]
    share_of_pairs = np.where(lines > 0, 2, 1) * (n_lines - lines) / n_lines**2
    kept = 1 - shape[:, :n_lines] @ share_of_pairs
    variance = spread_db[interface] ** 2 * kept[interface, None]
    return series - series.mean(axis=1, keepdims=True), variance
