"""Blocks of 256 range lines: level frames to scenes by the rule of the published benchmark, and scenes to frames."""

import numpy as np
import xarray as xr

from snowsim.constants import BLOCK_LINES, EARTH_RADIUS_M
from snowsim.echogram import (
    SURFACE_ROW,
    Scene,
    bin_size_s,
    check_echogram,
    check_layers,
    from_uint8,
    layer_bins_of,
    scene_height,
    to_uint8,
)

OVERLAP_LINES = 6
UNFIT = "range lines flagged unfit"  # how a block with such lines is told
METRES_PER_DEGREE = EARTH_RADIUS_M * np.pi / 180  # of latitude, on the sphere of `echogram.along_track_m`


def cut_blocks(echogram, layers, *, name, n_range_lines=BLOCK_LINES, overlap=OVERLAP_LINES):
    """Scenes of a level frame by the rule of the published benchmark.

    Blocks of 256 lines overlap by 6; each is cropped so that the surface lies in row 50, and ends 100 rows below its
    last layer but holds 300 rows at least; each is scaled to 8 bits by itself. Lines left over at the end are not used.

    Parameters
    ----------
    echogram, layers : xarray.Dataset
        Level (`flatten`), on the same range lines, layer 0 the snow surface. A block with one line that is `unfit`
        (`leave_out_unfit`) is no scene: an image has no room for gaps.
    name : str
        Of the frame; scenes are called ``{name}_{block:03d}``.
    n_range_lines, overlap : int
        Width of a block, and how many lines it shares with the next.

    Returns
    -------
    scenes : list of Scene
        Layers without a pick in a block are left out of it, but not the surface. `notes` tell `first_line`,
        `first_twtt_s` and `bin_size_s`.
    skipped : dict
        Name of every block that is no scene, and why: unfit lines, no surface, or missing pixels.

    Raises
    ------
    ValueError
        If the frame is narrower than a block, or the overlap is not smaller than its width.
    """
    if not 0 <= overlap < n_range_lines:
        msg = f"overlap must lie in [0, {n_range_lines}), got {overlap}"
        raise ValueError(msg)
    layer_bins = layer_bins_of(layers, echogram)
    power = echogram["Data"].transpose("twtt", "slow_time").values
    if power.shape[1] < n_range_lines:
        msg = f"{name}: a block has {n_range_lines} range lines, the frame only {power.shape[1]}"
        raise ValueError(msg)
    first_s, bin_s = float(echogram["twtt"].values[0]), bin_size_s(echogram)
    unfit = echogram["unfit"].values if "unfit" in echogram else np.zeros(power.shape[1], dtype=bool)
    scenes, skipped = [], {}
    starts = range(0, power.shape[1] - n_range_lines + 1, n_range_lines - overlap)
    for block, start in enumerate(starts):
        lines = slice(start, start + n_range_lines)
        scene_name = f"{name}_{block:03d}"
        bins = layer_bins[:, lines]
        if unfit[lines].any():
            skipped[scene_name] = f"{int(unfit[lines].sum())} of {n_range_lines} {UNFIT}"
            continue
        if not np.isfinite(bins[0]).any():
            skipped[scene_name] = "the surface is not picked"
            continue
        top = int(np.floor(np.nanmedian(bins[0]) + 0.5)) - SURFACE_ROW
        bins = bins[np.isfinite(bins).any(axis=1)] - top
        bottom = top + scene_height(bins)
        if top < 0 or bottom > power.shape[0]:
            skipped[scene_name] = f"rows {top} to {bottom} wanted of {power.shape[0]}"
            continue
        block_power = power[top:bottom, lines]
        missing = ~((block_power > 0) & np.isfinite(block_power))
        if missing.any():
            skipped[scene_name] = f"{int(missing.sum())} pixels without a measurement"
            continue
        image, noise_floor_db, maximum_db = to_uint8(block_power)
        notes = {"first_line": start, "first_twtt_s": first_s + top * bin_s, "bin_size_s": bin_s}
        scenes.append(
            Scene(
                name=scene_name,
                n_range_bins=bottom - top,
                layer_bins=bins,
                image=image,
                noise_floor_db=noise_floor_db,
                maximum_db=maximum_db,
                notes=notes,
            )
        )
    return scenes, skipped


def frame_of_scene(scene, *, bin_s, line_spacing_m, contrast_db=None):
    """Echogram and layers of a scene, so that statistics can be fitted to a benchmark of images.

    Positions and times are placeholders: a line due north from (70, -40) at one line a millisecond. Power comes back
    from 8 bits in steps of a 255th of the contrast.

    Parameters
    ----------
    scene : Scene
        With an image.
    bin_s : float
        Bin size in two-way travel time [s]; images do not tell.
    line_spacing_m : float
        Distance between range lines [m].
    contrast_db : float, optional
        From the noise floor to the maximum [dB], for scenes that do not tell: 8-bit 255 is then this far above it.

    Returns
    -------
    echogram, layers : xarray.Dataset
        Passing `check_echogram` and `check_layers`.

    Raises
    ------
    ValueError
        If the scene has no image, or neither it nor `contrast_db` tells what its grey levels stand for.
    """
    if scene.image is None:
        msg = f"{scene.name}: a frame needs an image, the scene has none"
        raise ValueError(msg)
    noise_floor_db, maximum_db = scene.noise_floor_db, scene.maximum_db
    if not np.isfinite([noise_floor_db, maximum_db]).all():
        if contrast_db is None:
            msg = f"{scene.name}: the image does not tell its decibels, so contrast_db must be set, got None"
            raise ValueError(msg)
        noise_floor_db, maximum_db = 0.0, float(contrast_db)
    n_lines = scene.n_range_lines
    lines = np.arange(n_lines)
    slow_time = np.datetime64("2012-01-01", "ns") + lines * np.timedelta64(1, "ms")
    twtt = bin_s * np.arange(scene.n_range_bins)
    power = (10 ** (from_uint8(scene.image, noise_floor_db, maximum_db) / 10)).astype(np.float32)
    layer_twtt = scene.layer_bins * bin_s
    along = {
        "Latitude": 70 + lines * line_spacing_m / METRES_PER_DEGREE,
        "Longitude": np.full(n_lines, -40.0),
        "Elevation": np.zeros(n_lines),
        "Surface": layer_twtt[0],
    }
    echogram = xr.Dataset(
        {"Data": (("twtt", "slow_time"), power), **{key: ("slow_time", values) for key, values in along.items()}},
        coords={"twtt": ("twtt", twtt, {"units": "s"}), "slow_time": slow_time},
        attrs={"source_format": "8-bit image", "name": scene.name},
    )
    layers = xr.Dataset(
        {
            "twtt": (("layer", "slow_time"), layer_twtt, {"units": "s"}),
            "quality": (("layer", "slow_time"), np.ones(layer_twtt.shape, dtype=np.uint8)),
            "type": (("layer", "slow_time"), np.full(layer_twtt.shape, 2, dtype=np.uint8)),
        },
        coords={"slow_time": slow_time},
    )
    check_echogram(echogram, scene.name)
    check_layers(layers, scene.name)
    return echogram, layers
