"""Echogram of a snowpack, rendered by PHY, and its true layers."""

import warnings
from datetime import date as Date

import numpy as np
import pandas as pd
import xarray as xr

from snowsim.constants import BLOCK_LINES, SPEED_OF_LIGHT_M_S, THIS_AGE
from snowsim.echogram import (
    MAXIMUM_BYTES,
    MINIMUM_ROWS,
    ROWS_BELOW_LAST_LAYER,
    SURFACE_ROW,
    echogram_dataset,
    scene_height,
    to_db,
)
from snowsim.limits import check_count, check_values
from snowsim.phy import render
from snowsim.phy.waveform import waveform_peak
from snowsim.progress import with_progress
from snowsim.seeding import generator
from snowsim.snowpack.physical import (
    Climate,
    Radar,
    Snowpack,
    depth_and_water,
    physical_parameters,
)
from snowsim.snowpack.snow import NORTH_MONTHS, YEAR_DAYS

# By default flights are at the end of a snow year, so that a whole year's snow lies above the first
# horizon of a climate. They go due north.
DATE = "2000-08-31"
SPEED_M_S = 130.0
LATITUDE = 75.0
LONGITUDE = -45.0
GROUND_M = 2700.0  # height of the snow, about that of the ice sheet there
RELATIVE_POWER = {
    "units": "1",
    "long_name": "power relative to a flat mirror in place of the snow",
}
FLAG_VALUES = {"quality": 1, "type": 2}  # good; automatic
LINES_AT_ONCE = 1024  # range lines rendered at once, to save memory


