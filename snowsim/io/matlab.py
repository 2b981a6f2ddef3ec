"""MAT files of both versions as plain values; v7.3 is HDF5, v5 has a module of its own."""

import h5py
import numpy as np

from snowsim.io.guard import refusal
from snowsim.io.hdf5 import check_dataset, names_in_hdf5, open_hdf5
from snowsim.io.mat5 import MAXIMUM_DEPTH, names_in_mat5, read_mat5
from snowsim.io.sniff import container_of

MAXIMUM_VALUES = 100_000  # in one file; a real parameter struct holds a few thousand


def read_matlab(path, names):
    """The named variables of a MAT file that are there, as a dict; see `read_mat5` and `read_mat73`."""
    return read_mat5(path, names) if container_of(path) == "mat5" else read_mat73(path, names)


def names_in_matlab(path):
    """Names of all variables of a MAT file."""
    return names_in_mat5(path) if container_of(path) == "mat5" else names_in_hdf5(path)


def read_mat73(path, names):
    """The named variables of a MAT v7.3 file (HDF5) that are there, as a dict, with MATLAB's order of dimensions."""
    present = names_in_hdf5(path)
    wanted = [name for name in names if name in present]
    with open_hdf5(path) as file:
        return {name: _hdf5_value(path, name, file, file[name], []) for name in wanted}


def _hdf5_value(path, name, file, node, visited, depth=0):
    """One variable; `visited` counts what it holds, since a file may refer to the same value any number of times."""
    visited.append(name)
    if depth > MAXIMUM_DEPTH or len(visited) > MAXIMUM_VALUES:
        raise refusal(path, name, f"at most {MAXIMUM_VALUES} values nested {MAXIMUM_DEPTH} deep", "more")
    matlab_class = node.attrs.get("MATLAB_class", b"")
    matlab_class = matlab_class.decode("ascii", "replace") if isinstance(matlab_class, bytes) else str(matlab_class)
    if matlab_class == "function_handle" or "MATLAB_object_decode" in node.attrs:
        return None
    if isinstance(node, h5py.Group):
        return {key: _hdf5_value(path, f"{name}.{key}", file, node[key], visited, depth + 1) for key in node}
    check_dataset(path, name, node)
    if node.attrs.get("MATLAB_empty", 0):
        # An empty variable stores its dimensions in place of its values.
        return "" if matlab_class == "char" else [] if matlab_class == "cell" else np.empty((0, 0))
    values = np.asarray(node[()])
    if h5py.check_ref_dtype(node.dtype) is h5py.Reference:
        return [_hdf5_value(path, name, file, file[ref], visited, depth + 1) for ref in values.ravel()]
    if matlab_class == "char" and values.dtype.kind == "u":
        return "".join(map(chr, values.ravel().tolist()))
    return values.T
