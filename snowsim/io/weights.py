"""A tracker's weights with the card beside them."""

import hashlib
import json
from importlib import resources
from pathlib import Path

from snowsim.io.guard import existing, library_errors, refusal


def shipped_weights():
    """Paths of the weights that come with the package, by name."""
    folder = Path(str(resources.files("snowsim"))) / "data"
    found = sorted(folder.glob("*.onnx"))
    return {path.stem: path for path in found if path.with_suffix(".json").is_file()}


def read_weights(path):
    """Bytes of an ONNX file, and what the JSON card of its name beside it holds.

    ValueError unless the card is whole and of these very weights.
    """
    path = existing(path)
    if path.suffix != ".onnx":
        raise refusal(path, "weights", "a file that ends in .onnx", path.suffix or "no ending")
    path_to_card = existing(path.with_suffix(".json"))
    with library_errors(path_to_card, "card", "JSON"):
        card = json.loads(path_to_card.read_text(encoding="utf-8"))
    weights = path.read_bytes()
    digest = hashlib.sha256(weights).hexdigest()
    told = card.get("sha256") if isinstance(card, dict) else None
    if told != digest:
        raise refusal(path, "weights", f"those of the card, sha256 {told}", digest)
    return weights, card
