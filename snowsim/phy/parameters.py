"""Input of eq. (1): a scene's layers and their parameters, drawn from a flight's statistics and checked once."""

from dataclasses import dataclass

import numpy as np

from snowsim.echogram import check_choice, check_layer_bins
from snowsim.phy.waveform import waveform_peak

NORMALISE = ("peak", "none")
ALIGN = ("peak", "gaussian")
WIDTHS = ("paper", "fitted")
BACKGROUNDS = ("measured", "none")
SPECKLE_CORRELATIONS = ("measured", "none")

# Rounding of the closed form [dB]: `waveform_exact` to 1e-12, amplitudes and sums to a few more.
EXACT_BOUND_DB = 1e-11


@dataclass(frozen=True)
class Waveforms:
    """One scene's layers as the terms of eq. (1), ``P_s = sum_l amplitude_l w_l(x - centre_l)``.

    `centre_bins` (layer, range_line) are centres of the Gaussians, NaN where the layer is absent.
    By layer: `amplitude` [power per bin], `variance_bins2` and `decay_rate` [per bin] of the
    waveform, how far it peaks below its centre, `peak_offset_bins`, and its power there,
    `peak_power`. `n_range_bins` is the height of the window. If powers vary along track, those by
    layer are the largest, and `line_share` (layer, range_line) is the share of that, 0 to 1.
    """

    centre_bins: np.ndarray
    amplitude: np.ndarray
    variance_bins2: np.ndarray
    decay_rate: np.ndarray
    peak_offset_bins: np.ndarray
    peak_power: np.ndarray
    n_range_bins: int
    line_share: np.ndarray | None = None

    @property
    def shape(self):
        """(range_bin, range_line) of the window."""
        return self.n_range_bins, self.centre_bins.shape[1]


def checked_waveforms(
    layer_bins, peak_power, variance_bins2, decay_rate, n_range_bins, normalise, align
):
    """`Waveforms` from the arguments of `mean_power`.

    ValueError with name, value and position for values of wrong shape or sign, layers that cross,
    unknown options, and powers whose sum overflows.
    """
    layer_bins = np.asarray(layer_bins, dtype=float)
    check_layer_bins(layer_bins)
    given = {"peak_power": peak_power, "variance_bins2": variance_bins2, "decay_rate": decay_rate}
    line_share = None
    if np.ndim(peak_power) == 2:
        given["peak_power"], line_share = _largest_and_share(peak_power, layer_bins)
    per_layer = {
        name: _per_layer(name, value, layer_bins.shape[0]) for name, value in given.items()
    }
    peak_power, variance_bins2, decay_rate = per_layer.values()
    for name, value, options in (("normalise", normalise, NORMALISE), ("align", align, ALIGN)):
        check_choice(name, value, options)
    offset_bins, unit_peak = waveform_peak(variance_bins2, decay_rate)
    with np.errstate(over="ignore"):
        amplitude = peak_power / unit_peak if normalise == "peak" else peak_power
        reached = amplitude * unit_peak
        total = amplitude.sum() + reached.sum()
    if not np.isfinite(total):
        msg = f"peak_power must add up to a finite power, got {peak_power.max():g} at layer {peak_power.argmax()}"
        raise ValueError(msg)
    centre_bins = layer_bins - offset_bins[:, None] if align == "peak" else layer_bins
    height = checked_height(n_range_bins)
    return Waveforms(
        centre_bins, amplitude, variance_bins2, decay_rate, offset_bins, reached, height, line_share
    )


def checked_height(n_range_bins):
    """Height of a window as int; ValueError unless it is a whole number of at least one."""
    if not (
        np.isscalar(n_range_bins)
        and n_range_bins == np.floor(n_range_bins)
        and 1 <= n_range_bins < 2**31
    ):
        msg = f"n_range_bins must be a whole number of at least 1, got {n_range_bins!r}"
        raise ValueError(msg)
    return int(n_range_bins)


def checked_power(name, value):
    """A power as float; ValueError unless it is finite and not negative."""
    value = float(value)
    if not (value >= 0 and np.isfinite(value)):
        msg = f"{name} must be finite and not negative, got {value}"
        raise ValueError(msg)
    return value


