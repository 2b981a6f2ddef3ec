"""Child process of `test_mutations`: read every file of a folder, report each outcome on a line of its own."""

import json
import resource
import sys
from pathlib import Path

from snowsim.io import read_echogram, read_layers
from snowsim.io.images import read_image
from snowsim.io.png_pairs import read_pair

READERS = {
    "echogram": read_echogram,
    "layers": read_layers,
    "image": read_image,
    "pair": read_pair,
}


def values_of(result):
    """What was read, as a list of numbers to compare."""
    if isinstance(result, tuple):  # an image and its text
        return result[0].ravel().tolist()
    if hasattr(result, "layer_bins"):
        return result.layer_bins.ravel().tolist()
    return result["Data" if "Data" in result else "twtt"].values.ravel().tolist()


def main(folder):
    resource.setrlimit(resource.RLIMIT_AS, (8 << 30, 8 << 30))
    for path in sorted(Path(folder).iterdir()):
        what, _, _ = path.name.partition("-")
        print(json.dumps({"file": path.name, "begun": True}), flush=True)  # noqa: T201
        try:
            outcome = {"values": values_of(READERS[what](path))}
        except ValueError as error:
            outcome = {"error": str(error)}
        print(json.dumps({"file": path.name, **outcome}), flush=True)  # noqa: T201


if __name__ == "__main__":
    main(sys.argv[1])
