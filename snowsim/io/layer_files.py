"""Layers of a tracker as layer files that the field's own tools read."""

import io
import re
from pathlib import Path

import numpy as np
import scipy.io

from snowsim.echogram import check_layers
from snowsim.io.datasets import LEAP_DAYS, PARAMETERS
from snowsim.io.files import write_bytes, write_dataset
from snowsim.io.guard import library_errors, refusal
from snowsim.io.layers import AUTOMATIC, GOOD, SURFACE

# MAT v5 begins with a text of this length. The date that scipy writes there would make the bytes
# of the same layers differ.
HEADER_BYTES = 116
HEADER = b"MATLAB 5.0 MAT-file, layers by snowsim".ljust(HEADER_BYTES)
VERSION = "1"
POSITIONS = {"lat": "Latitude", "lon": "Longitude", "elev": "Elevation"}
# Segment and frame in a name: Data_20120330_04_001.mat, IRSNO1B_20120330_04_001_deconv.nc.
NAMED = re.compile(r"(\d{8}_\d{2})_(\d{3})(?!\d)")
GROUP_OF_SURFACE = "standard"
GROUP = "snowsim"


def named_frame(path):
    """Segment and number of the frame that a file's name tells, (None, None) if it tells none."""
    named = NAMED.search(Path(path).stem)
    return (named[1], int(named[2])) if named else (None, None)


def write_layer_files(folder, segment, frames, *, force=False):
    """Write layers of a segment as CReSIS layer files, in `folder/CSARP_layer/segment`.

    `Data_SEGMENT_FFF.mat` for each frame, and `layer_SEGMENT.mat`, which names the layers of all.
    Layer 0 is the surface; layer i is `snow_i`. Every file holds all layers of the segment, also
    those without a pick in its frame: xopr joins frames only if they have the same.

    Parameters
    ----------
    folder : path_like
        Where the tree begins.
    segment : str
        Day and number, such as "20120330_04".
    frames : mapping of int to xarray.Dataset
        By number of the frame: `twtt` [s], `quality` (1 good, 2 moderate, 3 bad), `type` (1 manual,
        2 automatic) on (layer, slow_time), and `Latitude`, `Longitude`, `Elevation` along
        slow_time. Where there is a coordinate `layer`, it names them, surface and snow_i, else
        layers are numbered as they come. A frame may lack layers that others have.
    force : bool
        Replace files that are there.

    Returns
    -------
    list of Path
        What was written, the organizer last.

    Raises
    ------
    ValueError
        If a file is there and `force` is not set; if the folder holds layer files of other frames,
        whose layers the organizer would name anew; if layers cross, or a variable is missing.
    """
    refuse_other_frames(folder, segment, frames)
    n_layers = 1 + max(int(layer_numbers(layers).max()) for layers in frames.values())
    contents = {}
    for number, layers in frames.items():
        path = _frame_path(folder, segment, number)
        check_layers(layers, str(path))
        with library_errors(path, "layers: expected with positions along slow_time"):
            contents[path] = _frame_content(segment, layers, n_layers)
    attributes = next(iter(frames.values())).attrs
    organizer = _parent(folder, segment) / f"layer_{segment}.mat"
    contents[organizer] = _organizer_content(segment, attributes, n_layers)
    for path in contents if not force else ():
        refuse_existing(path)
    for path, content in contents.items():
        buffer = io.BytesIO()
        scipy.io.savemat(buffer, content, do_compression=True)
        write_bytes(path, HEADER + buffer.getvalue()[HEADER_BYTES:])
    return list(contents)


def layer_numbers(layers):
    """Number of every layer of a dataset by its name, 0 the surface; else as they come.

    ValueError for names that are no such numbers: a layer file would not keep them.
    """
    if "layer" not in layers.coords:
        return np.arange(layers.sizes["layer"])
    numbers = []
    for name in map(str, layers["layer"].values):
        digits = "0" if name == SURFACE else name.removeprefix("snow_")
        if not digits.isdecimal():
            msg = f"layer: expected {SURFACE}, snow_1, snow_2 and so on, found {name!r}"
            raise ValueError(msg)
        numbers.append(int(digits))
    return np.array(numbers)


