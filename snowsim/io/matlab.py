"""MAT files as plain values: numbers, text, cells as lists, structs as dicts, code objects as None.

Version 7.3 is HDF5. Version 5 is read here, element by element, and not by scipy.io: on 24 of 1800
damaged uncompressed files scipy 1.17.1 died. It looks up the type in the tag of an array's numbers
or text in a table without asking whether it is there: 4 of 10 single flips in these 4 bytes are a
segmentation fault or a bus error. So are a set complex flag without an imaginary part, and flips in
type or length of a name's or shape's tag that let it read on at a wrong place; flips high in a
shape make it fill memory for minutes. None of 600 compressed files did: they have checksums.

scipy in a child process would survive these, and is not used: handing the arrays over makes reading
a frame of 50 MB 22 % slower, and starting the child takes `info` from 1.1 to 1.6 s.
"""

import math
import struct
import zlib
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

from snowsim.io.containers import check_dataset, open_hdf5
from snowsim.io.guard import MAXIMUM_BYTES, check_size, container_of, library_errors, refusal

MAXIMUM_VALUES = 100_000  # in one file; a real parameter struct holds a few thousand
MAXIMUM_DEPTH = 32
HEAD_BYTES = 1024  # hold the name and the shape of any variable
# Numbers of MathWorks, MAT-File Format, 1-17 ff. Types of elements on disk:
INT32, UINT32, MATRIX, COMPRESSED = 5, 6, 14, 15
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
TEXT = {1: "latin-1", 2: "latin-1", 4: "utf-16-{}", 16: "utf-8", 17: "utf-16-{}", 18: "utf-32-{}"}
# Classes of arrays in MATLAB:
CELL, STRUCT, CHARACTERS = 1, 2, 4
NUMBERS = {
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
LAST_CLASS_WITH_SHAPE = 16
COMPLEX = 0x0800  # of the flags beside the class


def read_matlab(path, names):
    """The named variables of a MAT file that are there, as a dict; ValueError if it is damaged."""
    return read_mat5(path, names) if container_of(path) == "mat5" else read_mat73(path, names)


def read_mat73(path, names):
    """The named variables of a MAT v7.3 file (HDF5) that are there, as a dict.

    Dimensions are in MATLAB's order.
    """
    with open_hdf5(path) as file:
        present = set(file)
        return {name: _hdf5_value(path, name, file[name], []) for name in names if name in present}


def _hdf5_value(path, name, node, visited, depth=0):
    """One variable.

    `visited` counts what it holds, since a file may refer to the same value any number of times.
    """
    visited.append(name)
    if depth > MAXIMUM_DEPTH or len(visited) > MAXIMUM_VALUES:
        expected = f"at most {MAXIMUM_VALUES} values nested {MAXIMUM_DEPTH} deep"
        raise refusal(path, name, expected, "more")
    matlab_class = node.attrs.get("MATLAB_class", b"")
    if isinstance(matlab_class, bytes):
        matlab_class = matlab_class.decode("ascii", "replace")
    if str(matlab_class) == "function_handle" or "MATLAB_object_decode" in node.attrs:
        return None
    if isinstance(node, h5py.Group):
        fields = {}
        for key in node:
            field = f"{name}.{key}"
            # Here, and not by a walk over the file: structs of MATLAB have thousands of links.
            link = node.get(key, getlink=True)
            if not isinstance(link, h5py.HardLink):
                raise refusal(path, field, "a variable of this file", f"a link to {link.path}")
            fields[key] = _hdf5_value(path, field, node[key], visited, depth + 1)
        return fields
    check_dataset(path, name, node)
    if node.attrs.get("MATLAB_empty", 0):
        # An empty variable stores its dimensions in place of its values.
        empty = {"char": "", "cell": []}
        return empty.get(str(matlab_class), np.empty((0, 0)))
    values = np.asarray(node[()])
    if h5py.check_ref_dtype(node.dtype) is h5py.Reference:
        cells = []
        for reference in values.ravel():
            cell = node.file[reference]
            cells.append(_hdf5_value(path, name, cell, visited, depth + 1))
        return cells
    if str(matlab_class) == "char" and values.dtype.kind == "u":
        return "".join(map(chr, values.ravel().tolist()))
    return values.T


@dataclass
class Elements:
    """Elements of a MAT v5 file that stand behind each other, taken one by one."""

    path: Path
    what: str  # they belong to, for refusals
    order: str  # of bytes, "<" or ">"
    data: memoryview
    offset: int = 0

    def take(self):
        """Type and bytes of the next element."""
        size = len(self.data)
        if self.offset + 8 > size:
            self.refuse("another element", f"the end at byte {size}")
        kind, length = self.unpack("II", self.data, self.offset)
        start = self.offset + 8
        step = 8 + -(-length // 8) * 8
        if kind >> 16:  # small: its length is in the upper half and its bytes are in the tag
            length = kind >> 16
            kind = kind & 0xFFFF
            start = self.offset + 4
            step = 8
        if start + length > min(size, self.offset + step):
            found = f"one of {length} bytes at {self.offset}"
            self.refuse(f"elements within {size} bytes", found)
        self.offset += step
        return kind, self.data[start : start + length]

    def within(self, data):
        """Elements of other bytes of the same variable."""
        return Elements(self.path, self.what, self.order, memoryview(data))

    def unpack(self, format, data, offset=0):
        """Numbers of a part of the data."""
        return struct.unpack_from(self.order + format, data, offset)

    def decode(self, text, codec="latin-1"):
        """Text up to its first NUL."""
        endian = "le" if self.order == "<" else "be"
        with library_errors(self.path, self.what, "readable text"):
            return bytes(text).decode(codec.format(endian)).partition("\0")[0]

    def refuse(self, expected, found):
        """Raise the one-line ValueError."""
        raise refusal(self.path, self.what, expected, found)


@dataclass
class Variable:
    """An array of a MAT v5 file by its header; its content is still to be taken from `elements`."""

    name: str
    array_class: int
    is_complex: bool
    shape: tuple
    elements: Elements


def names_in_mat5(path):
    """Names of the variables in a MAT v5 file."""
    return {variable.name for variable in _variables(path, ())}


def read_mat5(path, names):
    """The named variables of a MAT v5 file that are there, as a dict; others are not inflated.

    Numbers have the class they had in MATLAB, whatever the file stores them as. Function handles,
    objects and sparse matrices come as None: nothing in a file is ever called.
    """
    return {
        variable.name: _value(variable)
        for variable in _variables(path, names)
        if variable.name in names
    }


def _variables(path, wanted):
    """Yield every variable; the content of compressed ones is whole for those wanted only."""
    size = path.stat().st_size
    with library_errors(path, "MAT v5", "a readable file"), path.open("rb") as file:
        # `container_of` has seen one of the two marks.
        order = "<" if file.read(128)[126:128] == b"IM" else ">"
        offset = 128
        while offset < size:
            tag = file.read(8)
            kind, length = struct.unpack(order + "II", tag) if len(tag) == 8 else (0, 0)
            if kind not in (MATRIX, COMPRESSED) or offset + 8 + length > size:
                found = f"type {kind} of {length} bytes"
                expected = f"a variable within {size} bytes"
                raise refusal(path, f"MAT v5, byte {offset}", expected, found)
            elements = Elements(path, "MAT v5", order, memoryview(file.read(length)))
            variable = _header(elements) if kind == MATRIX else _compressed(elements, wanted)
            variable.elements.what = variable.name
            yield variable
            offset += 8 + length


def _compressed(elements, wanted):
    """A compressed variable; inflated whole, so that its checksum counts, only if it is wanted."""
    with library_errors(elements.path, elements.what, "a whole compressed variable"):
        head = zlib.decompressobj().decompress(elements.data, HEAD_BYTES)
        kind, length = elements.unpack("II", head)
    if kind != MATRIX or length > MAXIMUM_BYTES:
        expected = f"a compressed variable of at most {MAXIMUM_BYTES} bytes"
        elements.refuse(expected, f"type {kind} of {length} bytes")
    variable = _header(elements.within(head[8:]))
    if variable.name not in wanted:
        return variable
    elements.what = variable.name
    end = 8 + length
    inflater = zlib.decompressobj()
    with library_errors(elements.path, elements.what, "a whole compressed variable"):
        # And as much padding as there may be.
        inflated = inflater.decompress(elements.data, end + 8)
    if not inflater.eof or len(inflated) < end:
        expected = f"a compressed variable of {end} bytes"
        elements.refuse(expected, f"{len(inflated)} and no end")
    return _header(elements.within(memoryview(inflated)[8:end]))


def _header(elements):
    """The variable whose header the next elements are."""
    kind, flags = elements.take()
    if kind != UINT32 or len(flags) != 8:
        elements.refuse("8 bytes of flags, type 6", f"{len(flags)} of type {kind}")
    (word,) = elements.unpack("I", flags)
    array_class = word & 0xFF
    # Objects have no shape: what follows is MATLAB's own.
    shape = _shape(elements) if array_class <= LAST_CLASS_WITH_SHAPE else ()
    _, name = elements.take()
    return Variable(elements.decode(name), array_class, bool(word & COMPLEX), shape, elements)


def _shape(elements):
    kind, stored = elements.take()
    if kind != INT32 or len(stored) < 8 or len(stored) % 4:
        found = f"{len(stored)} bytes of type {kind}"
        elements.refuse("a shape, two or more numbers of type 5", found)
    shape = elements.unpack(f"{len(stored) // 4}i", stored)
    if min(shape) < 0:
        elements.refuse("a shape without negative lengths", shape)
    return shape


def _value(variable, depth=0):
    """The value of a variable, or of what lies this deep in one."""
    if depth > MAXIMUM_DEPTH:
        variable.elements.refuse(f"at most {MAXIMUM_DEPTH} nested values", "more")
    if variable.array_class in NUMBERS:
        return _numbers(variable)
    if variable.array_class == CHARACTERS:
        return _characters(variable.elements)
    if variable.array_class == CELL:
        return _members(variable, math.prod(variable.shape), depth)
    if variable.array_class == STRUCT:
        return _structs(variable, depth)
    return None


def _characters(elements):
    kind, text = elements.take()
    if kind not in TEXT:
        elements.refuse("text", f"type {kind}")
    return elements.decode(text, TEXT[kind])


def _numbers(variable):
    dtype = np.dtype(NUMBERS[variable.array_class])
    check_size(variable.elements.path, variable.elements.what, variable.shape, dtype.itemsize)
    values = _part(variable, dtype)
    if variable.is_complex:
        values = values + 1j * _part(variable, dtype)
    return values.reshape(variable.shape, order="F")


def _part(variable, dtype):
    """Numbers, real or imaginary, of the next element."""
    elements = variable.elements
    n_values = math.prod(variable.shape)
    kind, stored = elements.take()
    if kind not in STORAGE or len(stored) != n_values * np.dtype(STORAGE[kind]).itemsize:
        found = f"{len(stored)} bytes of type {kind}"
        elements.refuse(f"{n_values} numbers for shape {variable.shape}", found)
    return np.frombuffer(stored, dtype=elements.order + STORAGE[kind]).astype(dtype)


def _members(variable, n_members, depth):
    """Values of the members of a cell or struct array, in MATLAB's order."""
    elements = variable.elements
    # A member takes 8 bytes even where it is empty.
    n_possible = (len(elements.data) - elements.offset) // 8
    if n_members > n_possible:
        elements.refuse(f"at most {n_possible} members", n_members)
    values = []
    for _ in range(n_members):
        kind, member = elements.take()
        if kind != MATRIX:
            elements.refuse("members that are arrays", f"type {kind}")
        if len(member) == 0:
            values.append(np.empty((0, 0)))
        else:
            values.append(_value(_header(elements.within(member)), depth + 1))
    return values


def _structs(variable, depth):
    """A struct as a dict, an array of them as a list of dicts."""
    elements = variable.elements
    kind, stored = elements.take()
    is_number = kind == INT32 and len(stored) == 4
    name_length = elements.unpack("i", stored)[0] if is_number else 0
    if name_length < 1:
        found = f"{len(stored)} bytes of type {kind}"
        elements.refuse("the length of its field names", found)
    _, names = elements.take()
    starts = range(0, len(names), name_length)
    fields = [elements.decode(names[at : at + name_length]) for at in starts]
    if not fields:
        return []
    n_structs = math.prod(variable.shape)
    values = iter(_members(variable, n_structs * len(fields), depth))
    # Each takes as many values as there are fields.
    structs = [dict(zip(fields, values, strict=False)) for _ in range(n_structs)]
    return structs[0] if n_structs == 1 else structs