def checked_tolerance(tolerance_db):
    """A tolerance [dB] as float, or None; ValueError unless it is finite and the closed form can keep it."""
    if tolerance_db is None:
        return None
    tolerance_db = float(tolerance_db)
    if not (tolerance_db > 0 and np.isfinite(tolerance_db)):
        msg = f"tolerance_db must be positive and finite, or None for exact, got {tolerance_db}"
        raise ValueError(msg)
    if tolerance_db < EXACT_BOUND_DB:
        msg = f"tolerance_db must be at least {EXACT_BOUND_DB:g}, the rounding of the closed form, got {tolerance_db}"
        raise ValueError(msg)
    return tolerance_db


def _per_layer(name, value, n_layers):
    array = np.asarray(value, dtype=float)
    if array.shape != (n_layers,):
        msg = f"{name}: expected one value for each of {n_layers} layers, got shape {array.shape}"
        raise ValueError(msg)
    bad = ~(np.isfinite(array) & ((array >= 0) if name == "peak_power" else (array > 0)))
    if bad.any():
        layer = int(np.argmax(bad))
        wanted = "finite and not negative" if name == "peak_power" else "finite and positive"
        msg = f"{name} must be {wanted}, got {array[layer]} at layer {layer}"
        raise ValueError(msg)
    return array


def _largest_and_share(peak_power, layer_bins):
    """Largest power of each layer, (layer,), and the share of it on each range line; absent layers count as zero."""
    power = np.asarray(peak_power, dtype=float)
    if power.shape != layer_bins.shape:
        msg = f"peak_power: expected (layer,) or the shape of the layers, {layer_bins.shape}, got {power.shape}"
        raise ValueError(msg)
    present = np.isfinite(layer_bins)
    bad = present & ~(np.isfinite(power) & (power >= 0))
    if bad.any():
        layer, line = np.argwhere(bad)[0]
        msg = f"peak_power must be finite and not negative, got {power[layer, line]} at layer {layer}, line {line}"
        raise ValueError(msg)
    power = np.where(present, power, 0)
    largest = power.max(axis=1, initial=0)
    return largest, power / np.where(largest > 0, largest, 1)[:, None]


def draw_parameters(
    statistics,
    n_layers,
    *,
    width="fitted",
    width_bounds=None,
    n_looks=None,
    speckle_correlation="measured",
    rng,
):
    """Parameters of `render` for one scene of `n_layers` layers, surface included, from the statistics of a flight.

    A layer without a positive, finite value takes that of the layer above it, so layers deeper than
    the flight shows look like its deepest. `width` is ``fitted``, each layer's own variance, or
    ``paper``, variances from U(bounds), the bounds of the measured 1/e width taken as variances, as
    printed, or `width_bounds`; only ``paper`` uses `rng`. `n_looks` is the flight's by default.
    `speckle_correlation` is ``measured``, or ``none``: independent range bins, as printed; older
    statistics, without it, give none.
    """
    check_choice("width", width, WIDTHS)
    check_choice("speckle_correlation", speckle_correlation, SPECKLE_CORRELATIONS)
    n_layers = int(n_layers)
    if n_layers < 1:
        msg = f"n_layers must be at least 1, got {n_layers}"
        raise ValueError(msg)
    if width == "paper":
        name, bounds = "width_bounds", width_bounds
        if bounds is None:
            name, bounds = "width_bound_bins", statistics.variables["width_bound_bins"].values
        low, high = (float(bound) for bound in bounds)
        if not 0 < low <= high < np.inf:
            msg = f"{name} must be positive and increase, got {low:g}, {high:g}"
            raise ValueError(msg)
        variance_bins2 = rng.uniform(low, high, n_layers)
    else:
        variance_bins2 = _down_to(statistics, "variance_bins2", n_layers)
    noise_power = float(statistics.variables["noise_power"])
    if not 0 < noise_power < np.inf:
        msg = f"noise_power of the statistics must be positive and finite, got {noise_power}"
        raise ValueError(msg)
    parameters = {
        "peak_power": _down_to(statistics, "peak_power", n_layers),
        "variance_bins2": variance_bins2,
        "decay_rate": _down_to(statistics, "decay_rate", n_layers),
        "noise_power": noise_power,
        "n_looks": float(statistics.attrs["n_looks"] if n_looks is None else n_looks),
    }
    if speckle_correlation == "measured" and "speckle_correlation" in statistics:
        parameters["speckle_correlation"] = statistics.variables["speckle_correlation"].values
    return parameters


