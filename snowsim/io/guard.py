"""What readers of foreign files share: refusals of one line, a size limit, what a path is."""

from contextlib import contextmanager
from pathlib import Path

ZARR_FILES = (".zgroup", ".zmetadata", "zarr.json")
PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"
# A decompression bomb ends here: the largest frames of the archives are about 30000 x 5000 float32,
# 0.6 GB.
MAXIMUM_BYTES = 2**30


class Refused(ValueError):
    """What is wrong with a file, in words; `library_errors` puts the file's name in front."""


class BadFile(ValueError):
    """What is wrong with a file, in one line that begins with its name."""


def refusal(path, what, expected, found):
    """The error of a bad file, on one line: file, variable, what was expected and found."""
    return BadFile(one_line(f"{path}: {what}: expected {expected}, found {found}"))


def one_line(text, limit=400):
    """Text on one line of printable characters, cut after `limit` of them."""
    printable = "".join(c if c.isprintable() else " " for c in str(text))
    text = " ".join(printable.split())
    return text if len(text) <= limit else text[: limit - 3] + "..."


def report(failed, head):
    """Raise one ValueError of all lines that failed, if any did, after one that counts them."""
    if failed:
        raise ValueError("\n".join([head, *failed]))


@contextmanager
def library_errors(path, expected="expected a whole file"):
    """Turn whatever is wrong with a file within the block into a `BadFile`, a ValueError.

    Any error counts: on flipped bits h5py, scipy, xarray and Pillow raise NameError, SyntaxError,
    zlib.error and many more. `expected` tells of those.
    """
    try:
        yield
    except Exception as error:
        is_line = isinstance(error, ValueError) and str(error).startswith(f"{path}: ")
        if is_line or isinstance(error, BadFile):
            raise  # already the one line, of this file or of one beside it
        told = f"{expected}, found {type(error).__name__} {error}"
        if isinstance(error, Refused):
            told = error
        raise BadFile(one_line(f"{path}: {told}")) from error


def listed(names):
    """Names in order of the alphabet, as a message tells them."""
    return one_line(", ".join(sorted(names)) or "none", 200)


def is_zarr(path):
    """Whether a path is a Zarr store."""
    return any((path / name).is_file() for name in ZARR_FILES)


def is_png(path):
    """Whether a path is a PNG image."""
    path = Path(path)
    if not path.is_file():
        return False
    with path.open("rb") as file:
        return file.read(len(PNG_SIGNATURE)) == PNG_SIGNATURE
