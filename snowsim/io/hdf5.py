"""HDF5 files opened with care: no links out of the file, no heap that would trap the library, no oversized variable."""

import mmap
import struct
from contextlib import contextmanager

import h5py

from snowsim.io.guard import check_size, library_errors, refusal

HEAP = b"GCOL\x01"  # a global heap collection, version 1: HDF5 File Format Specification, III.E
TEXT_LINK = 16  # bytes of a text's length, heap and place in it
HEAP_HEADER, HEAP_OBJECT = 16, 16  # bytes in front of a collection and of each of its objects


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
        lengths = [length for length, _, _ in struct.iter_unpack("<IQI", links[: len(links) // TEXT_LINK * TEXT_LINK])]
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
        raise refusal(path, f"HDF5 heap at byte {at}", "one within the file", f"one of {length} bytes")
    offset = at + HEAP_HEADER
    while offset + HEAP_OBJECT <= end:
        index, _, _, object_length = struct.unpack_from("<HHIQ", content, offset)
        # The free space, object 0, counts its own header.
        step = object_length if index == 0 else HEAP_OBJECT + -(-object_length // 8) * 8
        if step < HEAP_OBJECT or offset + step > end:
            found = f"object {index} of {object_length} bytes at {offset}"
            raise refusal(path, f"HDF5 heap at byte {at}", f"objects that end by byte {end}", found)
        offset += step
