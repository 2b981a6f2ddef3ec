"""Files of every format, opened once; and the contract of the readers that stand on this.

What comes in: the path of a file or Zarr store, or its `Stored` from `open_container`, so that no
file is read twice. The format follows from the names of the variables (`FORMATS`), never from the
file's name.

What comes out: an `xarray.Dataset` in memory, in the Open Polar Radar convention. `read_echogram`
returns what `snowsim.echogram.check_echogram` accepts, `read_layers` what `check_layers` accepts:
UTC in `slow_time`, seconds in `twtt`, linear power in `Data`, NaN where nothing was recorded or
picked.

Errors: a ValueError of one line, ``file: variable: expected ..., found ...``, whatever library
raised it (`one_line_errors`). A file that can be read but is doubtful gives a `UserWarning`.

`read_echogram` and `read_layers` are the doors. Behind them one function reads each format: it
takes a `Stored` whose variables `format_of` found complete, and leaves errors to its door.
"""

import math
import re
import struct
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial, wraps
from io import BytesIO
from pathlib import Path
from typing import Any, TypeVar

import netCDF4
import numpy as np
import scipy
import xarray as xr
from numpy.exceptions import ComplexWarning

from snowsim.echogram import MAXIMUM_BYTES
from snowsim.io.files import (
    content_of,
    is_zarr,
    library_errors,
    picture_format,
    refusal,
    write_bytes,
)
from snowsim.io.missing import with_one_fill
from snowsim.io.times import utc_times

SUPPLEMENT_FLAGS = (
    "coh_noise_removal_artifact",
    "deconvolution_artifact",
    "vertical_stripes_artifact",
    "missing_data",
    "no_good_data",
    "low_SNR",
    "unclassified_artifact",
    "land_ice",
)
POSITION = ("Latitude", "Longitude", "Elevation")
# By format: its name in words, and the variables that it needs. A file has the format for which it
# holds the largest share of the variables; in a tie the earlier entry wins.
FORMATS = {
    "nsidc": ("an IRSNO1B echogram", ("amplitude", "fasttime", "time", "lat", "lon", "altitude")),
    "opr": ("an Open Polar Radar echogram", ("Data", "slow_time", "twtt", *POSITION)),
    "opr_layers": ("Open Polar Radar layers", ("twtt", "slow_time", "quality", "type")),
    "cresis": ("a CReSIS L1B echogram", ("Data", "Time", *POSITION, "GPS_time")),
    "cresis_layer": ("CReSIS layers", ("twtt", "id", "gps_time")),
    "cresis_layer_data": ("old CReSIS layers", ("layerData", "GPS_time")),
    "organizer": ("a CReSIS layer organizer", ("lyr_id", "lyr_name")),
    "scenes": ("a set of scenes", ("layer_bins", "n_range_bins", "n_layers")),
    "scene": ("one scene (xarray opens it; export its scene set)", ("layer_bins", "mask")),
    "statistics": ("statistics of a flight", ("peak_power", "variance_bins2", "zone_edge_bins")),
}
ECHOGRAMS = ("nsidc", "cresis", "opr")
LAYERS = ("cresis_layer", "cresis_layer_data", "opr_layers")
# Below this share of its variables a file has no known format. Above it, the missing variables are
# named in the error.
SMALLEST_SHARE = 0.4

