"""Files of networks, unfinished trainings (both safetensors) and trackers (ONNX).

The package safetensors is imported only where it is used, since trackers do not need it.
"""

import hashlib
import json
from pathlib import Path

import numpy as np

from snowsim import __version__
from snowsim.io.files import library_errors, refusal, write_bytes, written_together, written_whole

MODEL_FORMAT = "snowsim model 1"
TRACKER_FORMAT = "snowsim tracker 1"
# All metadata is one header entry: safetensors writes several entries in random order, and equal
# models must have equal bytes.
HEADER_KEY = "snowsim"


def write_model(path, arrays, metadata):
    """Write arrays and metadata to one safetensors file, whole or not at all.

    `arrays` is a nested dict of arrays or CPU tensors; its keys are integers, or texts without `/`.
    `metadata` is a dict that JSON can hold: kind, settings, seed, step, fingerprint of the data.
    The version of this package is added to it.
    """
    from safetensors.numpy import save_file

    header = {"format": MODEL_FORMAT, "version": __version__, **metadata}
    flat = {name: np.asarray(array, order="C") for name, array in _flat(arrays)}
    with written_whole(path) as aside:
        save_file(flat, aside, metadata={HEADER_KEY: json.dumps(header, sort_keys=True)})


def read_model(path, expected=None):
    """Nested dict of arrays (keys are texts) and metadata from a file of `write_model`.

    Nothing in the file is executed. Refused are truncated files, files that are no model, and
    files whose metadata differ from `expected`: the settings, seed and fingerprint of the training
    that the file is to continue.
    """
    from safetensors import safe_open

    with (
        library_errors(path, "model: expected a whole safetensors file"),
        safe_open(path, framework="numpy") as file,
    ):
        metadata = json.loads((file.metadata() or {}).get(HEADER_KEY, "{}"))
        flat = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118, not a dict
    if metadata.get("format") != MODEL_FORMAT:
        found = repr(metadata.get("format"))
        raise refusal(path, "model", f"one of format '{MODEL_FORMAT}'", found)
    wanted = json.loads(json.dumps(expected or {}))
    made = dict(_flat({name: metadata.get(name) for name in wanted}))
    wanted = dict(_flat(wanted))
    for name in sorted(made.keys() | wanted.keys()):
        if made.get(name) != wanted.get(name):
            found = f"{made.get(name)!r}: another configuration made this file"
            raise refusal(path, name.replace("/", ": "), repr(wanted.get(name)), found)
    return _nested(flat), metadata


def fingerprint(paths):
    """SHA-256, in hexadecimal, of the digests of files in their order: identifies training data."""
    digest = hashlib.sha256()
    for path in paths:
        with Path(path).open("rb") as file:
            digest.update(hashlib.file_digest(file, "sha256").digest())
    return digest.hexdigest()


def _flat(nested, prefix=""):
    """Pairs of name and value of a nested dict; names are keys joined by `/`."""
    for key, value in nested.items():
        name = f"{prefix}{key}"
        if isinstance(value, dict):
            yield from _flat(value, f"{name}/")
        else:
            yield name, value


def _nested(flat):
    """Nested dict from names joined by `/`; the inverse of `_flat`."""
    nested = {}
    for name, array in flat.items():
        *parents, leaf = name.split("/")
        inside = nested
        for parent in parents:
            inside = inside.setdefault(parent, {})
        inside[leaf] = array
    return nested


def write_tracker(path, content, card):
    """Write a network (ONNX, bytes) to `path`, and its card to a JSON file of the same name.

    `card` is a dict that JSON can hold. Added to it are `format`, the `sha256` of the network, and
    `created_from`, the version of this package.
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
    with written_together():
        write_bytes(path, content)
        write_bytes(path.with_suffix(".json"), f"{text}\n".encode())


def read_tracker(path):
    """Network (ONNX, bytes) and card of a tracker.

    ValueError if the card is damaged, has another format, or belongs to another network.
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
