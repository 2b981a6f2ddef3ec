# ruff: noqa: E402
"""Share of picks that are right, by their confidence and by flight.

`python benchmarks/bench_confidence_flights.py RESULTS` follows layers through scenes of the flights
of `studies.transfer`, which `snakemake results/other_flights/FLIGHT/test.nc` draws, with the
package's tracker. It writes `confidence_by_flight.csv` beside this file. A pick is right within 2
of the tracker's range bins of a layer.
"""

import itertools
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import yaml

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "workflow")]

from bench_confidence import EDGES, WITHIN_BINS

from lib.configuration import filled
from pretrained.resizing import resized
from pretrained.scores import Calibrated, followed
from pretrained.transfer import scale_of
from snowsim.io.models import read_tracker, shipped_trackers
from snowsim.io.scenes import SceneSet
from snowsim.tracker import Calibration, fused_logits, near_a_layer, network_of_onnx

N_SCENES = 16  # of each flight


def shipped():
    """The package's tracker as `pretrained.scores` takes it; its bias holds the offset."""
    weights, card = read_tracker(shipped_trackers()["universal"])
    calibration = Calibration(0.0, card["temperature"], card["threshold"], 0.0, 0.0, 0.0, 0.0)
    return Calibrated(network_of_onnx(weights), calibration, tuple(card["confidence"]))


def picks(tracker, path, scale):
    """Confidence of every pick in scenes, and whether it is right, one a row."""
    tables = []
    with SceneSet([path]) as scenes:
        for scene in itertools.islice(scenes, N_SCENES):
            logits = fused_logits(tracker.network, resized(scene.image, scale))
            found = followed(logits, tracker, scene.image.shape)
            picked = np.isfinite(found.bins)
            line = np.nonzero(picked)[1]
            right = near_a_layer(found.bins[picked], line, scene, WITHIN_BINS / scale[0])
            tables.append(pd.DataFrame({"confidence": found.sure[picked], "right": right}))
    return pd.concat(tables)


def main(results):
    """Follow, count and write."""
    config = filled(yaml.safe_load((ROOT / "config/config.yaml").read_text()))
    tracker = shipped()
    tables = []
    for flight in config["studies"]["transfer"]["flights"]:
        path = Path(results) / "other_flights" / flight["name"] / "test.nc"
        scale = scale_of(flight, config["reference"])
        tables.append(picks(tracker, path, scale).assign(flight=flight["name"]))
    rows = pd.concat(tables)
    rows["from"] = pd.cut(rows["confidence"], [0, *EDGES[1:]], labels=EDGES[:-1]).astype(float)
    by_class = rows.groupby(["flight", "from"])
    table = by_class[["confidence", "right"]].mean().round(3)
    table.insert(0, "n_picks", by_class.size())
    table.to_csv(Path(__file__).with_name("confidence_by_flight.csv"), lineterminator="\n")
    print(table["right"].unstack("from").round(2).to_string())  # noqa: T201


if __name__ == "__main__":
    main(sys.argv[1])
