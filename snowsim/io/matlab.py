"""MAT files as plain values: numbers, text, cells as lists, structs as dicts, code objects as None.

Version 7.3 is HDF5. Version 5 is read here, element by element, and not by scipy.io: on 24 of 1800
damaged uncompressed files scipy 1.17.1 died. It looks up the type in the tag of an array's numbers
or text in a table without asking whether it is there: 4 of 10 single flips in these 4 bytes are a
segmentation fault or a bus error. So are a set complex flag without an imaginary part, and flips in
type or length of a name's or shape's tag that let it read on at a wrong place; flips high in a
shape make it fill memory for minutes. None of 600 compressed files did: they have checksums.
"""

import struct
import zlib

import h5py
import numpy as np

from snowsim.io.containers import check_dataset, names_in_hdf5, open_hdf5
from snowsim.io.guard import MAXIMUM_BYTES, check_size, container_of, library_errors, refusal

MAXIMUM_VALUES = 100_000  # in one file; a real parameter struct holds a few thousand
# Numbers of MathWorks, MAT-File Format, 1-17 ff.: types of elements on disk, classes of arrays in
# MATLAB.
MATRIX, COMPRESSED = 14, 15
STORAGE = {
    1: "i1",
    2: "u1",
    3: "i2",
    4: "u2",
    5: "i4",
    6: "u4",
    7: "f4",
    9: "f8",
    12: "i8",
    13: "u8",
}
TEXT = {1: "latin-1", 2: "latin-1", 4: "utf-16", 16: "utf-8", 17: "utf-16", 18: "utf-32"}
CELL, STRUCT, CHARACTERS = 1, 2, 4
CLASSES = {
    6: "f8",
    7: "f4",
    8: "i1",
    9: "u1",
    10: "i2",
    11: "u2",
    12: "i4",
    13: "u4",
    14: "i8",
    15: "u8",
}
COMPLEX = 0x08  # of the flags beside the class
MAXIMUM_DEPTH = 32
HEAD_BYTES = 1024  # hold the name and the shape of any variable


def read_matlab(path, names):
    """The named variables of a MAT file that are there, as a dict; ValueError of one line for a damaged file."""
    return read_mat5(path, names) if container_of(path) == "mat5" else read_mat73(path, names)


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
        raise refusal(
            path, name, f"at most {MAXIMUM_VALUES} values nested {MAXIMUM_DEPTH} deep", "more"
        )
    matlab_class = node.attrs.get("MATLAB_class", b"")
    matlab_class = (
        matlab_class.decode("ascii", "replace")
        if isinstance(matlab_class, bytes)
        else str(matlab_class)
    )
    if matlab_class == "function_handle" or "MATLAB_object_decode" in node.attrs:
        return None
    if isinstance(node, h5py.Group):
        return {
            key: _hdf5_value(path, f"{name}.{key}", file, node[key], visited, depth + 1)
            for key in node
        }
    check_dataset(path, name, node)
    if node.attrs.get("MATLAB_empty", 0):
        # An empty variable stores its dimensions in place of its values.
        return "" if matlab_class == "char" else [] if matlab_class == "cell" else np.empty((0, 0))
    values = np.asarray(node[()])
    if h5py.check_ref_dtype(node.dtype) is h5py.Reference:
        return [
            _hdf5_value(path, name, file, file[ref], visited, depth + 1) for ref in values.ravel()
        ]
    if matlab_class == "char" and values.dtype.kind == "u":
        return "".join(map(chr, values.ravel().tolist()))
    return values.T


def names_in_mat5(path):
    """Names of the variables in a MAT v5 file."""
    return {name for name, _ in _variables(path, ())}


def read_mat5(path, names):
    """The named variables of a MAT v5 file that are there, as a dict; what is not named is not inflated.

    Numbers have the class they had in MATLAB, whatever the file stores them as. Function handles,
    objects and sparse matrices come as None: nothing in a file is ever called.
    """
    return {
        name: _value(path, name, *parts)
        for name, parts in _variables(path, set(names))
        if name in names
    }


