"""Frames made of power and layers alone, with placeholders for their times and positions."""

import numpy as np
import xarray as xr

from snowsim.constants import EARTH_RADIUS_M
from snowsim.echogram import from_uint8
from snowsim.io import echogram

# Metres in a degree of latitude, on the sphere that `echogram.along_track_m` uses.
METRES_PER_DEGREE = EARTH_RADIUS_M * np.pi / 180


def frame_of_scene(scene, *, bin_s, line_spacing_m, contrast_db=None):
    """Echogram and layers made from a scene's image, to fit statistics where only images exist.

    Images tell neither `bin_s`, the bin size in two-way travel time [s], nor `line_spacing_m`, the
    distance between range lines [m]. `contrast_db` is the span from the noise floor to the maximum
    (8-bit 255) [dB]; a scene that does not hold these two levels needs it. Power comes in steps of
    1/255 of that span. Positions and times are placeholders.
    """
    levels_db = (scene.noise_floor_db, scene.maximum_db)
    if not np.isfinite(levels_db).all():
        levels_db = (0.0, float(contrast_db))
    power_db = from_uint8(scene.image, *levels_db)
    power = (10 ** (power_db / 10)).astype(np.float32)
    north_m = np.arange(scene.n_range_lines) * line_spacing_m
    latitude = 70 + north_m / METRES_PER_DEGREE
    frame, layers = placeholder_frame(power, scene.layer_bins, latitude, bin_s=bin_s)
    return frame.assign_attrs(source_format="8-bit image", name=scene.name), layers


def placeholder_frame(power, layer_bins, latitude, *, bin_s, minute=0):
    """Power and layers as Open Polar Radar datasets, due north, one line a millisecond.

    `power (range_bin, range_line)` is linear, `layer_bins (layer, range_line)` is NaN where absent.
    Times and positions are placeholders: `minute` sets the order of frames, `latitude` [deg] the
    distance between range lines.
    """
    n_lines = power.shape[1]
    milliseconds = 60_000 * minute + np.arange(n_lines)
    slow_time = np.datetime64("2012-01-01", "ns") + milliseconds * np.timedelta64(1, "ms")
    twtt = layer_bins * bin_s
    frame = echogram(
        power,
        twtt=bin_s * np.arange(len(power)),
        slow_time=slow_time,
        Latitude=latitude,
        Longitude=np.full(n_lines, -40.0),
        Elevation=np.zeros(n_lines),
        Surface=twtt[0],
    )
    return frame, placeholder_layers(twtt, slow_time)


def placeholder_layers(twtt, slow_time):
    """Layers at travel times (layer, range_line) [s], all of them good and automatic."""
    dims = ("layer", "slow_time")
    variables = {"twtt": (dims, twtt, {"units": "s"})}
    for name, code in (("quality", 1), ("type", 2)):
        variables[name] = (dims, np.full(twtt.shape, code, dtype=np.uint8))
    return xr.Dataset(variables, {"slow_time": slow_time})
