"""Files opened once: their format by their content, and their variables."""

import io
import math
import mmap
import os
import pickle
import re
import resource
import struct
import subprocess
import sys
import warnings
from pathlib import Path

import h5py
import numpy as np
import scipy.io
import xarray as xr
from numpy.exceptions import ComplexWarning

from snowsim.io.files import (
    MAXIMUM_BYTES,
    Refused,
    library_errors,
    listed,
    refusal,
    write_bytes,
)

MAT_HEADER_BYTES = 128
COMPRESSED = 15  # type of a compressed element, in one of the four bytes behind the header
NUMBER_BYTES = 4  # size of a number in most large variables
SECONDS = 120  # limit of a child; no undamaged file takes as long


def read_mat5(path, names):
    """The named variables as a dict; arrays lose axes of length 1, structs become dicts."""
    with Path(path).open("rb") as file:
        if COMPRESSED in file.read(MAT_HEADER_BYTES + 4)[MAT_HEADER_BYTES:]:
            return load(path, names)
    command = [sys.executable, "-P", "-m", "snowsim.io.containers", str(path), *names]
    paths = {"PYTHONPATH": os.pathsep.join(sys.path), "OPENBLAS_NUM_THREADS": "1"}
    child = subprocess.run(
        command, capture_output=True, env=os.environ | paths, timeout=SECONDS, check=False
    )
    if child.returncode != 0:
        said = child.stderr.decode(errors="replace").splitlines() or [child.returncode]
        msg = f"expected a whole file, found one that ends its reader: {said[-1]}"
        raise Refused(msg)
    return pickle.loads(child.stdout)


def load(path, names):
    """The named variables as `read_mat5` gives them, read in this process."""
    for name, shape, _ in scipy.io.whosmat(path, appendmat=False):
        n_bytes = NUMBER_BYTES * math.prod(shape)
        if name in names and n_bytes > MAXIMUM_BYTES:
            msg = f"{name}: expected at most {MAXIMUM_BYTES} bytes, found {n_bytes} or more"
            raise Refused(msg)
    options = {"mat_dtype": True, "simplify_cells": True, "appendmat": False}
    with warnings.catch_warnings():
        # With `mat_dtype` scipy drops imaginary parts and only warns: make that an error.
        warnings.simplefilter("error", ComplexWarning)
        values = scipy.io.loadmat(path, variable_names=names, **options)
    return {name: values[name] for name in names}


if __name__ == "__main__":
    _, most = resource.getrlimit(resource.RLIMIT_AS)
    room = 4 * MAXIMUM_BYTES if most == resource.RLIM_INFINITY else min(4 * MAXIMUM_BYTES, most)
    resource.setrlimit(resource.RLIMIT_AS, (room, most))
    pickle.dump(load(sys.argv[1], sys.argv[2:]), sys.stdout.buffer, protocol=5)


# A heap of HDF5, version 1, and bytes in front of it and of each of its objects: HDF5 File Format
# Specification, III.E.
HEAP = re.compile(b"GCOL\x01")
HEADER_BYTES = 16
VALUE_BYTES = 10_000  # what a value in a struct or cell counts at least: 100000 of them in a file
NO_VARIABLE = "This is a netCDF dimension but not a netCDF variable"
KINDS = "MAT v5, MAT v7.3, NetCDF or Zarr"


def names_in(path):
    """Names of the variables a file holds."""
    path = Path(path)
    with library_errors(path, f"content: expected {KINDS}"):
        if path.is_dir():
            return {item.name for item in path.iterdir() if item.is_dir()}
        if h5py.is_hdf5(path):
            check_heaps(path)
            with h5py.File(path) as file:
                told = {name: str(node.attrs.get("NAME")) for name, node in file.items()}
            return {name for name, what in told.items() if NO_VARIABLE not in what}
        with path.open("rb") as file:
            is_netcdf = file.read(3) == b"CDF"
        if is_netcdf:
            with xr.open_dataset(path, engine="scipy", decode_cf=False) as dataset:
                return set(dataset.variables)
        return {name for name, _, _ in scipy.io.whosmat(path, appendmat=False)}


