"""Files that are written whole or not at all, and errors of files as one line."""

import errno
import fcntl
import glob
import gzip
import hashlib
import os
import platform
import shutil
import warnings
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from pathlib import Path

ZARR_FILES = (".zgroup", ".zmetadata", "zarr.json")
# First bytes of image formats.
FIRST_BYTES = {"PNG": b"\x89PNG\r\n\x1a\n", "JPEG": b"\xff\xd8\xff"}
# Files that people have in place of data, by their first bytes in lower case.
NOT_DATA = {
    **dict.fromkeys((b"<!doctype html", b"<html"), "a web page: is a login needed to download it?"),
    b"version https://git-lfs": "a git-LFS pointer: git lfs pull brings the file",
    b"%pdf": "a PDF document",
    **dict.fromkeys((b"\x1f\x8b", b"pk\x03\x04"), "a packed file: unpack it first"),
}
HEAD_BYTES = 100  # by which content is known


class BadFile(ValueError):
    """Error of a file, as one line; if it has no `path`, `library_errors` adds that."""

    def __init__(self, message, path=None):
        super().__init__(one_line(f"{path}: {message}" if path else message))
        self.path = path


def refusal(path, what, expected, found):
    """Error about a bad file: `what` is the variable or part, with expected and found value."""
    return BadFile(f"{what}: expected {expected}, found {found}", path)


def one_line(text, limit=400):
    """Text as one line of at most `limit` printable characters."""
    printable = "".join(c if c.isprintable() else " " for c in str(text))
    text = " ".join(printable.split())
    return text if len(text) <= limit else text[: limit - 3] + "..."


def report(failed, head):
    """Raise one ValueError with the line `head` and all lines of `failed`, unless that is empty."""
    if failed:
        raise ValueError("\n".join([head, *failed]))


@contextmanager
def library_errors(path, expected="expected a whole file"):
    """Turn every error of the block into a `BadFile` (a ValueError) that names the file.

    All exceptions are caught: on damaged files h5py, scipy, xarray and Pillow raise NameError,
    SyntaxError, zlib.error and many more. The message for these begins with `expected`.
    """
    try:
        yield
    except BadFile as error:
        if error.path:
            raise  # this error names its file already: this one, or another that belongs to it
        raise BadFile(error, path) from error
    except Exception as error:
        if isinstance(error, ValueError) and str(error).startswith(f"{path}: "):
            raise
        found = getattr(error, "strerror", None) or f"{type(error).__name__} {error}"
        msg = f"{expected}, found {found}"
        raise BadFile(msg, path) from error


@contextmanager
def noted(path):
    """Context whose warnings about a file become notes, a list of str that is full at its end."""
    notes = []
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", UserWarning)
        yield notes
    for warning in caught:
        if issubclass(warning.category, UserWarning):
            notes.append(str(warning.message).removeprefix(f"{path}: "))
        else:
            warnings.warn_explicit(
                warning.message, warning.category, warning.filename, warning.lineno
            )


def listed(names):
    """Names in alphabetical order, separated by commas, for a message; "none" if there are none."""
    return one_line(", ".join(sorted(map(str, names))) or "none", 200)


def is_zarr(path):
    """True if a path is a Zarr store."""
    return any((path / name).is_file() for name in ZARR_FILES)


def content_of(path, most=-1):
    """Bytes of a file, or the first `most` of them; no bytes for a folder, such as a Zarr store.

    Files of `NOT_DATA`, such as a web page, are refused.
    """
    if path.is_dir():
        return b""
    with path.open("rb") as file:
        content = file.read(most)
    head = content[:HEAD_BYTES].strip(b"\xef\xbb\xbf \t\r\n").lower()
    for start, what in NOT_DATA.items():
        if head.startswith(start):
            raise refusal(path, "content", "data", what)
    return content


def digest_of(path, content):
    """SHA-256 of the `content` of a file, or of all files in a folder, such as a Zarr store."""
    digest = hashlib.sha256(content)
    for file in sorted(path.rglob("*")) if path.is_dir() else ():
        if file.is_file():
            digest.update(str(file.relative_to(path)).encode())
            digest.update(file.read_bytes())
    return digest.hexdigest()


def picture_format(content):
    """Name of the image format of bytes, "PNG" or "JPEG"; None if they are no such image."""
    return next((name for name, start in FIRST_BYTES.items() if content.startswith(start)), None)


def image_format_of(path):
    """Image format of a file, "PNG" or "JPEG", from its first bytes; None for any other file."""
    with library_errors(path):
        return picture_format(content_of(path, HEAD_BYTES))


# pandas and xarray are imported where they are used: every job starts with this module, and they
# take half a second each.

# With less free space than this, the disk counts as full: HDF5 holds about as much in its buffers
# when writing fails.
FULL_DISK_BYTES = 2**20


# Temporary files by the path that each is to replace, in a block of `written_together`; else None.
_set_of_files = ContextVar("set_of_files", default=None)


@contextmanager
def written_together():
    """Let the files that `written_whole` writes in the block replace others all at once, or none.

    They are renamed when the block ends, and removed if it fails: a full disk or an interrupt
    leaves the files that were there. A block within another has files of its own.
    """
    files = {}
    token = _set_of_files.set(files)
    try:
        yield
        for path, aside in files.items():
            aside.replace(path)
    finally:
        _set_of_files.reset(token)
        for aside in files.values():
            aside.unlink(missing_ok=True)


