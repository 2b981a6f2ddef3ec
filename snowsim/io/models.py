"""Trained networks and unfinished trainings on disk, with what made them in the header."""

import hashlib
import json
from pathlib import Path

import numpy as np
from safetensors import safe_open
from safetensors.numpy import save_file

from snowsim import __version__
from snowsim.io.files import written_whole
from snowsim.io.guard import library_errors, refusal

FORMAT = "snowsim model 1"
# One header entry: safetensors keeps no order among several, and files must repeat to the byte.
KEY = "snowsim"


def write_model(path, arrays, metadata):
    """Write arrays and what made them to one safetensors file, whole or not at all.

    Arrays or CPU tensors are nested by string or integer keys without `/`; metadata is what JSON
    holds: kind, settings, seed, step, fingerprint of the data. The version of this package is
    added.
    """
    header = {"format": FORMAT, "version": __version__, **metadata}
    flat = {name: np.asarray(array, order="C") for name, array in _flat(arrays)}
    with written_whole(path) as aside:
        save_file(flat, aside, metadata={KEY: json.dumps(header, sort_keys=True)})


def read_model(path, expected=None):
    """Arrays, nested as written with keys as text, and metadata of a file of `write_model`.

    Nothing in it is executed. A file that is truncated, no model, or made with other metadata than
    `expected` is refused: settings, seed and fingerprint of the training it is to continue.
    """
    with (
        library_errors(path, "model: expected a whole safetensors file"),
        safe_open(path, framework="numpy") as file,
    ):
        metadata = json.loads((file.metadata() or {}).get(KEY, "{}"))
        flat = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118, not a dict
    if metadata.get("format") != FORMAT:
        raise refusal(path, "model", f"one of format '{FORMAT}'", repr(metadata.get("format")))
    wanted = json.loads(json.dumps(expected or {}))
    made = dict(_flat({name: metadata.get(name) for name in wanted}))
    wanted = dict(_flat(wanted))
    for name in sorted(made.keys() | wanted.keys()):
        if made.get(name) != wanted.get(name):
            found = f"{made.get(name)!r}: another configuration made this file"
            raise refusal(path, name.replace("/", ": "), repr(wanted.get(name)), found)
    return _nested(flat), metadata


def fingerprint(paths):
    """SHA-256 over the bytes of files, in order, in hexadecimal: what a model was trained on."""
    digest = hashlib.sha256()
    for path in paths:
        with Path(path).open("rb") as file:
            digest.update(hashlib.file_digest(file, "sha256").digest())
    return digest.hexdigest()


def _flat(nested, prefix=""):
    for key, value in nested.items():
        name = f"{prefix}{key}"
        if isinstance(value, dict):
            yield from _flat(value, f"{name}/")
        else:
            yield name, value


def _nested(flat):
    nested = {}
    for name, array in flat.items():
        *parents, leaf = name.split("/")
        inside = nested
        for parent in parents:
            inside = inside.setdefault(parent, {})
        inside[leaf] = array
    return nested
