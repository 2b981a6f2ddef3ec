"""Trained networks, unfinished trainings and trackers in files.

Trackers need no safetensors, which is imported where networks are read and written.
"""

import hashlib
import json
from pathlib import Path

import numpy as np

from snowsim import __version__
from snowsim.io.files import library_errors, refusal, write_bytes, written_whole

FORMAT = "snowsim model 1"
TRACKER_FORMAT = "snowsim tracker 1"
# One header entry: safetensors keeps no order among several, and files must repeat to the byte.
KEY = "snowsim"


def write_model(path, arrays, metadata):
    """Write arrays and what made them to one safetensors file, whole or not at all.

    Arrays or CPU tensors are nested by string or integer keys without `/`; metadata is what JSON
    holds: kind, settings, seed, step, fingerprint of the data. The version of this package is
    added.
    """
    from safetensors.numpy import save_file

    header = {"format": FORMAT, "version": __version__, **metadata}
    flat = {name: np.asarray(array, order="C") for name, array in _flat(arrays)}
    with written_whole(path) as aside:
        save_file(flat, aside, metadata={KEY: json.dumps(header, sort_keys=True)})


def read_model(path, expected=None):
    """Arrays, nested as written with keys as text, and metadata of a file of `write_model`.

    Nothing in it is executed. A file that is truncated, no model, or made with other metadata than
    `expected` is refused: settings, seed and fingerprint of the training it is to continue.
    """
    from safetensors import safe_open

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


def write_tracker(path, content, card):
    """Write a network (ONNX, bytes) to `path`, and its card to the JSON file of the same name.

    The card is a dict of what JSON holds; `format`, `sha256` of the network and `created_from`, the
    version of this package, are added.
    """
    path = Path(path)
    head = {
        "name": card["name"],
        "version": card["version"],
        "format": TRACKER_FORMAT,
        "sha256": hashlib.sha256(content).hexdigest(),
        "created_from": f"snowsim {__version__}",
    }
    text = json.dumps(head | card, indent=1, allow_nan=False)
    write_bytes(path, content)
    write_bytes(path.with_suffix(".json"), f"{text}\n".encode())


def read_tracker(path):
    """Network (ONNX, bytes) and card of a tracker.

    ValueError, in a line, unless the card is whole, of this format and of this very network.
    """
    path = Path(path)
    path_to_card = path.with_suffix(".json")
    with library_errors(path_to_card, f"card of {path.name}: expected JSON"):
        card = json.loads(path_to_card.read_text(encoding="utf-8"))
        found = card.get("format") if isinstance(card, dict) else card
        if found != TRACKER_FORMAT:
            raise refusal(path_to_card, "card", f"one of format '{TRACKER_FORMAT}'", repr(found))
    content = path.read_bytes()
    digest = hashlib.sha256(content).hexdigest()
    if card.get("sha256") != digest:
        raise refusal(path, "tracker", f"that of its card, sha256 {card.get('sha256')}", digest)
    return content, card


def shipped_trackers():
    """Paths of the trackers that come with the package, by name."""
    found = sorted((Path(__file__).parents[1] / "data").glob("*.onnx"))
    return {path.stem: path for path in found if path.with_suffix(".json").is_file()}