def simulate(
    snowpack: Snowpack | Climate,
    radar: Radar | str,
    *,
    n_range_lines: int | None = None,
    rng: int | np.random.Generator,
    exact: bool = False,
    date: str | Date = DATE,
) -> tuple[xr.Dataset, xr.Dataset]:
    """Echogram of a snowpack, and its true layers.

    Parameters
    ----------
    snowpack : Snowpack or Climate
    radar : Radar or str
        A radar or the name of a preset.
    n_range_lines : int, optional
        Number of range lines; by default that of the snowpack, or 256 of a climate. A snowpack of
        one range line may be repeated.
    rng : int or numpy.random.Generator
    exact : bool, optional
        See `snowsim.phy.render`.
    date : str or datetime.date, optional
        Day of the flight, 2012-03-30; it begins at midnight (UTC). Above the first horizon of a
        climate lies the snow since the end of August.

    Returns
    -------
    echogram, layers : xarray.Dataset
        Both follow Open Polar Radar. `Data` (twtt, slow_time) of the echogram is power relative to
        a flat mirror in place of the snow. Layers have, on (layer, slow_time), `twtt`, the travel
        time to the interface [s]; `peak_twtt`, that of its echo's peak [s]; `power_db`, the mean
        power of this peak; `depth_m`, the depth below the surface; and `water_m`, the mass above
        [m w.e.].

    Raises
    ------
    ValueError
        If `n_range_lines` is below 1, differs from that of the snowpack, or makes an echogram
        larger than readers take; if the surface rises to the radar; if `date` is no date.

    Notes
    -----
    PHY renders the powers, widths and tails of `snowsim.snowpack.physical_parameters`. For
    contrasts of 30-250 kg m-3, three range cells apart or more, delays are within 0.1 bin and mean
    powers within 0.5 dB of those of a transfer matrix.

    Examples
    --------
    >>> from snowsim import Snowpack
    >>> snow = Snowpack(depth_m=[0, 1.0, 2.5], density_kg_m3=[340, 400, 350])
    >>> rng = np.random.default_rng(1)
    >>> echogram, layers = simulate(snow, "ku-12-18", n_range_lines=64, rng=rng)
    >>> (1e9 * np.diff(layers["twtt"][:, 0])).round(2)  # 2 n h / c [ns]
    array([ 8.59, 13.39])
    """
    radar = Radar.preset(radar) if isinstance(radar, str) else radar
    rng = generator(rng)
    start = _midnight(date)
    if n_range_lines is not None:
        _check_lines(n_range_lines, snowpack, radar)
        n_range_lines = int(n_range_lines)  # numpy's small integers overflow
    if isinstance(snowpack, Climate):
        since_autumn = (start + pd.DateOffset(months=NORTH_MONTHS)).day_of_year / YEAR_DAYS
        snowpack = snowpack.draw(
            n_range_lines or BLOCK_LINES, radar.line_spacing_m, rng=rng, first_year=since_autumn
        )
    if not np.any(snowpack.roughness_m):
        msg = "snowpack: roughness_m is 0, but speckle is full: mirrors are not simulated"
        warnings.warn(msg, UserWarning, stacklevel=2)
    below_s, parameters = physical_parameters(snowpack, radar)
    n_range_lines = n_range_lines or below_s.shape[1]
    shape = (below_s.shape[0], n_range_lines)
    surface_row = _surface_row(below_s[0], radar)
    layer_bins = np.broadcast_to(surface_row + below_s / radar.bin_s, shape)
    lag_bins, height = waveform_peak(parameters["variance_bins2"], parameters["decay_rate"])
    peak_power = np.broadcast_to(parameters["peak_power"], shape)
    surface_power = parameters["peak_power"][0].mean() * height[0]
    parameters |= {
        "peak_power": peak_power,
        "noise_power": surface_power * 10 ** (-radar.surface_to_noise_db / 10),
        "n_looks": radar.n_looks,
        "speckle_correlation": radar.speckle_correlation(),
    }
    power = _power(layer_bins, parameters, rng=rng, exact=exact)
    first_s = 2 * radar.height_m / SPEED_OF_LIGHT_M_S - surface_row * radar.bin_s
    attributes = vars(radar) | {
        # A file cannot hold a window with parameters as an attribute.
        "window": str(radar.window),
        "synthetic": "simulated from a snowpack and a radar, not observed data",
        "granule": f"{start:%Y%m%d}_01_001",
        "radar_name": "simulated",
        "season_name": "simulated",
    }
    content = _track(n_range_lines, radar, start) | {
        "Data": power,
        "twtt": first_s + np.arange(power.shape[0]) * radar.bin_s,
        "Surface": first_s + layer_bins[0] * radar.bin_s,
    }
    echogram = echogram_dataset("simulate", content, attributes)
    echogram["Data"].attrs = RELATIVE_POWER
    twtt_s = first_s + layer_bins * radar.bin_s
    peak_s = first_s + (layer_bins + lag_bins[:, None]) * radar.bin_s
    return echogram, _layers(
        echogram,
        twtt_s,
        peak_s,
        to_db(peak_power * height[:, None]),
        depth_and_water(snowpack, below_s),
    )


def _power(layer_bins, parameters, *, rng, exact):
    """Power of an echogram (range_bin, range_line), rendered in parts to save memory."""
    n_range_bins = scene_height(layer_bins)
    how = {"rng": rng, "exact": exact, "as_printed": True}
    parts = []
    firsts = range(0, layer_bins.shape[1], LINES_AT_ONCE)
    for first in with_progress(firsts, unit=f"{LINES_AT_ONCE} lines"):
        lines = slice(first, first + LINES_AT_ONCE)
        of_part = parameters | {"peak_power": parameters["peak_power"][:, lines]}
        parts.append(render(layer_bins[:, lines], of_part, n_range_bins, **how))
    return np.hstack(parts)


