"""Values of flight statistics, each checked as it is read, and echoes made of their means."""

import dataclasses

import numpy as np
import pandas as pd

from snowsim.echogram import Echoes, Kind, check_choice
from snowsim.limits import check_statistics, check_values


def values_of(statistics, name, dims):
    """A variable or coordinate of the statistics on `dims`, float; ValueError if not finite."""
    values = np.empty(0)
    if name in statistics:
        values = statistics[name].transpose(*dims).values.astype(float)
    if values.size == 0 or not np.isfinite(values).all():
        held = ", ".join(map(str, statistics.variables))
        msg = f"flight statistics need {name}, all finite, got shape {values.shape}; hold {held}"
        raise ValueError(msg)
    return values


def of_uppermost(statistics, name, n_layers):
    """Positive values of the uppermost layers, (layer,).

    A layer without one, or below the flight's last, takes that of the nearest layer above.
    """
    check_choice("a flight statistic", name, list(map(str, statistics.variables)))
    values = statistics[name].values.astype(float)
    check_values(f"flight statistics: {name} at layer 0", values[0], 0, above=True)
    usable = np.isfinite(values) & (values > 0)
    nearest_above = pd.Series(values).where(usable).ffill()
    return nearest_above.reindex(range(n_layers), method="ffill").to_numpy()


def radar_of(statistics):
    """Number of looks and correlation of speckle, as arguments of `Echoes`.

    The correlation is measured in air above the surface; statistics of images hold none.
    """
    radar = {"n_looks": float(statistics.attrs["n_looks"])}
    if "speckle_correlation" in statistics:
        radar["speckle_correlation"] = statistics["speckle_correlation"].values
    return radar


def dress(layer_bins, statistics):
    """Give layers without powers the echoes that such layers have on average in a flight.

    Echoes have one row for each layer, and rows of background just below the surface: the flight's
    mean power of unpicked snow, one row for each e-folding depth. Layers deeper than those of the
    flight take the values of its deepest. Powers do not vary from scene to scene or along track,
    nor does gain vary from line to line.

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
    noise_power = values_of(statistics, "noise_power", ()).item()
    check_values("flight statistics: noise_power", noise_power, 0, above=True)
    power = of_uppermost(statistics, "peak_power", n_layers)
    layers = Echoes(
        bins=layer_bins,
        power=np.repeat(power[:, None], n_lines, axis=1),
        variance_bins2=of_uppermost(statistics, "variance_bins2", n_layers),
        decay_rate=of_uppermost(statistics, "decay_rate", n_layers),
        kind=np.full(n_layers, Kind.LAYER, dtype=np.int8),
        noise_power=noise_power,
        **radar_of(statistics),
    )
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


def background_below(echoes, depth_bins):
    """Mean power of the background at depths below the surface [bins], (depth,)."""
    held = echoes.kind == Kind.BACKGROUND
    fallen = np.exp(-np.outer(depth_bins, echoes.decay_rate[held]))
    return fallen @ echoes.power[held].mean(axis=1)


def redress(scene, statistics):
    """Replace the waveforms and the radar in a scene's echoes by those of other statistics.

    Returns `Echoes`. Positions, powers and noise stay as the scene was drawn; a scene without
    echoes gets those of `dress`.
    """
    drawn = scene.echoes
    if drawn is None:
        return dress(scene.layer_bins, statistics)
    is_layer = drawn.kind != Kind.BACKGROUND
    deepest = min(len(scene.layer_bins), statistics.sizes["layer"]) - 1
    level = np.minimum(np.cumsum(is_layer) - 1, deepest)
    # Background takes the variance of the surface.
    level[~is_layer] = 0
    n_levels = int(level.max()) + 1
    decay = of_uppermost(statistics, "decay_rate", n_levels)[level] * drawn.decay_factor
    return dataclasses.replace(
        drawn,
        variance_bins2=of_uppermost(statistics, "variance_bins2", n_levels)[level],
        decay_rate=np.where(is_layer, decay, drawn.decay_rate),
        **radar_of(statistics),
    )
