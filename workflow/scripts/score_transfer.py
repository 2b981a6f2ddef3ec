"""Scores of all trackers on one flight that only its control was trained on."""

import pandas as pd
from job import progress, run

from lib.resizing import AS_THEY_ARE
from lib.tracker_scores import read_calibration, read_confidence, read_tracker
from lib.transfer_scores import Compared, score_tracker
from snowsim.io.files import write_table
from snowsim.io.scenes import SceneSet


def score_transfer(
    scenes, networks, calibrations, confidence, scores, reliability, *, names, flight, scale
):
    with SceneSet(scenes) as annotated:
        test = list(annotated)
    rows = []
    curves = []
    files = list(zip(names, networks, calibrations, strict=True))
    for name, network, calibration in progress(files, "trackers"):
        calibrated = read_calibration(calibration)
        # All picks are as sure as those of the shipped tracker: linked alike, scored but for that.
        sure = read_confidence(confidence)
        tracker = Compared(name, read_tracker(network).network, calibrated, sure)
        # The control was trained on the flight's own bins and lines.
        row, curve = score_tracker(
            tracker, test, AS_THEY_ARE if name == "control" else tuple(scale)
        )
        rows.append({"flight": flight, **row})
        curves.append(curve.assign(flight=flight))
    write_table(scores, pd.DataFrame(rows))
    write_table(reliability, pd.concat(curves))


run(score_transfer)
