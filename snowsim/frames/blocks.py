"""Level frames cut into scenes by the rule of the published benchmark, and scenes as frames."""

import numpy as np
import xarray as xr

from snowsim.constants import BLOCK_LINES, EARTH_RADIUS_M
from snowsim.echogram import (
    SURFACE_ROW,
    Scene,
    bin_size_s,
    from_uint8,
    layer_bins_of,
    scene_height,
    to_uint8,
)

OVERLAP_LINES = 6
FLAGGED = "range lines flagged"  # last words of the reason why such a block is skipped
# Metres in a degree of latitude, on the sphere that `echogram.along_track_m` uses.
METRES_PER_DEGREE = EARTH_RADIUS_M * np.pi / 180


def cut_blocks(echogram, layers, *, name):
    """Cut a level frame into scenes as the published benchmark does.

    Blocks have 256 lines and overlap by 6; lines left over at the end are not used. A scene is a
    cropped block: the surface, layer 0, lies in its row 50, it ends 100 rows below its last layer
    and has at least 300 rows. Each scene is scaled to 8 bits by itself and called
    ``{name}_{block:03d}``; its `notes` hold `first_line`, `first_twtt_s` and `bin_size_s`. Layers
    without a pick in a block are left out of its scene.

    An image has no room for gaps. A block is therefore skipped if it has a line `flagged` by
    `leave_out_flagged`, no pick of the surface, missing pixels, or rows outside the frame. Returns
    the list of scenes, and a dict of the reason for each skipped block by its name.
    """
    layer_bins = layer_bins_of(layers, echogram)
    power = echogram["Data"].transpose("twtt", "slow_time").values
    flagged = np.zeros(power.shape[1], dtype=bool)
    if "flagged" in echogram:
        flagged = echogram["flagged"].values
    first_s = float(echogram["twtt"].values[0])
    bin_s = bin_size_s(echogram)
    scenes = []
    skipped = {}
    starts = range(0, power.shape[1] - BLOCK_LINES + 1, BLOCK_LINES - OVERLAP_LINES)
    for block, start in enumerate(starts):
        lines = slice(start, start + BLOCK_LINES)
        scene_name = f"{name}_{block:03d}"
        bins = layer_bins[:, lines]
        reason = _why_no_scene(power[:, lines], bins, flagged[lines])
        if reason:
            skipped[scene_name] = reason
            continue
        top, bottom = _rows(bins)
        image, noise_floor_db, maximum_db = to_uint8(power[top:bottom, lines])
        scene = Scene(
            scene_name,
            bottom - top,
            _picked(bins) - top,
            image=image,
            noise_floor_db=noise_floor_db,
            maximum_db=maximum_db,
            notes={"first_line": start, "first_twtt_s": first_s + top * bin_s, "bin_size_s": bin_s},
        )
        scenes.append(scene)
    return scenes, skipped


def _why_no_scene(power, bins, flagged):
    """Why a block is no scene, in words, or None."""
    if flagged.any():
        return f"{int(flagged.sum())} of {flagged.size} {FLAGGED}"
    if not np.isfinite(bins[0]).any():
        return "the surface is not picked"
    top, bottom = _rows(bins)
    if top < 0 or bottom > power.shape[0]:
        return f"rows {top} to {bottom} wanted of {power.shape[0]}"
    cropped = power[top:bottom]
    n_missing = int((~((cropped > 0) & np.isfinite(cropped))).sum())
    return f"{n_missing} pixels without a measurement" if n_missing else None


def _rows(bins):
    """First row of a block's scene, 50 rows above the surface, and the row after its last."""
    top = int(np.floor(np.nanmedian(bins[0]) + 0.5)) - SURFACE_ROW
    return top, top + scene_height(_picked(bins) - top)


def _picked(bins):
    """Layers with a pick."""
    return bins[np.isfinite(bins).any(axis=1)]


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
    echogram, layers = placeholder_frame(power, scene.layer_bins, latitude, bin_s=bin_s)
    return echogram.assign_attrs(source_format="8-bit image", name=scene.name), layers


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
    echogram = xr.Dataset(
        {
            "Data": (("twtt", "slow_time"), power),
            "Latitude": ("slow_time", latitude),
            "Longitude": ("slow_time", np.full(n_lines, -40.0)),
            "Elevation": ("slow_time", np.zeros(n_lines)),
            "Surface": ("slow_time", twtt[0]),
        },
        coords={
            "twtt": ("twtt", bin_s * np.arange(len(power)), {"units": "s"}),
            "slow_time": slow_time,
        },
    )
    dims = ("layer", "slow_time")
    layers = xr.Dataset(
        {
            "twtt": (dims, twtt, {"units": "s"}),
            "quality": (dims, np.full(twtt.shape, 1, dtype=np.uint8)),
            "type": (dims, np.full(twtt.shape, 2, dtype=np.uint8)),
        },
        {"slow_time": slow_time},
    )
    return echogram, layers
