"""HDF5 and NetCDF files opened with care: no link out of the file, no trap, nothing oversized.

NetCDF is read by h5py and scipy, which survive damaged files, but for heaps that HDF5 walks for
ever: of 1200 damaged NetCDF-4 files 9 took a reader without `check_heaps` to any limit of time. To
find that out each costs the whole limit; looking at the heaps costs a search through the file.
"""

import mmap
import struct
from contextlib import contextmanager

import h5py
import numpy as np
import scipy.io
import xarray as xr

from snowsim.io.guard import check_size, container_of, library_errors, numeric, refusal

HEAP = b"GCOL\x01"  # a global heap collection, version 1: HDF5 File Format Specification, III.E
# Where a text of any length lies: its length, its heap, and its place in it.
TEXT_LINK = np.dtype([("length", "<u4"), ("heap", "<u8"), ("place", "<u4")])
HEAP_HEADER, HEAP_OBJECT = 16, 16  # bytes in front of a collection and of each of its objects
# What NetCDF-4 keeps for itself in an HDF5 file.
PRIVATE = {
    "CLASS",
    "NAME",
    "REFERENCE_LIST",
    "DIMENSION_LIST",
    "DIMENSION_LABELS",
    "_nc3_strict",
    "_NCProperties",
}
PRIVATE_START = "_Netcdf4"
NO_VARIABLE = b"This is a netCDF dimension but not a netCDF variable"


@contextmanager
def open_hdf5(path):
    """The file, opened; library errors within the block become the one-line ValueError.

    Links at its top that lead elsewhere are refused.
    """
    check_heaps(path)
    with library_errors(path, "HDF5", "a readable file"), h5py.File(path, "r") as file:
        for name in file:
            link = file.get(name, getlink=True)
            if isinstance(link, h5py.ExternalLink | h5py.SoftLink):
                raise refusal(path, name, "a variable of this file", f"a link to {link.path}")
        yield file


def names_in_hdf5(path):
    """Names at the top of an HDF5 file."""
    with open_hdf5(path) as file:
        return set(file)


def check_dataset(path, name, node):
    """Refuse what is no dataset of this file, or says it is larger than the limit."""
    if not isinstance(node, h5py.Dataset):
        raise refusal(path, name, "a variable", type(node).__name__)
    if node.external or node.is_virtual:
        raise refusal(path, name, "a variable of this file", "one kept in other files")
    check_size(path, name, node.shape or (), node.dtype.itemsize)


def check_texts(path, name, node):
    """Refuse texts that say they are longer than the file: the library would make room first."""
    check_size(path, name, node.shape, TEXT_LINK.itemsize)
    offset = node.id.get_offset()
    if offset is None:  # kept in chunks
        return
    with path.open("rb") as file:
        file.seek(offset)
        stored = file.read(node.size * TEXT_LINK.itemsize)
    n_links = len(stored) // TEXT_LINK.itemsize
    links = np.frombuffer(stored, TEXT_LINK, count=n_links)
    declared = int(links["length"].sum(dtype=np.int64))
    size = path.stat().st_size
    if declared > size:
        raise refusal(path, name, f"texts within {size} bytes", f"{declared} bytes of them")


def check_heaps(path):
    """Refuse a file with a heap whose objects overrun it: the library would walk it for ever.

    Heaps hold text and lists of references. They are found by their signature, wherever they stand.
    """
    size = path.stat().st_size
    if size == 0:
        raise refusal(path, "HDF5", "a readable file", "an empty one")
    with (
        library_errors(path, "HDF5", "a readable file"),
        path.open("rb") as file,
        mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as content,
    ):
        at = content.find(HEAP)
        while at >= 0:
            _check_heap(path, content, at)
            at = content.find(HEAP, at + len(HEAP))


