"""NetCDF files, version 3 and 4, as undecoded datasets; read by h5py and scipy, which survive damaged files."""

import h5py
import numpy as np
import scipy.io
import xarray as xr

from snowsim.io.guard import library_errors, numeric, refusal
from snowsim.io.hdf5 import check_dataset, check_texts, names_in_hdf5, open_hdf5
from snowsim.io.sniff import container_of

# What NetCDF-4 keeps for itself in an HDF5 file.
PRIVATE = {"CLASS", "NAME", "REFERENCE_LIST", "DIMENSION_LIST", "DIMENSION_LABELS", "_nc3_strict", "_NCProperties"}
PRIVATE_START = "_Netcdf4"
NO_VARIABLE = b"This is a netCDF dimension but not a netCDF variable"


def names_in_netcdf3(path):
    """Names of the variables in a NetCDF file of version 3."""
    with library_errors(path, "NetCDF", "a readable file"), scipy.io.netcdf_file(path, mmap=False) as file:
        return set(file.variables)


def read_netcdf(path, names=None):
    """Variables of a NetCDF file as they are stored: no fill value, scale or time is applied.

    Parameters
    ----------
    path : Path
    names : iterable of str, optional
        Read those of these that are there; by default all.

    Returns
    -------
    xarray.Dataset
        With the names of dimensions as in the file, and all attributes.

    Raises
    ------
    ValueError
        One line, for a damaged file, a variable beyond the size limit or one that lies in another file.
    """
    if container_of(path) == "netcdf3":
        variables, attributes = _read3(path, names)
    else:
        variables, attributes = _read4(path, names)
    with library_errors(path, "NetCDF", "variables that agree on their dimensions"):
        return xr.Dataset(variables, attrs=attributes)


def _read3(path, names):
    with library_errors(path, "NetCDF", "a readable file"), scipy.io.netcdf_file(path, mmap=False) as file:
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
            variables[name] = (_dimensions(node, name), _values(path, name, node), _attributes(node))
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
    dimensions = []
    for axis, scales in enumerate(node.dims):
        scale = scales[0].name.rpartition("/")[2] if len(scales) else f"{name}_{axis}"
        dimensions.append(scale)
    return tuple(dimensions)


def _attributes(node):
    names = [name for name in node.attrs if name not in PRIVATE and not name.startswith(PRIVATE_START)]
    return {name: _plain(node.attrs[name]) for name in names}


def _plain(value):
    """Text, numbers, or arrays of them."""
    if isinstance(value, bytes):
        return value.decode("utf-8").replace("\0", "")
    if isinstance(value, h5py.Empty):
        return ""
    if isinstance(value, np.ndarray):
        if value.dtype.kind == "S":
            return b"".join(value.ravel().tolist()).decode("utf-8").replace("\0", "")
        return value.ravel()[0].item() if value.size == 1 and value.dtype.kind in "fiu" else value
    return value.item() if isinstance(value, np.generic) else value