def refuse_other_frames(folder, segment, numbers):
    """Refuse to track frames of a segment into a folder that holds layer files of others of it.

    One organizer names the layers of all.
    """
    own = {_frame_path(folder, segment, number) for number in numbers}
    parent = _parent(folder, segment)
    others = sorted(set(parent.glob(f"Data_{segment}_*.mat")) - own)
    if others:
        wanted = "those of the frames tracked alone (track all frames of the segment at once, or "
        raise refusal(parent, "layer files", wanted + "to another folder)", others[0].name)


def _parent(folder, segment):
    return Path(folder) / "CSARP_layer" / segment


def _frame_path(folder, segment, number):
    return _parent(folder, segment) / f"Data_{segment}_{number:03d}.mat"


def write_layers(path, layers, *, force=False):
    """Write the same layers of one frame as NetCDF, with all that the dataset has along."""
    if not force:
        refuse_existing(path)
    write_dataset(path, layers, compress=True)


def refuse_existing(path):
    """Refuse to write over a file that is there."""
    if Path(path).exists():
        raise refusal(path, "file", "none to be there, or force", "one")


def gps_seconds(slow_time):
    """GPS seconds since 1970 of UTC times, (range_line,): the inverse of `utc_times`.

    Equal to the seconds that the times were read from to the last bit: doubles of this age lie
    2.4e-7 s apart, and nanoseconds round by less. One offset holds for a file, that of its first
    line; a first line within a leap second itself, which UTC writes as the next, is taken for that.
    """
    nanoseconds = np.asarray(slow_time, dtype="datetime64[ns]").astype(np.int64)
    days = np.array(LEAP_DAYS, dtype="datetime64[ns]").astype(np.int64)
    offset = int(np.searchsorted(days, nanoseconds[0], side="right"))
    whole, rest = np.divmod(nanoseconds, 1_000_000_000)
    return (whole + offset) + rest * 1e-9


def _frame_content(segment, layers, n_layers):
    """Variables of a frame's layer file, shaped as MATLAB has them."""
    shape = (n_layers, layers.sizes["slow_time"])
    numbers = layer_numbers(layers)
    twtt = np.full(shape, np.nan)
    twtt[numbers] = layers["twtt"].transpose("layer", "slow_time").values
    content = {
        "file_type": "layer",
        "file_version": VERSION,
        "gps_time": gps_seconds(layers["slow_time"].values)[None],
        "id": 1.0 + np.arange(n_layers)[None],
        "twtt": twtt,
        "param": _parameters(segment, layers.attrs),
    }
    for theirs, ours in POSITIONS.items():
        content[theirs] = layers[ours].values.astype(float)[None]
    for name, absent in (("quality", GOOD), ("type", AUTOMATIC)):
        flags = np.full(shape, absent)
        flags[numbers] = layers[name].transpose("layer", "slow_time").values
        content[name] = np.where(np.isfinite(twtt), flags, absent).astype(np.uint8)
    return content


def _organizer_content(segment, attributes, n_layers):
    """Variables of the file that names the layers of a segment."""
    numbers = 1.0 + np.arange(n_layers)[None]
    below = range(1, n_layers)
    nothing = [np.empty((0, 0), dtype=object)] * n_layers
    return {
        "file_type": "layer_organizer",
        "file_version": VERSION,
        "lyr_age": np.full((1, n_layers), np.nan),
        "lyr_age_source": _cell(nothing),
        "lyr_desc": _cell(["snow surface", *("snow layer, tracked" for _ in below)]),
        "lyr_group_name": _cell([GROUP_OF_SURFACE, *(GROUP for _ in below)]),
        "lyr_id": numbers,
        "lyr_name": _cell([SURFACE, *(f"snow_{layer}" for layer in below)]),
        "lyr_order": numbers,
        "param": _parameters(segment, attributes),
    }


def _parameters(segment, attributes):
    """Struct `param`: radar, season and segment, as far as the echogram tells."""
    known = {name: str(attributes.get(name, "")) for name in PARAMETERS}
    return known | {"day_seg": segment, "sw_version": {"ver": "snowsim"}}


def _cell(values):
    """A row of MATLAB cells."""
    row = np.empty((1, len(values)), dtype=object)
    for column, value in enumerate(values):
        row[0, column] = value
    return row