def _variables(path, wanted):
    """Yield the name of every variable and, for those wanted, what `_value` takes to decode it."""
    size = path.stat().st_size
    with library_errors(path, "MAT v5", "a readable file"), path.open("rb") as file:
        order = {b"IM": "<", b"MI": ">"}.get(file.read(128)[126:128])
        if order is None:
            raise refusal(path, "MAT v5", "byte order mark IM or MI", "none")
        offset = 128
        while offset < size:
            tag = file.read(8)
            kind, length = struct.unpack(order + "II", tag) if len(tag) == 8 else (0, 0)
            if kind not in (MATRIX, COMPRESSED) or offset + 8 + length > size:
                found = f"type {kind} of {length} bytes"
                raise refusal(
                    path, f"MAT v5, byte {offset}", f"a variable within {size} bytes", found
                )
            if kind == COMPRESSED:
                yield _compressed_variable(path, file.read(length), order, wanted)
            else:
                yield _header(path, memoryview(file.read(length)), order)
            offset += 8 + length


def _compressed_variable(path, data, order, wanted):
    """Name and parts of a compressed variable; inflated whole, so that its checksum counts, only if it is wanted."""
    with library_errors(path, "MAT v5", "a whole compressed variable"):
        head = zlib.decompressobj().decompress(data, HEAD_BYTES)
        kind, length = struct.unpack_from(order + "II", head)
    if kind != MATRIX or length > MAXIMUM_BYTES:
        found = f"type {kind} of {length} bytes"
        raise refusal(
            path, "MAT v5", f"a compressed variable of at most {MAXIMUM_BYTES} bytes", found
        )
    name, parts = _header(path, memoryview(head)[8:], order)
    if name not in wanted:
        return name, parts
    inflater = zlib.decompressobj()
    with library_errors(path, name, "a whole compressed variable"):
        inflated = inflater.decompress(data, length + 16)  # and as much padding as there may be
    if not inflater.eof or len(inflated) < 8 + length:
        raise refusal(
            path,
            name,
            f"a compressed variable of {8 + length} bytes",
            f"{len(inflated)} and no end",
        )
    return _header(path, memoryview(inflated)[8 : 8 + length], order)


