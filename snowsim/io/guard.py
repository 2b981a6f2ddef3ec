"""What readers of foreign files share: refusals of one line, a size limit, checks of arrays."""

import math
from contextlib import contextmanager
from pathlib import Path

import numpy as np

ZARR_FILES = (".zgroup", ".zmetadata", "zarr.json")
HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"
# A decompression bomb ends here: the largest frames of the archives are about 30000 x 5000 float32,
# 0.6 GB.
MAXIMUM_BYTES = 2**30


def refusal(path, what, expected, found):
    """The ValueError of a bad file, on one line: file, variable, what was expected and found."""
    return ValueError(one_line(f"{path}: {what}: expected {expected}, found {found}"))


def one_line(text, limit=400):
    """Text on one line of printable characters, cut after `limit` of them."""
    printable = "".join(c if c.isprintable() else " " for c in str(text))
    text = " ".join(printable.split())
    return text if len(text) <= limit else text[: limit - 3] + "..."


@contextmanager
def library_errors(path, what, expected):
    """Turn an error a library raises on a damaged file into the one-line ValueError.

    Nothing else belongs inside. Any error counts: on flipped bits h5py, scipy, xarray and Pillow
    raise NameError, SyntaxError, zlib.error and many more.
    """
    try:
        yield
    except Exception as error:
        if isinstance(error, ValueError) and str(error).startswith(f"{path}: "):
            raise  # already the one line
        raise refusal(path, what, expected, f"{type(error).__name__} {error}") from error


def existing(path, *, directory=False):
    """The path as `Path`; ValueError if nothing is there, or a directory where a file belongs."""
    path = Path(path)
    if not path.exists() or (path.is_dir() and not directory):
        raise refusal(path, "path", "a file", "a directory" if path.is_dir() else "nothing")
    return path


def check_present(path, needed, present, names_in=None):
    """Refuse a file without one of the needed variables, telling those it has.

    These are `names_in(path)`, where only some were read, else those present.
    """
    for name in needed:
        if name not in present:
            names = names_in(path) if names_in else map(str, present)
            raise refusal(path, name, f"variables {', '.join(needed)}", listed(names))


def listed(names):
    """Names in order of the alphabet, as a message tells them."""
    return one_line(", ".join(sorted(names)) or "none", 200)


def check_size(path, what, shape, itemsize):
    """Refuse an array that declares more than `MAXIMUM_BYTES`, before a byte of it is read."""
    n_bytes = math.prod(map(int, shape)) * itemsize
    if n_bytes > MAXIMUM_BYTES:
        found = f"{n_bytes} declared by shape {tuple(shape)}"
        raise refusal(path, what, f"at most {MAXIMUM_BYTES} bytes", found)


def numeric(path, what, array):
    """A real numeric array, or ValueError; booleans count as integers."""
    if array is None:
        raise refusal(path, what, "real numbers", "a function handle or object")
    if not isinstance(array, np.ndarray):
        raise refusal(path, what, "real numbers", type(array).__name__)
    if array.dtype.kind not in "fiub":
        raise refusal(path, what, "real numbers", array.dtype)
    return np.asarray(array)  # sheds subclasses


def vector(path, what, array, length=None):
    """A row, a column or a 1-D array as float64 (length,); ValueError for any other shape."""
    array = numeric(path, what, array)
    if array.ndim > 2 or max(array.shape, default=0) != array.size:
        raise refusal(path, what, "a row or a column", f"shape {array.shape}")
    if length is not None and array.size != length:
        raise refusal(path, what, f"{length} values", f"shape {array.shape}")
    return array.ravel().astype(float)


def matrix(path, what, array, n_rows, n_columns):
    """A 2-D array as (n_rows, n_columns), transposed where only that fits; else ValueError."""
    array = numeric(path, what, array)
    shape = (n_rows, n_columns)
    if array.ndim == 1 and array.size == n_rows * n_columns and 1 in shape:
        return array.reshape(shape)
    if array.shape == shape:
        return array
    if array.shape == shape[::-1]:
        return array.T
    raise refusal(path, what, f"shape {shape}", f"shape {array.shape}")


def is_zarr(path):
    """Whether a path is a Zarr store."""
    return any((path / name).is_file() for name in ZARR_FILES)


def container_of(path):
    """How a file keeps its variables, by its first bytes."""
    if is_zarr(path):
        return "zarr"
    if path.is_dir():
        raise refusal(path, "path", "a file or a Zarr store", "a directory")
    try:
        with path.open("rb") as file:
            head = file.read(4096)
    except OSError as error:
        raise refusal(path, "path", "a readable file", error.strerror) from error
    if head.startswith(b"\x89PNG\r\n\x1a\n"):
        return "png"
    if head.startswith((b"CDF\x01", b"CDF\x02", b"CDF\x05")):
        return "netcdf3"
    # HDF5 lets a block of the user's own stand in front, of 512 bytes times a power of 2;
    # MATLAB writes 512.
    if any(head[at : at + 8] == HDF5_SIGNATURE for at in (0, 512, 1024, 2048)):
        return "hdf5"
    if head[126:128] in (b"IM", b"MI") and head[124:126] in (b"\x00\x01", b"\x01\x00"):
        return "mat5"
    expected = "MAT v5, MAT v7.3, NetCDF, PNG or Zarr"
    raise refusal(path, "content", expected, f"first bytes {head[:8]!r}")