# Units of travel times that have no attribute `units`; then the length of each unit in seconds.
TRAVEL_TIMES = {
    "twtt": "s",
    "fasttime": "us",
    **dict.fromkeys(("Surface", "Bottom", "peak_twtt", "twtt_low", "twtt_high"), "s"),
}
SECONDS = {
    "s": 1.0,
    "sec": 1.0,
    "second": 1.0,
    "seconds": 1.0,
    "microseconds": 1e-6,
    "us": 1e-6,
    "nanoseconds": 1e-9,
    "ns": 1e-9,
}
# Variables of positions that become degrees where their attribute `units` says radians.
ANGLES = ("Latitude", "Longitude", "lat", "lon")
RADIANS = ("radian", "radians", "rad")
HEIGHTS = ("Elevation", "altitude")
NO_METRES = ("km", "kilometers", "kilometres", "cm", "mm", "ft", "foot", "feet")
# Units of time that CF allows, by the names that xarray decodes itself. It decodes others with
# cftime, which takes any time zone for UTC.
TIMES = {"s": "seconds", "sec": "seconds", "min": "minutes", "h": "hours", "d": "days"}
# Reference dates of times: year, month and day in this order, then UTC or an offset from it. pandas
# takes 05-08-2000 for the eighth of May, and 00:00 2:00 for a time of day.
SINCE_DATE = re.compile(
    r"\s*\d{4}-\d{1,2}-\d{1,2}([T ]+\d{1,2}:\d{1,2}(:\d{1,2}(\.\d*)?)?)?"
    r"\s*(Z|UTC|GMT|[+-]\d{1,2}(:?\d{2})?)?\s*",
    re.IGNORECASE,
)
# The calendars of dates since 1582 as everyone counts them.
CALENDARS = ("standard", "gregorian", "proleptic_gregorian")
TIME_AXES = ("slow_time", "time")
# Attributes of xopr's datasets, whose `slow_time` is GPS time, and of ours, whose is UTC.
TELL_GPS = {"granule", "mimetype", "source_url"}
TELL_UTC = {"source_format", "synthetic", "tracker"}

NETCDF3, HDF5 = b"CDF", b"\x89HDF\r\n\x1a\n"
CDF5 = b"CDF\x05"  # scipy does not read it
USER_BLOCK_BYTES = 512  # in front of the HDF5 data of a MAT v7.3 file
# The header of a MAT v5 file: text first, the byte order last. The text of scipy has a date, by
# which two files of the same content would differ.
MAT_HEADER_BYTES = 128
MAT_TAG_BYTES = 8  # of a variable
TEXT_BYTES = 116
BYTE_ORDERS = (b"\x00\x01IM", b"\x01\x00MI")
MOST = f"at most {MAXIMUM_BYTES} bytes"
KINDS = "MAT v5, MAT v7.3, NetCDF or Zarr"
# Start of a global heap of HDF5, version 1, and header bytes of a heap and of each object in it:
# HDF5 File Format Specification, III.E.
HEAP = re.compile(b"GCOL\x01")
HEAP_HEADER_BYTES = 16
VALUE_BYTES = 10_000  # least cost of a value in a struct or cell: a file may have 100,000 of them
NUMBER_BYTES = 4  # size of a number in most large variables (single precision)


Function = TypeVar("Function", bound=Callable[..., Any])


@dataclass(frozen=True)
class Stored:
    """An opened file: its path, the names of its variables, and a function that reads them.

    `read()` returns the whole dataset of a NetCDF file or Zarr store, whatever names it is given.
    `read(names)` returns a dict of the variables of a MAT file, without names that the file lacks.
    """

    path: Path
    names: frozenset
    read: Callable


def one_line_errors(expected: str = "expected a whole file") -> Callable[[Function], Function]:
    """Decorator of a function of a path or `Stored`: what it raises is one line with the path."""

    def decorated(read):
        @wraps(read)
        def read_or_refuse(path, *args, **options):
            where = path.path if isinstance(path, Stored) else Path(path)
            with library_errors(where, expected):
                return read(path, *args, **options)

        return read_or_refuse

    return decorated


