"""Calibration of a trained tracker on annotated scenes, and its reliability there."""

import dataclasses

import pandas as pd
from job import progress, run

from lib.tracker_scores import read_tracker
from snowsim.io.files import write_table
from snowsim.io.scenes import SceneSet
from snowsim.tracker.calibration import calibrate as calibration_of
from snowsim.tracker.calibration import fused_logits, ridges_of
from snowsim.tracker.calibration import reliability as curve_of


def calibrate(network, scenes, calibration, reliability):
    tracker = read_tracker(network)
    with SceneSet(scenes) as annotated:
        held = list(annotated)
    logits = [fused_logits(tracker.network, scene.image) for scene in progress(held, "tracked")]
    found = calibration_of(logits, held)
    ridges = ridges_of(logits, held)
    curve = curve_of(found.probability(ridges.logits), ridges.hits)
    write_table(calibration, pd.DataFrame([dataclasses.asdict(found)]))
    write_table(reliability, pd.DataFrame(vars(curve)))


run(calibrate)
