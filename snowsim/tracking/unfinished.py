"""Candidates found in frames of a long segment, kept in files until the segment is written."""

import hashlib
import json
from contextlib import suppress
from dataclasses import fields

import numpy as np
import xarray as xr

from snowsim import __version__
from snowsim.io.files import read_arrays, write_arrays
from snowsim.tracker import Candidates, Canonical, Evidence, Grid

FOLDER = ".unfinished"  # in the folder of the layers
# Classes whose fields are arrays, numbers or texts, by the name of such an object in a file.
PARTS = {"candidates": Candidates, "grid": Grid, "canonical": Canonical, "evidence": Evidence}
VALUES = "values"  # of the fields that are no arrays, and attributes, as JSON


class Unfinished:
    """Files of `Evidence` in the folder of the layers, named by the digest of frame and tracker."""

    def __init__(self, folder, card):
        self._folder = folder / FOLDER
        self._card = card
        self._written = []

    def _path(self, digest):
        """File of the frame whose file has this digest."""
        key = hashlib.sha256(f"{self._card} {__version__} {digest}".encode()).hexdigest()
        return self._folder / f"{key[:32]}.npz"

    def keep(self, digest, evidence):
        """Write the evidence of a frame."""
        arrays = to_arrays(evidence)
        path = self._path(digest)
        write_arrays(path, arrays)
        self._written.append(path)

    def read(self, digest):
        """Evidence of a frame, or None if it was not kept, or is damaged."""
        path = self._path(digest)
        if not path.is_file():
            return None
        with suppress(ValueError):
            evidence = from_arrays(read_arrays(path))
            self._written.append(path)
            return evidence
        return None

    def remove(self):
        """Remove the files of the frames that were kept or read; others are other segments'."""
        for path in self._written:
            path.unlink(missing_ok=True)
        with suppress(OSError):  # it is not empty, or was not made
            self._folder.rmdir()


def to_arrays(evidence):
    """Arrays by name from which `from_arrays` makes the same `Evidence`."""
    canonical = evidence.canonical
    objects = {
        "candidates": evidence.candidates,
        "grid": canonical.grid,
        "canonical": canonical,
        "evidence": evidence,
    }
    arrays = {}
    values = {"attrs": canonical.echogram.attrs, "variables": {}}
    for part, each in objects.items():
        for field in fields(each):
            value = getattr(each, field.name)
            name = f"{part}.{field.name}"
            if isinstance(value, np.ndarray):
                arrays[name] = value
            elif not isinstance(value, (xr.Dataset, *PARTS.values())):
                values[name] = value
    for name, variable in canonical.echogram.variables.items():
        values["variables"][name] = [variable.dims, variable.attrs]
        arrays[f"echogram.{name}"] = variable.values
    arrays[VALUES] = np.array(json.dumps(values, default=_plain))
    return arrays


def _plain(value):
    """An array or number of numpy as JSON has it."""
    return value.tolist()


def from_arrays(arrays):
    """`Evidence` from arrays of `to_arrays`."""
    values = json.loads(str(arrays[VALUES]))
    variables = {
        name: (dims, arrays[f"echogram.{name}"], attributes)
        for name, (dims, attributes) in values["variables"].items()
    }
    echogram = xr.Dataset(variables, attrs=values["attrs"]).set_coords("slow_time")
    values["canonical.notes"] = tuple(values["canonical.notes"])
    held = arrays | values
    made = {"canonical.echogram": echogram}
    for part, kind in PARTS.items():
        names = {field.name: f"{part}.{field.name}" for field in fields(kind)}
        known = held | made
        of_part = kind(**{field: known[name] for field, name in names.items()})
        owner = "canonical" if part == "grid" else "evidence"
        made[f"{owner}.{part}"] = of_part
    return of_part