@one_line_errors(f"content: expected {KINDS}")
def open_container(path, content=None):
    """`Stored` of a file of MAT v5, MAT v7.3 or NetCDF, or of a Zarr store.

    The file is read once, and not at all if its bytes are given as `content`. A `Stored` is
    returned as it is.
    """
    if isinstance(path, Stored):
        return path
    path = Path(path)
    content = content_of(path) if content is None else content
    picture = picture_format(content)
    if picture:
        raise refusal(path, "content", KINDS, f"a {picture} image")
    if path.is_dir() and not is_zarr(path):
        raise refusal(path, "content", KINDS, "a folder: name the files in it")
    if path.is_dir():
        return _labelled(path, path, engine="zarr", consolidated=False)
    if content.startswith(CDF5):
        found = "NetCDF classic of 64-bit data, CDF-5 (nccopy -k nc4 OLD NEW converts it)"
        raise refusal(path, "content", KINDS, found)
    if content.startswith(NETCDF3):
        # Not by netCDF4: it never returned on 3 of 400 damaged files.
        return _labelled(path, BytesIO(content), engine="scipy")
    if content.startswith(HDF5):
        check_heaps(content)
        # Not by the file's name, which need not be text that netCDF can encode.
        file = netCDF4.Dataset("in memory", memory=content)
        # Sizes are checked as declared, before xarray reads coordinates.
        held = file.variables.values()
        sizes = [each.size * getattr(each.dtype, "itemsize", 8) for each in held]
        if sum(sizes) > MAXIMUM_BYTES:
            raise refusal(path, "variables", MOST, sum(sizes))
        # With a named engine xarray does not search for the packages of all others.
        return _labelled(path, xr.backends.NetCDF4DataStore(file), engine="store")
    if content[USER_BLOCK_BYTES:].startswith(HDF5):
        check_heaps(content)
        import h5py  # not above: it loads slowly, and few files need it

        # In memory: an error that keeps a file object open would crash Python at its end.
        file = h5py.File.in_memory(content)
        return Stored(path, frozenset(file), partial(_read_mat73, file))
    if content[MAT_HEADER_BYTES - 4 : MAT_HEADER_BYTES] not in BYTE_ORDERS:
        raise refusal(path, "content", KINDS, f"{len(content)} other bytes")
    _check_whole_mat5(path, content)
    file = BytesIO(content)
    shapes = {name: shape for name, shape, _ in scipy.io.whosmat(file)}
    return Stored(path, frozenset(shapes), partial(_read_mat5, file, shapes))


def _check_whole_mat5(path, content):
    """Refuse a MAT v5 file that is cut off: scipy leaves out its last variables without a word."""
    order = "<" if content[MAT_HEADER_BYTES - 2 : MAT_HEADER_BYTES] == b"IM" else ">"
    end = MAT_HEADER_BYTES
    while end + MAT_TAG_BYTES <= len(content):
        # A variable has a tag, its type and its size.
        end += MAT_TAG_BYTES + struct.unpack_from(f"{order}4xI", content, end)[0]
    if end != len(content):
        raise refusal(
            path, "content", "a whole MAT v5 file", f"one cut off at {len(content)} bytes"
        )


def format_of(stored, kinds=FORMATS):
    """Format of a file by the names of its variables, a key of `FORMATS`.

    ValueError if the format is not among `kinds`, or if variables of the format are missing.
    """
    names = stored.names
    if "UTC_time" in names:
        names = names | {"GPS_time"}  # older files have UTC_time instead
    share = {kind: len(names & {*needed}) / len(needed) for kind, (_, needed) in FORMATS.items()}
    kind = max(share, key=share.get)
    found = ", ".join(sorted(names)) or "none"
    if share[kind] < SMALLEST_SHARE:
        raise refusal(stored.path, "variables", "those of an echogram or of layers", found)
    if kind not in kinds:
        expected = " or ".join(in_words(kind) for kind in kinds)
        raise refusal(stored.path, "format", expected, in_words(kind))
    needed = FORMATS[kind][1]
    missing = ", ".join(name for name in needed if name not in names)
    if missing and kind in (*ECHOGRAMS, *LAYERS):
        raise refusal(stored.path, missing, f"variables {', '.join(needed)}", found)
    return kind


def in_words(kind):
    """Name of a format in messages."""
    return FORMATS[kind][0]


@one_line_errors()
def read_values(path, names=None):
    """Variables of a file as `Stored.read` gives them."""
    return open_container(path).read(names)