def scene_parameters(scene, statistics, *, background="measured", **options):
    """Layers to render and parameters of `render` for a scene: its own radiometry where it has one, else the flight's.

    `options` are those of `draw_parameters`. With `background` ``measured``, a scene without powers
    of its own has the flight's mean power of unpicked snow below the surface, one row for each
    e-folding depth; with ``none``, and with older statistics, eq. (1) has the layers alone, as
    printed. A scene that was drawn with powers has them in `peak_power`, for every row of
    `complete_layer_bins`; its notes hold noise, decay and the layer that gives a row its waveform
    (-1 - k: e-folding depth k of the background). Gain by line is the flight's, and so is texture,
    which multiplies all that is not labelled: it was measured on all power below the picks.
    """
    check_choice("background", background, BACKGROUNDS)
    if scene.peak_power is None:
        parameters = draw_parameters(statistics, scene.layer_bins.shape[0], **options)
        if background == "none" or "background_power" not in statistics:
            return scene.layer_bins, parameters
        return _with_background(scene.layer_bins, parameters, statistics)
    parameters = draw_parameters(statistics, max(scene.notes["waveform_row"]) + 1, **options)
    variance, decay = row_waveforms(
        scene.notes, parameters["variance_bins2"], parameters["decay_rate"]
    )
    own = {"peak_power": scene.peak_power, "noise_power": scene.notes["noise_power"]}
    flight = statistics.variables
    if "texture_variance" in flight:
        own["line_gain_spread_db"] = float(flight["line_gain_spread_db"])
        background = np.array(scene.notes["waveform_row"]) < 0
        n_labelled = np.isfinite(scene.layer_bins).any(axis=1).sum() + background.sum()
        own["textured_layers"] = background | (np.arange(background.size) >= n_labelled)
        own["texture"] = [
            float(flight[f"texture_{name}"]) for name in ("variance", "length_bins", "length_lines")
        ]
    return scene.complete_layer_bins, parameters | own | {
        "variance_bins2": variance,
        "decay_rate": decay,
    }


def _with_background(layer_bins, parameters, statistics):
    """Layers and parameters with a row for each e-folding depth of the background, within a bin below the surface."""
    power, fall = (statistics.variables[name].values for name in ("background_power", "fall"))
    held = np.flatnonzero(power > 0)
    # Rows must not cross the first layer, wherever it is picked.
    gap = np.fmin(1.0, layer_bins[1] - layer_bins[0]) if len(layer_bins) > 1 else 1.0
    below = layer_bins[:1] + gap * (1 + np.arange(held.size)[:, None]) / (held.size + 1)
    first = {"peak_power": power[held], "decay_rate": 1 / fall[held]}
    first["variance_bins2"] = np.full(held.size, parameters["variance_bins2"][0])
    with_rows = {name: np.insert(parameters[name], 1, values) for name, values in first.items()}
    return np.concatenate([layer_bins[:1], below, layer_bins[1:]]), parameters | with_rows


def row_waveforms(notes, variance_bins2, decay_rate):
    """Variance and decay rate of each row of a scene drawn with powers, by its notes, from those by layer."""
    row, falls = np.array(notes["waveform_row"]), np.array(notes["background_falls"])
    layer = np.clip(row, 0, len(variance_bins2) - 1)
    own_decay = np.asarray(decay_rate)[layer] * notes["decay_factor"]
    return np.asarray(variance_bins2)[layer], np.where(
        row < 0, 1 / falls[np.maximum(-1 - row, 0)], own_decay
    )


def _down_to(statistics, name, n_layers):
    """Values of the uppermost `n_layers` layers; a missing one is that of the nearest layer above with a value."""
    values = statistics.variables[name].values.astype(float)
    usable = np.isfinite(values) & (values > 0)
    if not (usable.size and usable[0]):
        msg = f"{name} of the statistics must be positive and finite at layer 0, got {values[:1].tolist()}"
        raise ValueError(msg)
    above = np.maximum.accumulate(np.where(usable, np.arange(values.size), 0))
    return values[above[np.minimum(np.arange(n_layers), values.size - 1)]]
