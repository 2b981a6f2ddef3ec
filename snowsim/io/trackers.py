"""Trained trackers in files: a network as ONNX, and beside it its card, what it is and can do."""

import hashlib
import json
from importlib import resources
from pathlib import Path

from snowsim import __version__
from snowsim.io.files import write_bytes
from snowsim.io.guard import Refused, library_errors, refusal

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
    write_bytes(path, content)
    write_bytes(path.with_suffix(".json"), f"{text}\n".encode())


def read_tracker(path):
    """Network (ONNX, bytes) and card of a tracker.

    ValueError, in a line, unless the card is whole, of this format and of this very network.
    """
    path = Path(path)
    path_to_card = path.with_suffix(".json")
    with library_errors(path_to_card, "card: expected JSON"):
        card = json.loads(path_to_card.read_text(encoding="utf-8"))
        found = card.get("format") if isinstance(card, dict) else card
        if found != FORMAT:
            msg = f"expected a card of format '{FORMAT}', got {found!r}"
            raise Refused(msg)
    content = path.read_bytes()
    digest = hashlib.sha256(content).hexdigest()
    if card.get("sha256") != digest:
        raise refusal(path, "tracker", f"that of its card, sha256 {card.get('sha256')}", digest)
    return content, card


def shipped_trackers():
    """Paths of the trackers that come with the package, by name."""
    folder = Path(str(resources.files("snowsim"))) / "data"
    found = sorted(folder.glob("*.onnx"))
    return {path.stem: path for path in found if path.with_suffix(".json").is_file()}