def check_heaps(content):
    """Raise ValueError for a heap whose objects overrun it: HDF5 2.2 would never return.

    Heaps hold text and lists of references. 3 of 1600 damaged NetCDF files had such a heap.
    """
    for heap in HEAP.finditer(content):
        (length,) = struct.unpack_from("<Q", content, heap.start() + 8)
        end = heap.start() + length
        offset = heap.start() + HEAP_HEADER_BYTES
        while offset + HEAP_HEADER_BYTES <= end:
            index, size = struct.unpack_from("<H6xQ", content, offset)
            # The size of the free space, object 0, includes its header.
            step = size if index == 0 else HEAP_HEADER_BYTES + -(-size // 8) * 8
            offset += step
            if step < HEAP_HEADER_BYTES or offset > end:
                raise refusal(None, "HDF5", "heaps that hold their objects", f"one of {length}")


def _labelled(path, source, **how):
    """`Stored` of a NetCDF file or Zarr store, decoded by its CF attributes.

    Travel times become seconds, and positions in radians degrees. `slow_time` of xopr, which
    includes leap seconds, becomes UTC. What is declared as missing, and floats that were never
    written, become NaN. Durations stay numbers: rounded to nanoseconds, range bins would be lost.
    """
    dataset = xr.open_dataset(source, decode_cf=False, **how)
    if dataset.nbytes > MAXIMUM_BYTES:
        raise refusal(path, "variables", MOST, dataset.nbytes)
    filled = {name: with_one_fill(path, name, each) for name, each in dataset.variables.items()}
    changed = {name: each for name, each in filled.items() if each is not dataset.variables[name]}
    dataset = dataset.assign(changed)
    for name, variable in dataset.variables.items():
        if "units" in variable.attrs:
            variable.attrs["units"] = _text_of(variable.attrs["units"])
        unit, since, day = variable.attrs.get("units", "").partition(" since ")
        if since and unit in TIMES:
            variable.attrs["units"] = f"{TIMES[unit]}{since}{day}"
        if since and name in TIME_AXES:
            _check_dates(path, name, day, variable.attrs)
    times = xr.coders.CFDatetimeCoder(use_cftime=False)
    try:
        decoded = xr.decode_cf(dataset, decode_times=times, decode_timedelta=False)
    except (ValueError, OverflowError) as error:
        for name, variable in dataset.variables.items():
            units = str(variable.attrs.get("units", ""))
            if " since " in units and units in str(error):
                raise refusal(path, name, "units of time that CF allows", repr(units)) from error
        raise
    is_gps = not TELL_GPS.isdisjoint(decoded.attrs) and TELL_UTC.isdisjoint(decoded.attrs)
    if is_gps and "slow_time" in decoded:
        utc = utc_times(decoded["slow_time"], gps=True)
        decoded = decoded.assign_coords(slow_time=utc).assign_attrs(source_format="xopr")
    _convert_units(path, decoded)
    # The whole dataset for any names: it can be indexed by name like the dict of a MAT file.
    return Stored(path, frozenset(decoded.variables), lambda _=None: _loaded(decoded))


def _convert_units(path, decoded):
    """Convert travel times of a dataset to seconds, and positions in radians to degrees."""
    for name in TRAVEL_TIMES.keys() & decoded.variables.keys():
        unit = str(decoded[name].attrs.get("units", "")).strip().lower() or TRAVEL_TIMES[name]
        if unit not in SECONDS:
            raise refusal(path, name, ", ".join(SECONDS), unit)
        if SECONDS[unit] != 1:
            seconds = _written(decoded[name].values) * SECONDS[unit]
            decoded[name] = (decoded[name].dims, seconds, {"units": "s"})
    for name in decoded.variables.keys() & {*ANGLES}:
        angle = decoded[name]
        if str(angle.attrs.get("units", "")).strip().lower() in RADIANS:
            decoded[name] = (angle.dims, np.degrees(_written(angle.values)), {"units": "degrees"})
    for name in decoded.variables.keys() & {*HEIGHTS}:
        unit = str(decoded[name].attrs.get("units", "")).strip().lower()
        if unit in NO_METRES:
            raise refusal(path, name, "metres", unit)


def _text_of(attribute):
    """Text of an attribute, without the blanks, NUL or list of one text that some writers add."""
    return " ".join(map(str, np.ravel(attribute))).replace("\0", "").strip()


def _check_dates(path, name, day, attributes):
    """Refuse dates in another calendar, or counted from a day that can be read in two ways."""
    calendar = attributes.get("calendar", CALENDARS[0])
    if str(calendar).lower() not in CALENDARS:
        raise refusal(path, f"{name}: calendar", ", ".join(CALENDARS), repr(calendar))
    if not SINCE_DATE.fullmatch(day):
        expected = "units of time since YYYY-MM-DD hh:mm:ss, in UTC or with an offset as +02:00"
        raise refusal(path, name, expected, repr(attributes["units"]))


def _loaded(dataset):
    """Dataset in memory, with NaN for floats that were never written."""
    dataset = dataset.load()
    for name in dataset.variables.keys() - dataset.xindexes.keys():
        values = dataset[name].values
        written = _written(values)
        if written is not values:
            dataset[name].values = written
    return dataset


def _written(values):
    """Values with NaN for the number that the netCDF library stores where nothing was written.

    A file need not declare this number, 9.97e36. Other types than single and double precision have
    others, which may be measured values; they are not changed.
    """
    if values.dtype.str[1:] not in ("f4", "f8"):
        return values
    unwritten = values == values.dtype.type(netCDF4.default_fillvals["f8"])
    return np.where(unwritten, values.dtype.type(np.nan), values) if unwritten.any() else values


def _read_mat5(file, shapes, names):
    """Named variables of a MAT v5 file: a struct is a dict, a cell a list, empty ones are left out.

    Arrays lose axes of length 1.
    """
    names = [name for name in names if name in shapes]
    for name in names:
        n_bytes = NUMBER_BYTES * math.prod(shapes[name])
        if n_bytes > MAXIMUM_BYTES:
            raise refusal(None, name, MOST, n_bytes)
    with warnings.catch_warnings():
        # With `mat_dtype` scipy drops imaginary parts and only warns: this is made an error.
        warnings.simplefilter("error", ComplexWarning)
        values = scipy.io.loadmat(file, variable_names=names, mat_dtype=True, simplify_cells=True)
    return {name: values[name] for name in names if getattr(values[name], "size", 1)}


def _read_mat73(file, names):
    """Named variables of a MAT v7.3 file, as those of `_read_mat5`."""
    read = [0]
    values = {name: _plain(file[name], read) for name in names if name in file}
    return {name: value for name, value in values.items() if getattr(value, "size", 1)}


def _plain(node, read):
    """Value of a variable of a MAT v7.3 file; `read[0]` counts the bytes read so far.

    The count has a limit, because a file may refer to the same value any number of times.
    """
    import h5py

    read[0] += VALUE_BYTES + getattr(node, "nbytes", 0)
    if read[0] > MAXIMUM_BYTES:
        raise refusal(None, node.name, MOST, read[0])
    if isinstance(node, h5py.Group):
        return {name: _plain(field, read) for name, field in node.items()}
    if node.is_virtual:
        # HDF5 gives zeros, without an error, for what it does not find in the other files.
        sources = sorted({source.file_name for source in node.virtual_sources()})
        expected = "its own values (h5repack copies them into the file)"
        raise refusal(None, node.name, expected, f"those of {', '.join(sources)}")
    is_text = node.attrs.get("MATLAB_class") == b"char"
    if node.attrs.get("MATLAB_empty", 0):
        # An empty variable stores its dimensions instead of values.
        return "" if is_text else np.empty(0)
    values = node[()]
    if node.dtype == h5py.ref_dtype:
        return [_plain(node.file[reference], read) for reference in values.ravel()]
    return "".join(map(chr, values.ravel())) if is_text else np.squeeze(values.T)


def write_matlab(path, what, content):
    """Write variables by name as MAT v5, whole or not at all; the file's header says `what`."""
    file = BytesIO()
    scipy.io.savemat(file, content, do_compression=True)
    text = f"MATLAB 5.0 MAT-file, {what} by snowsim".ljust(TEXT_BYTES)
    write_bytes(path, text.encode() + file.getvalue()[TEXT_BYTES:])