def check_heaps(path):
    """Refuse a heap whose objects overrun it: HDF5 2.2 walks it for ever.

    Heaps hold text and lists of references. Of 1600 damaged NetCDF files 5 had such a heap.
    """
    with (
        Path(path).open("rb") as file,
        mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as content,
    ):
        for heap in HEAP.finditer(content):
            (length,) = struct.unpack_from("<Q", content, heap.start() + 8)
            end = heap.start() + length
            offset = heap.start() + HEADER_BYTES
            while offset + HEADER_BYTES <= end:
                index, size = struct.unpack_from("<H6xQ", content, offset)
                # The free space, object 0, counts its own header.
                step = size if index == 0 else HEADER_BYTES + -(-size // 8) * 8
                offset += step
                if step < HEADER_BYTES or offset > end:
                    msg = f"HDF5: expected heaps that hold their objects, found one of {length}"
                    raise Refused(msg)


def read_netcdf(path):
    """Dataset of a NetCDF file or Zarr store.

    Values come as they are stored: no fill value, scale or time is applied.
    """
    with library_errors(path):
        names_in(path)  # refuses what HDF5 would read for ever
        engine = "zarr" if Path(path).is_dir() else "scipy"
        n_bytes = 0
        if h5py.is_hdf5(path):
            engine = "netcdf4"
            # As it is declared: xarray reads coordinates when it opens a file.
            with h5py.File(path) as file:
                n_bytes = sum(getattr(node, "nbytes", 0) for node in file.values())
        if n_bytes <= MAXIMUM_BYTES:
            with xr.open_dataset(path, engine=engine, decode_cf=False) as dataset:
                n_bytes = dataset.nbytes
                if n_bytes <= MAXIMUM_BYTES:
                    return dataset.load()
        msg = f"expected at most {MAXIMUM_BYTES} bytes, found {n_bytes}"
        raise Refused(msg)


def read_matlab(path, names):
    """Those of the named variables that a MAT file has.

    Numbers are arrays, squeezed; text is text, a struct a dict, a cell a list. Empty arrays are
    left out.
    """
    with library_errors(path):
        wanted = names_in(path).intersection(names)
        if h5py.is_hdf5(path):
            with h5py.File(path) as file:
                read = [0]
                values = {name: _plain(file[name], read) for name in sorted(wanted)}
        else:
            values = read_mat5(path, sorted(wanted))
    return {name: value for name, value in values.items() if getattr(value, "size", 1)}


def _plain(node, read):
    """A variable of a MAT v7.3 file; `read` counts bytes of the file that were read.

    A file may refer to the same value any number of times.
    """
    read[0] += VALUE_BYTES + getattr(node, "nbytes", 0)
    if read[0] > MAXIMUM_BYTES:
        msg = f"{node.name}: expected at most {MAXIMUM_BYTES} bytes, found more"
        raise Refused(msg)
    if isinstance(node, h5py.Group):
        return {name: _plain(field, read) for name, field in node.items()}
    is_text = node.attrs.get("MATLAB_class") == b"char"
    if node.attrs.get("MATLAB_empty", 0):
        # In place of its values an empty variable stores its dimensions.
        return "" if is_text else np.empty(0)
    values = node[()]
    if node.dtype == h5py.ref_dtype:
        return [_plain(node.file[reference], read) for reference in values.ravel()]
    return "".join(map(chr, values.ravel())) if is_text else np.squeeze(values.T)


# MAT v5 begins with a text of this length. The date that scipy writes there would make the bytes
# of the same content differ.
TEXT_BYTES = 116


def write_matlab(path, what, content):
    """Write variables by name as MAT v5, whole or not at all; the file's header says `what`."""
    buffer = io.BytesIO()
    scipy.io.savemat(buffer, content, do_compression=True)
    text = f"MATLAB 5.0 MAT-file, {what} by snowsim".ljust(TEXT_BYTES)
    write_bytes(path, text.encode() + buffer.getvalue()[TEXT_BYTES:])


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
# In words, and the variables that it needs. A file is what it has the largest share of; earlier
# entries win a tie.
FORMATS = {
    "nsidc": ("an IRSNO1B echogram", ("amplitude", "fasttime", "time", "lat", "lon", "altitude")),
    "cresis": ("a CReSIS L1B echogram", ("Data", "Time", *POSITION, "GPS_time")),
    "cresis_layer": ("CReSIS layers", ("twtt", "id", "gps_time")),
    "cresis_layer_data": ("old CReSIS layers", ("layerData", "GPS_time")),
    "organizer": ("a CReSIS layer organizer", ("lyr_id", "lyr_name")),
    "opr": ("an Open Polar Radar echogram", ("Data", "slow_time", "twtt", *POSITION)),
    "opr_layers": ("Open Polar Radar layers", ("twtt", "slow_time", "quality", "type")),
    "scenes": ("a set of scenes", ("layer_bins", "n_range_bins", "n_layers")),
    "scene": ("an exported scene", ("layer_bins", "mask")),
    "statistics": ("statistics of a flight", ("peak_power", "variance_bins2", "zone_edge_bins")),
}
ECHOGRAMS = ("nsidc", "cresis", "opr")
LAYERS = ("cresis_layer", "cresis_layer_data", "opr_layers")
# A file that lost half its variables is still called by its name, and what it lacks is named.
SMALLEST_SHARE = 0.4


def sniff(path, kinds=FORMATS):
    """Format of a file, a key of `FORMATS`.

    ValueError if it is none of these `kinds`, or lacks variables of the one that it is.
    """
    names = names_in(path)
    if "UTC_time" in names:
        names.add("GPS_time")  # what older files have in its place
    share = {kind: len(names & {*needed}) / len(needed) for kind, (_, needed) in FORMATS.items()}
    kind = max(share, key=share.get)
    if share[kind] < SMALLEST_SHARE:
        raise refusal(path, "variables", "those of an echogram or of layers", listed(names))
    if kind not in kinds:
        expected = " or ".join(in_words(kind) for kind in kinds)
        raise refusal(path, "format", expected, in_words(kind))
    needed = FORMATS[kind][1]
    missing = ", ".join(name for name in needed if name not in names)
    if missing and kind in (*ECHOGRAMS, *LAYERS):
        raise refusal(path, missing, f"variables {', '.join(needed)}", listed(names))
    return kind


def in_words(kind):
    """A format as messages call it."""
    return FORMATS[kind][0]
