"""Echoes of layers, drawn from flight statistics, whose values are checked when they are read.

Echoes have the flight's mean powers, or vary about them: power varies from layer to layer, that of
the background from scene to scene. Along track a layer has one power, and noise and decay are the
flight's in every scene: that they vary is worth nothing to a tracker.
"""

import dataclasses

import numpy as np
import pandas as pd

from snowsim.constants import NEPERS
from snowsim.echogram import ROWS_BELOW_LAST_LAYER, Echoes, Kind
from snowsim.limits import check_statistics, check_values

# Statistics that the echoes of scenes vary by.
VARIES = (
    "surface_spread_db",
    "common_spread_db",
    "layer_spread_db",
    "background_spread_db",
    "further_spacing_bins",
    "further_rise_db",
)


def values_of(statistics, name, dims=()):
    """Values of one statistic, an array on `dims`, or a float if there are none.

    ValueError if it is missing or not finite.
    """
    values = np.empty(0)
    if name in statistics:
        values = statistics[name].transpose(*dims).values.astype(float)
    if values.size == 0 or not np.isfinite(values).all():
        msg = f"flight statistics need {name}, all finite, got shape {values.shape}; "
        raise ValueError(msg + _names_held(statistics))
    return values if dims else values.item()


def value_per_layer(statistics, name, n_layers):
    """Positive value of one statistic for each of `n_layers` layers, (layer,).

    A layer without a value, or below the flight's last layer, takes the value of the nearest layer
    above. ValueError if the flight's uppermost layer has none.
    """
    if name not in statistics:
        msg = f"flight statistics need {name}; "
        raise ValueError(msg + _names_held(statistics))
    values = statistics[name].values.astype(float)
    check_values(f"flight statistics: {name} at layer 0", values[0], 0, above=True)
    usable = np.isfinite(values) & (values > 0)
    nearest_above = pd.Series(values).where(usable).ffill()
    return nearest_above.reindex(range(n_layers), method="ffill").to_numpy()


def _names_held(statistics):
    """Names of all variables of the statistics, for an error."""
    return f"hold {', '.join(map(str, statistics.variables))}"


def radar_of(statistics):
    """Number of looks and correlation of speckle, by name, as arguments of `Echoes`.

    The correlation was measured in the air above the surface. Statistics of images hold none.
    """
    radar = {"n_looks": float(statistics.attrs["n_looks"])}
    if "speckle_correlation" in statistics:
        radar["speckle_correlation"] = statistics["speckle_correlation"].values
    return radar


def echoes_without_background(layer_bins, statistics, variance_bins2, **radar):
    """`Echoes` of layers without background; each layer has the flight's mean power and decay."""
    n_layers, n_lines = layer_bins.shape
    power = value_per_layer(statistics, "peak_power", n_layers)
    return Echoes(
        bins=layer_bins,
        power=np.repeat(power[:, None], n_lines, axis=1),
        variance_bins2=variance_bins2,
        decay_rate=value_per_layer(statistics, "decay_rate", n_layers),
        kind=np.full(n_layers, Kind.LAYER, dtype=np.int8),
        noise_power=values_of(statistics, "noise_power"),
        **radar,
    )


def echoes_of_layers(layer_bins, statistics):
    """Echoes that layers have on average in a flight.

    Echoes have one row for each layer, and rows of background just below the surface. The
    background is the flight's mean power of unpicked snow, one row for each e-folding depth. Layers
    deeper than those of the flight take the values of its deepest. Powers do not vary from scene to
    scene or along track, and gain does not vary from line to line.

    Parameters
    ----------
    layer_bins : ndarray, (layer, range_line)
        Range bins, row 0 the surface; NaN where absent.
    statistics : xarray.Dataset
        Statistics as from `snowsim.statistics.fit`.

    Returns
    -------
    Echoes

    Raises
    ------
    ValueError
        If statistics are of an earlier version, missing, not finite or not positive.
    """
    check_statistics(statistics)
    n_layers, n_lines = layer_bins.shape
    variance = value_per_layer(statistics, "variance_bins2", n_layers)
    layers = echoes_without_background(layer_bins, statistics, variance, **radar_of(statistics))
    check_values("flight statistics: noise_power", layers.noise_power, 0, above=True)
    # Statistics of 8-bit images hold no background.
    if "background_power" not in statistics:
        return layers
    power, fall = (values_of(statistics, name, ("fall",)) for name in ("background_power", "fall"))
    held = power > 0
    # Background rows lie within a bin below the surface, and above layer 1 where it is picked.
    gap = np.fmin(1.0, layer_bins[1] - layer_bins[0]) if n_layers > 1 else 1.0
    place = (1 + np.arange(held.sum())[:, None]) / (held.sum() + 1)
    background = {
        "bins": layer_bins[:1] + gap * place,
        "power": np.repeat(power[held, None], n_lines, axis=1),
        "variance_bins2": np.repeat(layers.variance_bins2[:1], held.sum()),
        "decay_rate": 1 / fall[held],
        "kind": np.full(held.sum(), Kind.BACKGROUND, dtype=np.int8),
    }
    below_surface = {
        name: np.insert(getattr(layers, name), [1] * len(rows), rows, axis=0)
        for name, rows in background.items()
    }
    return dataclasses.replace(layers, **below_surface)


