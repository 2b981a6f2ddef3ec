"""Calibration of a trained tracker on annotated scenes, and its reliability there."""

import dataclasses

import pandas as pd
from job import progress, run

from lib.resizing import scenes_in_bins
from lib.tracker_scores import read_tracker
from snowsim.io.files import write_table
from snowsim.tracker.calibration import calibrate as calibration_of
from snowsim.tracker.calibration import fused_logits, ridges_of
from snowsim.tracker.calibration import reliability as curve_of


def calibrate(network, scenes, calibration, reliability, *, bin_shares):
    tracker = read_tracker(network)
    held = scenes_in_bins(scenes, bin_shares)
    logits = [fused_logits(tracker.network, scene.image) for scene in progress(held, "tracked")]
    found = calibration_of(logits, held)
    ridges = ridges_of(logits, held)
    curve = curve_of(found.probability(ridges.logits), ridges.hits)
    write_table(calibration, pd.DataFrame([dataclasses.asdict(found)]))
    write_table(reliability, pd.DataFrame(vars(curve)))


run(calibrate)