def _element(path, what, data, offset, order):
    """Type and bytes of the element at an offset, and where the next one begins."""
    if offset + 8 > len(data):
        raise refusal(path, what, "another element", f"the end at byte {len(data)}")
    kind, length = struct.unpack_from(order + "II", data, offset)
    start, step = offset + 8, 8 + -(-length // 8) * 8
    if kind >> 16:  # a small element: its length is in the upper half and its bytes are in the tag
        kind, length, start, step = kind & 0xFFFF, kind >> 16, offset + 4, 8
    if start + length > min(len(data), offset + step):
        raise refusal(
            path, what, f"elements within {len(data)} bytes", f"one of {length} bytes at {offset}"
        )
    return kind, data[start : start + length], offset + step


def _header(path, data, order):
    """Name of a matrix, and (order, class, flags, shape, rest) of it."""
    kind, flags, offset = _element(path, "flags", data, 0, order)
    if kind != 6 or len(flags) != 8:
        raise refusal(path, "flags", "8 bytes of type 6", f"{len(flags)} of type {kind}")
    (word,) = struct.unpack_from(order + "I", flags)
    array_class, flags = word & 0xFF, word >> 8 & 0xFF
    if array_class > 15:  # function handles and objects: what follows is MATLAB's own
        kind, name, _ = _element(path, "name", data, offset, order)
        return _decoded(path, "name", name, "latin-1"), (order, array_class, flags, (), data[:0])
    kind, shape, offset = _element(path, "shape", data, offset, order)
    if kind != 5 or len(shape) < 8 or len(shape) % 4:
        raise refusal(
            path, "shape", "two or more numbers of type 5", f"{len(shape)} bytes of type {kind}"
        )
    shape = struct.unpack(f"{order}{len(shape) // 4}i", shape)
    if min(shape) < 0:
        raise refusal(path, "shape", "lengths not negative", shape)
    kind, name, offset = _element(path, "name", data, offset, order)
    return _decoded(path, "name", name, "latin-1"), (
        order,
        array_class,
        flags,
        shape,
        data[offset:],
    )


def _value(path, what, order, array_class, flags, shape, data, depth=0):
    """The value of a matrix."""
    if depth > MAXIMUM_DEPTH:
        raise refusal(path, what, f"at most {MAXIMUM_DEPTH} nested values", "more")
    if array_class in CLASSES:
        return _numbers(path, what, order, CLASSES[array_class], flags & COMPLEX, shape, data)
    if array_class == CHARACTERS:
        kind, text, _ = _element(path, what, data, 0, order)
        codec = TEXT.get(kind)
        if codec is None:
            raise refusal(path, what, "text", f"type {kind}")
        wide = codec in ("utf-16", "utf-32")
        return _decoded(path, what, text, codec + ("-le" if order == "<" else "-be") * wide)
    if array_class == CELL:
        return _members(path, what, order, shape, data, 1, depth)
    if array_class == STRUCT:
        return _structs(path, what, order, shape, data, depth)
    return None


def _numbers(path, what, order, dtype, is_complex, shape, data):
    check_size(path, what, shape, np.dtype(dtype).itemsize)
    n_values = int(np.prod(shape, dtype=object))
    parts, offset = [], 0
    for _ in range(2 if is_complex else 1):
        kind, stored, offset = _element(path, what, data, offset, order)
        if kind not in STORAGE or len(stored) != n_values * np.dtype(STORAGE[kind]).itemsize:
            found = f"{len(stored)} bytes of type {kind}"
            raise refusal(path, what, f"{n_values} numbers for shape {shape}", found)
        parts.append(np.frombuffer(stored, dtype=order + STORAGE[kind]).astype(dtype))
    values = parts[0] + 1j * parts[1] if is_complex else parts[0]
    return values.reshape(shape, order="F")


def _members(path, what, order, shape, data, n_fields, depth):
    """Values of the members of a cell or struct array, in MATLAB's order."""
    n_members = int(np.prod(shape, dtype=object)) * n_fields
    if n_members > len(data) // 8:  # a member takes 8 bytes even where it is empty
        raise refusal(path, what, f"at most {len(data) // 8} members", f"{n_members}")
    values, offset = [], 0
    for _ in range(n_members):
        kind, member, offset = _element(path, what, data, offset, order)
        if kind != MATRIX:
            raise refusal(path, what, "members that are arrays", f"type {kind}")
        empty = len(member) == 0
        values.append(
            np.empty((0, 0))
            if empty
            else _value(path, what, *_header(path, member, order)[1], depth + 1)
        )
    return values


def _structs(path, what, order, shape, data, depth):
    kind, length, offset = _element(path, what, data, 0, order)
    if kind != 5 or len(length) != 4 or struct.unpack(order + "i", length)[0] < 1:
        raise refusal(
            path, what, "the length of its field names", f"{len(length)} bytes of type {kind}"
        )
    (length,) = struct.unpack(order + "i", length)
    _, names, offset = _element(path, what, data, offset, order)
    fields = [
        _decoded(path, what, names[at : at + length], "latin-1")
        for at in range(0, len(names), length)
    ]
    values = _members(path, what, order, shape, data[offset:], len(fields), depth)
    structs = [
        dict(zip(fields, values[at : at + len(fields)], strict=True))
        for at in range(0, len(values), len(fields) or 1)
    ]
    return structs[0] if len(structs) == 1 else structs


def _decoded(path, what, text, codec):
    with library_errors(path, what, "readable text"):
        return bytes(text).decode(codec).partition("\0")[0]