def with_waveforms_of(scene, statistics):
    """Echoes of a scene, with the waveforms and the radar of other statistics.

    Positions, powers and noise stay as the scene was drawn. A scene without echoes gets those of
    `echoes_of_layers`.
    """
    drawn = scene.echoes
    if drawn is None:
        return echoes_of_layers(scene.layer_bins, statistics)
    is_layer = drawn.kind != Kind.BACKGROUND
    deepest = min(len(scene.layer_bins), statistics.sizes["layer"]) - 1
    level = np.minimum(np.cumsum(is_layer) - 1, deepest)
    # Background takes the variance of the surface.
    level[~is_layer] = 0
    n_levels = int(level.max()) + 1
    decay = value_per_layer(statistics, "decay_rate", n_levels)[level]
    return dataclasses.replace(
        drawn,
        variance_bins2=value_per_layer(statistics, "variance_bins2", n_levels)[level],
        decay_rate=np.where(is_layer, decay, drawn.decay_rate),
        **radar_of(statistics),
    )


def add_echoes(scene, statistics, spread, *, rng):
    """The scene with its `echoes`, which vary by the statistics in `spread`, see `VARIES`.

    Powers vary in dB, and their means stay those of the flight. The surface varies from scene to
    scene, buried layers vary together and each by itself. Unpicked snow is a background, one row
    just below the surface for each of its e-folding depths. Below the last layer further echoes
    stand at random distances; they rise out of the background as in the flight.
    """
    flight = echoes_of_layers(scene.layer_bins, statistics)
    is_layer = flight.kind == Kind.LAYER
    background_db = spread["background_spread_db"]
    factor = np.empty(flight.power.shape)
    factor[is_layer] = _layer_factors(len(scene.layer_bins), spread, rng=rng)[:, None]
    factor[~is_layer] = _about_mean(background_db * rng.standard_normal(), background_db**2)
    echoes = dataclasses.replace(
        flight,
        power=flight.power * factor,
        line_gain_spread_db=spread.get("line_gain_spread_db", 0.0),
    )
    return dataclasses.replace(scene, echoes=_with_further(echoes, spread, rng=rng))


def _layer_factors(n_layers, spread, *, rng):
    """Factors of the power of layers over the flight's mean, (layer,)."""
    power_db = spread["common_spread_db"] * rng.standard_normal()
    power_db = power_db + spread["layer_spread_db"] * rng.standard_normal(n_layers)
    power_db[0] = spread["surface_spread_db"] * rng.standard_normal()
    variance_db2 = np.full(
        n_layers, spread["common_spread_db"] ** 2 + spread["layer_spread_db"] ** 2
    )
    variance_db2[0] = spread["surface_spread_db"] ** 2
    return _about_mean(power_db, variance_db2)


def _with_further(echoes, spread, *, rng):
    """The echoes with further ones below, of the last layer's waveform, at random distances."""
    last = np.flatnonzero(echoes.kind == Kind.LAYER)[-1]
    deepest = echoes.bins[last]
    spacing_bins = spread["further_spacing_bins"]
    enough = int(4 * ROWS_BELOW_LAST_LAYER / spacing_bins) + 8
    below = np.cumsum(1 + rng.exponential(max(spacing_bins - 1, 0.1), enough))
    below = below[below < ROWS_BELOW_LAST_LAYER]
    # Mean power of the background at those depths.
    depth_bins = below + (deepest - echoes.bins[0]).mean()
    held = echoes.kind == Kind.BACKGROUND
    fallen = np.exp(-np.outer(depth_bins, echoes.decay_rate[held]))
    behind = fallen @ echoes.power[held].mean(axis=1)
    rise = 10 ** (spread["further_rise_db"] / 10) - 1
    power = np.repeat(rise * (behind + echoes.noise_power)[:, None], deepest.size, axis=1)
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
    """Factors of power with mean 1, from Gaussian deviations in dB with this variance."""
    return np.exp(NEPERS * deviation_db - NEPERS**2 * variance_db2 / 2)
