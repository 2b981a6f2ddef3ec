"""Trained trackers in files: a network as ONNX, and beside it its card, what it is and can do."""

import hashlib
import json
from pathlib import Path

from snowsim import __version__
from snowsim.io.files import written_whole

FORMAT = "snowsim tracker 1"


def write_tracker(path, content, card):
    """Write a network (ONNX, bytes) to `path`, and its card to the JSON file of the same name.

    The card is a dict of what JSON holds; `format`, `sha256` of the network and `created_from`, the
    version of this package, are added.
    """
    path = Path(path)
    head = {
        "name": card["name"],
        "version": card["version"],
        "format": FORMAT,
        "sha256": hashlib.sha256(content).hexdigest(),
        "created_from": f"snowsim {__version__}",
    }
    text = json.dumps(head | card, indent=1, allow_nan=False)
    with written_whole(path) as aside:
        aside.write_bytes(content)
    with written_whole(path.with_suffix(".json")) as aside:
        aside.write_text(f"{text}\n")


def read_tracker(path):
    """Network (ONNX, bytes) and card of a tracker; ValueError, in a line, if they do not fit."""
    path = Path(path)
    content = path.read_bytes()
    path_to_card = path.with_suffix(".json")
    try:
        card = json.loads(path_to_card.read_text())
    except (OSError, ValueError) as error:
        msg = f"{path_to_card}: expected the card of {path.name}, cannot be read: {error}"
        raise ValueError(msg) from error
    if not isinstance(card, dict) or card.get("format") != FORMAT:
        got = card.get("format") if isinstance(card, dict) else card
        msg = f"{path_to_card}: expected a card of format '{FORMAT}', got {got!r}"
        raise ValueError(msg)
    digest = hashlib.sha256(content).hexdigest()
    if card.get("sha256") != digest:
        msg = f"{path}: expected the file of sha256 {card.get('sha256')} that its card names, "
        msg += f"got {digest}"
        raise ValueError(msg)
    return content, card
