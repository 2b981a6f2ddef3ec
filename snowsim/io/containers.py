"""HDF5 and NetCDF files opened with care: no link out of the file, no trap for the library, no oversized variable.

NetCDF is read by h5py and scipy, which survive damaged files.
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
TEXT_LINK = 16  # bytes of a text's length, heap and place in it
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
    """The file, opened; library errors within the block become the one-line ValueError."""
    check_heaps(path)
    with library_errors(path, "HDF5", "a readable file"), h5py.File(path, "r") as file:
        yield file


def names_in_hdf5(path):
    """Names at the top of an HDF5 file; refuses links that lead out of the file."""
    with open_hdf5(path) as file:
        names = {name: file.get(name, getlink=True) for name in file}
    for name, link in names.items():
        if isinstance(link, h5py.ExternalLink | h5py.SoftLink):
            raise refusal(path, name, "a variable of this file", f"a link to {link.path}")
    return set(names)


def check_dataset(path, name, node):
    """Refuse what is no dataset of this file, or says it is larger than the limit."""
    if not isinstance(node, h5py.Dataset):
        raise refusal(path, name, "a variable", type(node).__name__)
    if node.external or node.is_virtual:
        raise refusal(path, name, "a variable of this file", "one kept in other files")
    check_size(path, name, node.shape or (), node.dtype.itemsize)


def check_texts(path, name, node):
    """Refuse texts of any length that say they are longer than the file: the library would make room for them first."""
    size = path.stat().st_size
    check_size(path, name, node.shape, TEXT_LINK)
    offset = node.id.get_offset()  # None where they are kept in chunks
    if offset is not None:
        with path.open("rb") as file:
            file.seek(offset)
            links = file.read(node.size * TEXT_LINK)
        lengths = [
            length
            for length, _, _ in struct.iter_unpack(
                "<IQI", links[: len(links) // TEXT_LINK * TEXT_LINK]
            )
        ]
        if sum(lengths) > size:
            raise refusal(path, name, f"texts within {size} bytes", f"{sum(lengths)} bytes of them")


def check_heaps(path):
    """Refuse a file with a global heap whose objects overrun it: the library would walk it for ever.

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
        raise refusal(
            path, f"HDF5 heap at byte {at}", "one within the file", f"one of {length} bytes"
        )
    offset = at + HEAP_HEADER
    while offset + HEAP_OBJECT <= end:
        index, _, _, object_length = struct.unpack_from("<HHIQ", content, offset)
        # The free space, object 0, counts its own header.
        step = object_length if index == 0 else HEAP_OBJECT + -(-object_length // 8) * 8
        if step < HEAP_OBJECT or offset + step > end:
            found = f"object {index} of {object_length} bytes at {offset}"
            raise refusal(path, f"HDF5 heap at byte {at}", f"objects that end by byte {end}", found)
        offset += step


def names_in_netcdf3(path):
    """Names of the variables in a NetCDF file of version 3."""
    with (
        library_errors(path, "NetCDF", "a readable file"),
        scipy.io.netcdf_file(path, mmap=False) as file,
    ):
        return set(file.variables)


def read_netcdf(path, names=None):
    """Dataset of the variables of a NetCDF file, or of those of `names` that are there, with all attributes.

    As they are stored: no fill value, scale or time is applied. A variable beyond the size limit is
    refused.
    """
    read = _read3 if container_of(path) == "netcdf3" else _read4
    variables, attributes = read(path, names)
    with library_errors(path, "NetCDF", "variables that agree on their dimensions"):
        return xr.Dataset(variables, attrs=attributes)


def _read3(path, names):
    with (
        library_errors(path, "NetCDF", "a readable file"),
        scipy.io.netcdf_file(path, mmap=False) as file,
    ):
        variables = {}
        for name, variable in file.variables.items():
            if names is None or name in names:
                attributes = {key: _plain(value) for key, value in variable._attributes.items()}
                values = variable[:] if variable.shape else np.asarray(variable.getValue())
                # Big-endian on disk; and a copy, that outlives the file.
                values = np.array(values, dtype=values.dtype.newbyteorder("="))
                variables[name] = (variable.dimensions, values, attributes)
        return variables, {key: _plain(value) for key, value in file._attributes.items()}


def _read4(path, names):
    present = names_in_hdf5(path)
    with open_hdf5(path) as file:
        variables = {}
        for name in sorted(present if names is None else present & set(names)):
            node = file[name]
            if isinstance(node, h5py.Group):
                continue
            check_dataset(path, name, node)
            if bytes(np.asarray(node.attrs.get("NAME", b"")).tobytes()).startswith(NO_VARIABLE):
                continue
            variables[name] = (
                _dimensions(node, name),
                _values(path, name, node),
                _attributes(node),
            )
        return variables, _attributes(file)


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


def _attributes(node):
    names = [
        name for name in node.attrs if name not in PRIVATE and not name.startswith(PRIVATE_START)
    ]
    return {name: _plain(node.attrs[name]) for name in names}


def _plain(value):
    """Text, numbers, or arrays of them."""
    if isinstance(value, np.ndarray) and value.dtype.kind == "S":
        value = b"".join(value.ravel().tolist())
    if isinstance(value, bytes):
        return value.decode("utf-8").replace("\0", "")
    if isinstance(value, h5py.Empty):
        return ""
    if isinstance(value, np.ndarray):
        return value.ravel()[0].item() if value.size == 1 and value.dtype.kind in "fiu" else value
    return value.item() if isinstance(value, np.generic) else value
