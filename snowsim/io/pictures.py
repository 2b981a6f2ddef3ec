"""Layers drawn on their echogram, on axes of distance and depth."""

import numpy as np

from snowsim.constants import KOVACS_M3_KG, SPEED_OF_LIGHT_M_S
from snowsim.echogram import along_track_m, bin_size_s, to_db
from snowsim.io.files import written_whole

NEEDED = "pictures need matplotlib: pip install 'snowsim[plot]'"
# Of picks by quality.
COLOURS = {1: ("good", "#009e73"), 2: ("moderate", "#f0a000"), 3: ("bad", "#d50000")}
TYPICAL_DENSITY_KG_M3 = 350.0  # where none is given
SHOWN_ABOVE_M = 1.0  # the surface
SHOWN_PERCENT = (5, 99.7)  # of pixels, from black to white
N_DEPTHS = 800


def write_picture(path, layers, echograms=(), accumulated=None):
    """Write a PNG of named layers on their echograms, and below, if given, accumulation by year.

    `layers` is a dataset with the surface first, `echograms` are its frames; colours tell quality.
    Without `accumulated`, as of `snowsim.accumulation`, depth is that in snow of 350 kg m-3.
    """
    try:
        from matplotlib.figure import Figure
    except ImportError as error:
        raise ValueError(NEEDED) from error
    n_panels = 1 if accumulated is None else 2
    figure = Figure(figsize=(11, 1 + 4.5 * n_panels), layout="constrained")
    panels = figure.subplots(n_panels, sharex=True, squeeze=False)[:, 0]
    layers = layers.transpose("layer", "slow_time", ...)
    distance, label = _distance(layers)
    depth_m = _depth_m(layers["twtt"].values - layers["twtt"].values[0], accumulated)
    shown_m = np.linspace(-SHOWN_ABOVE_M, np.nanmax(depth_m) + SHOWN_ABOVE_M, N_DEPTHS)
    extent = (distance[0], distance[-1], shown_m[-1], shown_m[0])
    if echograms:
        parts = [_levelled_db(each, layers, shown_m, accumulated) for each in echograms]
        power_db = np.concatenate(parts, axis=1)
        limits = dict(zip(("vmin", "vmax"), np.nanpercentile(power_db, SHOWN_PERCENT), strict=True))
        _draw_image(panels[0], power_db, extent, "power [dB]", cmap="gray", **limits)
    _draw_layers(panels[0], layers, distance, depth_m)
    panels[0].set(ylim=extent[2:], ylabel="depth [m]")
    panels[-1].set(xlabel=label)
    if accumulated is not None:
        newest, *_, oldest = accumulated["year"].values
        extent = (*extent[:2], oldest - 0.5, newest + 0.5)
        values = accumulated["accumulation_m_we"].values
        _draw_image(panels[1], values, extent, "accumulation [m w.e. / yr]")
        panels[1].set(ylabel="year")
        panels[1].yaxis.get_major_locator().set_params(integer=True)
    with written_whole(path) as aside:
        figure.savefig(aside, format="png", dpi=110)


def _draw_image(axes, values, extent, label, **how):
    image = axes.imshow(values, extent=extent, aspect="auto", interpolation="nearest", **how)
    axes.figure.colorbar(image, ax=axes, label=label)


def _draw_layers(axes, layers, distance, depth_m):
    """Draw layers (layer, range_line), each with its name at its end."""
    for value, (name, colour) in COLOURS.items():
        of_value = np.where(layers["quality"].values == value, depth_m, np.nan)
        first, *_ = axes.plot(distance, of_value.T, color=colour, lw=1)
        first.set_label(name)
    for name, of_layer in zip(layers["layer"].values, depth_m, strict=True):
        last = np.flatnonzero(np.isfinite(of_layer))[-1]
        axes.text(distance[last], of_layer[last], str(name), fontsize=5, color="#56b4e9")
    axes.legend(fontsize="small", ncols=3, loc="lower left")


def _distance(layers):
    """Distance along track [km], or numbers of range lines where positions are missing."""
    distance_m = along_track_m(layers)
    if np.isfinite(distance_m).all() and distance_m[-1] > 0:
        return distance_m / 1000, "distance [km]"
    return np.arange(distance_m.size), "range line"


def _depth_m(below_s, accumulated):
    """Depth [m] at travel times below the surface [s]."""
    if accumulated is None:
        index = 1 + KOVACS_M3_KG * TYPICAL_DENSITY_KG_M3
        return SPEED_OF_LIGHT_M_S * below_s / (2 * index)
    known = accumulated["depth_at"]
    return np.interp(below_s, known["below_s"].values, known.values, right=np.nan)


def _levelled_db(echogram, layers, shown_m, accumulated):
    """Power [dB] of a frame at depths (depth, range_line), in the air above it at heights."""
    surface_s = layers["twtt"].sel(slow_time=echogram["slow_time"]).values[0]
    first_s, *_, last_s = echogram["twtt"].values
    below_s = np.linspace(0, last_s - first_s, N_DEPTHS)
    there_s = np.interp(shown_m, _depth_m(below_s, accumulated), below_s)
    there_s = np.where(shown_m < 0, 2 * shown_m / SPEED_OF_LIGHT_M_S, there_s)
    at = (surface_s + there_s[:, None] - first_s) / bin_size_s(echogram)
    power = echogram["Data"].transpose("twtt", "slow_time").values
    inside = (at >= 0) & (at <= len(power) - 1)
    row = np.where(inside, np.rint(at), 0).astype(int)
    levelled = np.where(inside, np.take_along_axis(power, row, axis=0), np.nan)
    return to_db(np.where(levelled > 0, levelled, np.nan))