def _check_heap(path, content, at):
    length = struct.unpack_from("<Q", content, at + 8)[0] if at + HEAP_HEADER <= len(content) else 0
    end = at + length
    if length < HEAP_HEADER or end > len(content):
        found = f"one of {length} bytes"
        raise refusal(path, f"HDF5 heap at byte {at}", "one within the file", found)
    offset = at + HEAP_HEADER
    while offset + HEAP_OBJECT <= end:
        index, _, _, object_length = struct.unpack_from("<HHIQ", content, offset)
        padded_length = -(-object_length // 8) * 8
        # The free space, object 0, counts its own header.
        step = object_length if index == 0 else HEAP_OBJECT + padded_length
        if step < HEAP_OBJECT or offset + step > end:
            found = f"object {index} of {object_length} bytes at {offset}"
            raise refusal(path, f"HDF5 heap at byte {at}", f"objects that end by byte {end}", found)
        offset += step


@contextmanager
def open_netcdf3(path):
    """The NetCDF file of version 3, opened; library errors within the block become the one line."""
    with (
        library_errors(path, "NetCDF", "a readable file"),
        scipy.io.netcdf_file(path, mmap=False) as file,
    ):
        yield file


def names_in_netcdf3(path):
    """Names of the variables in a NetCDF file of version 3."""
    with open_netcdf3(path) as file:
        return set(file.variables)


def read_netcdf(path, names=None):
    """Dataset of a NetCDF file with all attributes; of `names`, where given, those that are there.

    Values come as they are stored: no fill value, scale or time is applied. A variable beyond the
    size limit is refused.
    """
    read = _read3 if container_of(path) == "netcdf3" else _read4
    variables, attributes = read(path, names)
    with library_errors(path, "NetCDF", "variables that agree on their dimensions"):
        return xr.Dataset(variables, attrs=attributes)


def _read3(path, names):
    variables = {}
    with open_netcdf3(path) as file:
        for name, variable in file.variables.items():
            if names is None or name in names:
                # Big-endian on disk; and a copy, that outlives the file.
                values = np.array(variable.data, dtype=variable.data.dtype.newbyteorder("="))
                variables[name] = (variable.dimensions, values, _attributes(variable._attributes))
        return variables, _attributes(file._attributes)


def _read4(path, names):
    variables = {}
    with open_hdf5(path) as file:
        wanted = set(file) if names is None else set(file) & set(names)
        for name in sorted(wanted):
            node = file[name]
            if isinstance(node, h5py.Group):
                continue
            check_dataset(path, name, node)
            scale_name = np.asarray(node.attrs.get("NAME", b"")).tobytes()
            if scale_name.startswith(NO_VARIABLE):
                continue
            values = _values(path, name, node)
            variables[name] = (_dimensions(node, name), values, _attributes(node.attrs))
        return variables, _attributes(file.attrs)


def _values(path, name, node):
    text = h5py.check_string_dtype(node.dtype)
    if text is not None and text.length is None:
        check_texts(path, name, node)
        return np.asarray(node.asstr()[()], dtype=object)
    if node.dtype.kind not in "fiubS":
        raise refusal(path, name, "numbers or text", node.dtype)
    values = np.asarray(node[()])
    return values if values.dtype.kind == "S" else numeric(path, name, values)


def _dimensions(node, name):
    """Names of a variable's dimensions; names of its own where it has none."""
    if node.ndim == 1 and node.is_scale:
        return (name,)
    scales = [scales[0].name.rpartition("/")[2] if len(scales) else None for scales in node.dims]
    return tuple(scale or f"{name}_{axis}" for axis, scale in enumerate(scales))


def _attributes(stored):
    """Attributes that are the file's own, as text, numbers, or arrays of them."""
    return {
        name: _plain(stored[name])
        for name in stored
        if name not in PRIVATE and not name.startswith(PRIVATE_START)
    }


def _plain(value):
    if isinstance(value, h5py.Empty):
        return ""
    if isinstance(value, np.ndarray) and value.dtype.kind == "S":
        value = b"".join(value.ravel().tolist())
    if isinstance(value, bytes):
        return value.decode("utf-8").replace("\0", "")
    if isinstance(value, np.ndarray):
        is_number = value.size == 1 and value.dtype.kind in "fiu"
        return value.item() if is_number else value
    return value.item() if isinstance(value, np.generic) else value