def _layers(echogram, twtt_s, peak_s, power_db, in_metres):
    """Dataset of layers (layer, slow_time) of an echogram, in the format of Open Polar Radar.

    `in_metres` are further variables in metres, on all range lines or one.
    """
    on = ("layer", "slow_time")
    variables = {
        "twtt": (on, twtt_s, {"units": "s", "place": "interface"}),
        "peak_twtt": (on, peak_s, {"units": "s", "place": "peak"}),
        "power_db": (on, power_db, RELATIVE_POWER | {"units": "dB"}),
    }
    for name, value_m in in_metres.items():
        variables[name] = (on, np.broadcast_to(value_m, twtt_s.shape), {"units": "m"})
    for name, code in FLAG_VALUES.items():
        variables[name] = (on, np.full(twtt_s.shape, code, np.int8))
    layers = xr.Dataset(variables, {"slow_time": echogram["slow_time"]}, echogram.attrs)
    return layers.assign(echogram[["Latitude", "Longitude", "Elevation"]])


def _check_lines(n_range_lines, snowpack, radar):
    """Refuse a number of range lines that is no count, not the snowpack's, or too large to read."""
    check_count("n_range_lines", n_range_lines)
    if isinstance(snowpack, Climate):
        snowpack = snowpack.draw(1, radar.line_spacing_m, rng=generator(0))
    n_own = snowpack.depth_m.shape[1]
    if n_own not in (1, n_range_lines):
        msg = f"n_range_lines must be the {n_own} of the snowpack, got {n_range_lines}"
        raise ValueError(msg)
    # An estimate: the refractive index of dry snow is at most 1.5, and pixels have 4 bytes.
    depth_s = 2 * 1.5 * snowpack.depth_m.max() / SPEED_OF_LIGHT_M_S
    n_range_bins = int(depth_s / radar.bin_s) + SURFACE_ROW + ROWS_BELOW_LAST_LAYER
    most = MAXIMUM_BYTES // (4 * max(n_range_bins, MINIMUM_ROWS))
    if n_range_lines > most:
        msg = (
            f"n_range_lines must be at most some {most}, {MAXIMUM_BYTES / 2**30:g} GiB, as "
            f"readers take, got {n_range_lines}: simulate parts, each by a seed of its own; "
            "parts of one snow are range lines of a Snowpack's depth_m and density_kg_m3"
        )
        raise ValueError(msg)


def _surface_row(surface_s, radar):
    """Row of the mean surface: that of scenes, further down if the surface rises above its mean.

    Above a near surface there are only as many rows as there is air. ValueError if the snow reaches
    the radar.
    """
    height_s = 2 * radar.height_m / SPEED_OF_LIGHT_M_S
    highest_s = surface_s.min()
    room_s = height_s + highest_s
    check_values("snowpack: travel time from the radar to the surface", room_s, 0, above=True)
    above = SURFACE_ROW + int(np.ceil(max(0.0, -highest_s / radar.bin_s)))
    return min(above, int(height_s / radar.bin_s))


def _midnight(date):
    """Time of midnight at the begin of a day; ValueError unless readers of echograms take it."""
    try:
        day = Date.fromisoformat(str(date))
    except ValueError as error:
        msg = f"date must be a day such as 2012-03-30, got {str(date)!r}"
        raise ValueError(msg) from error
    first, end = THIS_AGE
    if not first <= str(day) < end:
        msg = f"date must lie in {first} to {end}, as times in files, got {day}"
        raise ValueError(msg)
    return pd.Timestamp(day)


def _track(n_range_lines, radar, start):
    """Times and positions of a flight due north, as variables of an echogram."""
    distance_m = np.arange(n_range_lines) * radar.line_spacing_m
    elapsed_ns = np.rint(1e9 * distance_m / SPEED_M_S)
    return {
        "slow_time": start.to_datetime64() + elapsed_ns.astype("timedelta64[ns]"),
        "Latitude": LATITUDE + distance_m / 111_195.0,  # metres in a degree
        "Longitude": np.full(n_range_lines, LONGITUDE),
        "Elevation": np.full(n_range_lines, GROUND_M + radar.height_m),
        # Readers of L1B files need the attitude, that of level flight.
        **dict.fromkeys(("Roll", "Pitch", "Heading"), np.zeros(n_range_lines)),
    }