@contextmanager
def written_whole(path):
    """Path of a temporary file, which is renamed to `path` on success and removed on failure.

    If `path` is a symbolic link, the file that it leads to is replaced, and the link stays. In a
    block of `written_together` the file is renamed when that ends. The temporary name is this
    process's own. What processes that no longer run left beside the same path is removed; that of
    other computers stays, since nobody here knows whether they run. Where HDF5 says only "HDF
    error", the room that is left shows whether the disk was full.
    """
    path = Path(path)
    if path.is_symlink():
        path = Path(os.path.realpath(path))
    path.parent.mkdir(parents=True, exist_ok=True)
    before, after = f".{path.stem}.{platform.node()}.", f".part{path.suffix}"
    for left in path.parent.glob(f"{glob.escape(before)}*{glob.escape(after)}"):
        process = left.name.removeprefix(before).removesuffix(after)
        if process.isdecimal() and not _is_running(int(process)):
            left.unlink(missing_ok=True)
    # The ending stays: some writers choose the format by it.
    aside = path.with_name(f"{before}{os.getpid()}{after}")
    files = _set_of_files.get()
    is_kept = False
    try:
        yield aside
        if files is None:
            aside.replace(path)
        else:
            files[path] = aside
            is_kept = True
    except (OSError, RuntimeError) as error:
        reason = _no_room(path, error)
        if reason is None:
            raise
        msg = f"{path}: cannot be written, {reason}"
        raise OSError(msg) from error
    finally:
        if not is_kept:
            aside.unlink(missing_ok=True)


def _is_running(process):
    """True if this computer runs a process with this number."""
    try:
        os.kill(process, 0)  # sends nothing
    except (ProcessLookupError, OverflowError):
        return False
    except PermissionError:  # it is another user's
        return True
    # One that was killed keeps its number until its parent asks for it.
    with suppress(OSError):
        return " Z " not in Path(f"/proc/{process}/stat").read_text().rpartition(")")[2]
    return True


@contextmanager
def locked(folder):
    """Keep other processes that lock the same folder waiting until the block ends.

    The lock is on the folder itself, so that no file is left. On a file system without locks, as
    some of clusters are, nobody waits.
    """
    Path(folder).mkdir(parents=True, exist_ok=True)
    handle = os.open(folder, os.O_RDONLY)
    try:
        with suppress(OSError):
            fcntl.flock(handle, fcntl.LOCK_EX)
        yield
    finally:
        os.close(handle)


def write_bytes(path, content):
    """Write bytes, whole or not at all."""
    with written_whole(path) as aside:
        aside.write_bytes(content)


def _no_room(path, error):
    """Message that the disk is full, if that is why a file was not written; else None."""
    free = shutil.disk_usage(path.parent).free
    number = getattr(error, "errno", None)
    if free < FULL_DISK_BYTES or number == errno.ENOSPC:
        return f"the disk is full: {free} bytes left"
    if number in (errno.EDQUOT, errno.EFBIG) or str(error).startswith("NetCDF: "):
        return getattr(error, "strerror", None) or error
    return None


COMPRESSION = {"zlib": True, "shuffle": True, "complevel": 9}


def write_dataset(path, dataset, *, compress=False, encoding=None):
    """Write an xarray dataset as NetCDF-4, whole or not at all.

    Floats keep their type, and no fill value is added. `encoding` by name of the variable replaces
    this. With `compress`, floats are compressed, and what `encoding` names.
    """
    chosen = encoding or {}
    encoding = {}
    for name, variable in dataset.variables.items():
        if variable.dtype.kind == "f" or name in chosen:
            encoding[name] = chosen.get(name, {"_FillValue": None})
            if compress and variable.ndim:
                encoding[name] = COMPRESSION | encoding[name]
    try:
        with written_whole(path) as aside:
            dataset.to_netcdf(aside, engine="netcdf4", encoding=encoding)
    except UnicodeEncodeError as error:
        raise refusal(path, "name", "one that is valid UTF-8", "other bytes") from error


def read_dataset(path):
    """Dataset, in memory, from a file of `write_dataset`; ValueError if the file is damaged."""
    import xarray as xr

    with library_errors(path, "expected a NetCDF-4 file"):
        return xr.load_dataset(path, engine="netcdf4", decode_timedelta=False)


def write_arrays(path, arrays):
    """Write numpy arrays by name as `.npz`, whole or not at all."""
    import numpy as np

    with written_whole(path) as aside:
        np.savez(aside, **arrays)


def read_arrays(path):
    """Arrays by name from a file of `write_arrays`; ValueError if it is damaged."""
    import numpy as np

    with library_errors(path), np.load(path, allow_pickle=False) as file:
        return dict(file)


def write_table(path, table):
    """Write a pandas table as CSV without its index, whole or not at all.

    A file `.csv.gz`, which the next job reads, is packed and keeps every digit; a file `.csv`,
    which people read, has ten.
    """
    packed = Path(path).suffix == ".gz"
    text = table.to_csv(
        index=False, float_format=None if packed else "%.10g", lineterminator="\n"
    ).encode()
    with written_whole(path) as aside:
        # Without time and name in its header, a packed file has the same bytes at any time.
        aside.write_bytes(gzip.compress(text, 1, mtime=0) if packed else text)


def read_table(path):
    """Pandas table from a file of `write_table`."""
    import pandas as pd

    return pd.read_csv(path)
