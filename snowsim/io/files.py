"""Whole files only: write aside, then rename; datasets and tables to disk and back."""

import errno
import glob
import os
import shutil
import time
from contextlib import contextmanager
from pathlib import Path

from snowsim.io.guard import library_errors

# pandas and xarray are imported where they are used: every job starts with this module, and they
# take half a second each.

# Less is no room: HDF5 keeps about as much in its buffers when it fails.
FULL_DISK_BYTES = 2**20
MOST_TRIES = 20  # to remove a folder
SETTLES_S = 0.02  # between them


@contextmanager
def written_whole(path):
    """Give a name beside `path` to write to; rename it to `path` on success, remove it on failure.

    What a killed process left beside the same path is removed: nobody renames it any more. Where
    HDF5 says only "HDF error", the room that is left shows whether the disk was full. A folder, as
    of Zarr, replaces one of its name.
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    # The ending stays: some writers choose the format by it.
    aside = path.with_name(f".{path.stem}.{os.getpid()}.part{path.suffix}")
    for left in path.parent.glob(f".{glob.escape(path.stem)}.*.part{path.suffix}"):
        _remove(left)
    try:
        yield aside
        if aside.is_dir() and path.is_dir():
            _remove(path)
        aside.replace(path)
    except (OSError, RuntimeError) as error:
        reason = _no_room(path, error)
        if reason is None:
            raise
        msg = f"{path}: cannot be written, {reason}"
        raise OSError(msg) from error
    finally:
        _remove(aside)


def write_bytes(path, content):
    """Write bytes, whole or not at all."""
    with written_whole(path) as aside:
        aside.write_bytes(content)


def _no_room(path, error):
    """Why a file could not be written, if that is for room on its disk; else None."""
    free = shutil.disk_usage(path.parent).free
    number = getattr(error, "errno", None)
    if free < FULL_DISK_BYTES or number == errno.ENOSPC:
        return f"the disk is full: {free} bytes left"
    if number in (errno.EDQUOT, errno.EFBIG) or str(error).startswith("NetCDF: "):
        return getattr(error, "strerror", None) or error
    return None


def _remove(path):
    if not path.is_dir():
        path.unlink(missing_ok=True)
        return
    # Threads of a Zarr store that failed may still write to it.
    for _ in range(MOST_TRIES):
        shutil.rmtree(path, ignore_errors=True)
        time.sleep(SETTLES_S)
        if not path.exists():
            return
    shutil.rmtree(path)


def write_dataset(path, dataset, *, compress=False):
    """Write an xarray dataset as NetCDF-4, whole or not at all.

    Floats keep their type, no fill value is added.
    """
    encoding = {}
    for name, variable in dataset.variables.items():
        if variable.dtype.kind == "f":
            encoding[name] = {"_FillValue": None}
            if compress and variable.ndim:
                encoding[name] |= {"zlib": True, "shuffle": True, "complevel": 9}
    with written_whole(path) as aside:
        dataset.to_netcdf(aside, engine="netcdf4", encoding=encoding)


def read_dataset(path):
    """Read a dataset of `write_dataset` into memory; ValueError if it is no whole NetCDF file."""
    import xarray as xr

    with library_errors(path, "expected a NetCDF-4 file"):
        return xr.load_dataset(path, engine="netcdf4", decode_timedelta=False)


def write_table(path, table):
    """Write a pandas table without its index, as CSV or Parquet by the ending, whole or not."""
    with written_whole(path) as aside:
        if Path(path).suffix == ".parquet":
            table.to_parquet(aside, index=False)
        else:
            table.to_csv(aside, index=False, float_format="%.10g", lineterminator="\n")


def read_table(path):
    """Read a table of `write_table`."""
    import pandas as pd

    return pd.read_parquet(path) if Path(path).suffix == ".parquet" else pd.read_csv(path)
