"""Variables of NetCDF, HDF5 and MAT files as their libraries read them, and nothing oversized."""

import mmap
import re
import struct
from pathlib import Path

import h5py
import numpy as np
import scipy.io
import xarray as xr

from snowsim.io.guard import MAXIMUM_BYTES, Refused, library_errors
from snowsim.io.mat5 import read_mat5

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
