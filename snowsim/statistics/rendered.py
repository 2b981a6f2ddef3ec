"""Rendered scenes as frames of a flight, so that their statistics can be taken like a flight's."""

from dataclasses import replace

import numpy as np
import xarray as xr

START = np.datetime64("2012-01-01T00:00:00", "ns")
EARTH_RADIUS_M = 6.371e6  # of `snowsim.echogram.along_track_m`


def as_frame(power, layer_bins, index, *, bin_size_s, line_spacing_m):
    """One rendered scene as a frame that `summarise` reads.

    Parameters
    ----------
    power : ndarray, (range_bin, range_line)
        Linear.
    layer_bins : ndarray, (layer, range_line)
        Fractional range bins; NaN where absent.
    index : int
        Of the scene: frames sort by it.
    bin_size_s, line_spacing_m : float

    Returns
    -------
    echogram, layers : xarray.Dataset
        Open Polar Radar convention. Times and positions are made up: a minute a scene, northward.
    """
    n_lines = power.shape[1]
    start = START + index * np.timedelta64(1, "m")
    slow_time = start + np.arange(n_lines) * np.timedelta64(1, "ms")
    twtt = bin_size_s * layer_bins
    along = {
        "Latitude": 70 + np.degrees(line_spacing_m / EARTH_RADIUS_M) * np.arange(n_lines),
        "Longitude": np.full(n_lines, -45.0),
        "Elevation": np.zeros(n_lines),
        "Surface": twtt[0],
    }
    echogram = xr.Dataset(
        {"Data": (("twtt", "slow_time"), power)} | {name: ("slow_time", values) for name, values in along.items()},
        coords={"twtt": bin_size_s * np.arange(len(power)), "slow_time": slow_time},
    )
    ones = np.ones(layer_bins.shape, dtype=np.int8)
    dims = ("layer", "slow_time")
    layers = xr.Dataset(
        {"twtt": (dims, twtt), "quality": (dims, ones), "type": (dims, ones)}, coords={"slow_time": slow_time}
    )
    return echogram, layers


def thinned(summary, stride):
    """A summary with one in `stride` of its averaged range lines; picks and the power under them stay whole.

    The groups of a scene differ in speckle alone and `deblend` takes a limited number of them for the shapes: more
    cost time and disk, not accuracy. A frame keeps at least its first group.
    """
    names = ("power", "position", "spread", "n_picks", "air_sum", "air_square", "air_count")
    return [replace(frame, **{name: getattr(frame, name)[::stride] for name in names}) for frame in summary]
