"""Variables of NetCDF, HDF5 and MAT files as their libraries read them, and nothing oversized."""

import mmap
import re
import struct
from pathlib import Path

import h5py
import numpy as np
import scipy.io
import xarray as xr

from snowsim.io.guard import MAXIMUM_BYTES, PNG_SIGNATURE, Refused, library_errors, listed
from snowsim.io.mat5 import read_mat5

# A heap of HDF5, version 1, and bytes in front of it and of each of its objects: HDF5 File Format
# Specification, III.E.
HEAP = re.compile(b"GCOL\x01")
HEADER_BYTES = 16
VALUE_BYTES = 10_000  # what a value in a struct or cell counts at least: 100000 of them in a file
NO_VARIABLE = "This is a netCDF dimension but not a netCDF variable"
PIXELS = "pixels"  # the one variable of a PNG image
KINDS = "MAT v5, MAT v7.3, NetCDF, PNG or Zarr"


def names_in(path, needed=()):
    """Names of the variables a file holds; refused without all of those `needed`."""
    path = Path(path)
    with library_errors(path, f"content: expected {KINDS}"):
        if path.is_dir():
            names = {item.name for item in path.iterdir() if item.is_dir()}
        elif h5py.is_hdf5(path):
            check_heaps(path)
            with h5py.File(path) as file:
                told = {name: str(node.attrs.get("NAME")) for name, node in file.items()}
            names = {name for name, what in told.items() if NO_VARIABLE not in what}
        else:
            with path.open("rb") as file:
                first = file.read(len(PNG_SIGNATURE))
            if first == PNG_SIGNATURE:
                names = {PIXELS}
            elif first.startswith(b"CDF"):
                with xr.open_dataset(path, engine="scipy", decode_cf=False) as dataset:
                    names = set(dataset.variables)
            else:
                names = {name for name, _, _ in scipy.io.whosmat(path, appendmat=False)}
        missing = ", ".join(name for name in needed if name not in names)
        if missing:
            msg = f"{missing}: expected variables {', '.join(needed)}, found {listed(names)}"
            raise Refused(msg)
    return names


def check_heaps(path):
    """Refuse a heap whose objects overrun it: HDF5 2.2 walks it for ever.

    Heaps hold text and lists of references. Of 1600 damaged NetCDF files 5 had such a heap.
    """
    with path.open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as content:
        for heap in HEAP.finditer(content):
            (length,) = struct.unpack_from("<Q", content, heap.start() + 8)
            end = heap.start() + length
            offset = heap.start() + HEADER_BYTES
            while offset + HEADER_BYTES <= end:
                index, _, _, size = struct.unpack_from("<HHIQ", content, offset)
                # The free space, object 0, counts its own header.
                step = size if index == 0 else HEADER_BYTES + -(-size // 8) * 8
                offset += step
                if step < HEADER_BYTES or offset > end:
                    msg = f"HDF5: expected heaps that hold their objects, found one of {length}"
                    raise Refused(msg)


def read_netcdf(path, needed=()):
    """Dataset of a NetCDF file or Zarr store, which must have what is `needed`.

    Values come as they are stored: no fill value, scale or time is applied.
    """
    path = Path(path)
    with library_errors(path):
        names_in(path, needed)
        engine = "netcdf4" if h5py.is_hdf5(path) else "zarr" if path.is_dir() else "scipy"
        with xr.open_dataset(path, engine=engine, decode_cf=False) as dataset:
            if dataset.nbytes > MAXIMUM_BYTES:
                msg = f"expected at most {MAXIMUM_BYTES} bytes, found {dataset.nbytes}"
                raise Refused(msg)
            return dataset.load()


def read_matlab(path, needed, others=()):
    """Variables of a MAT file, which must have what is `needed`, and of `others` those it has.

    Numbers are arrays, squeezed; text is text, a struct a dict, a cell a list. Empty arrays are
    left out.
    """
    path = Path(path)
    with library_errors(path):
        wanted = sorted(names_in(path, needed).intersection((*needed, *others)))
        if h5py.is_hdf5(path):
            with h5py.File(path) as file:
                room = [MAXIMUM_BYTES]
                values = {name: _plain(file[name], room) for name in wanted}
        else:
            values = read_mat5(path, wanted)
    return {name: value for name, value in values.items() if getattr(value, "size", 1)}


def _plain(node, room):
    """A variable of a MAT v7.3 file; `room` is what may still be read, in bytes.

    A file may refer to the same value any number of times.
    """
    room[0] -= VALUE_BYTES + getattr(node, "nbytes", 0)
    if room[0] < 0:
        msg = f"{node.name}: expected at most {MAXIMUM_BYTES} bytes, found more"
        raise Refused(msg)
    if isinstance(node, h5py.Group):
        return {name: _plain(field, room) for name, field in node.items()}
    matlab_class = node.attrs.get("MATLAB_class", b"")
    if node.attrs.get("MATLAB_empty", 0):
        # In place of its values an empty variable stores its dimensions.
        return "" if matlab_class == b"char" else np.empty(0)
    values = node[()]
    if node.dtype == h5py.ref_dtype:
        return [_plain(node.file[reference], room) for reference in values.ravel()]
    if matlab_class == b"char":
        return "".join(map(chr, values.ravel()))
    return np.squeeze(values.T)
