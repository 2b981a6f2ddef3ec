"""How sure the shipped tracker's picks are: coefficients fitted on flights for tuning."""

import pandas as pd
from job import progress, run

from lib.resizing import scenes_in_bins
from lib.tracker_scores import read_calibration, read_tracker
from lib.transfer_scores import Compared, fit_confidence, followed, reliability_of
from snowsim.io.files import write_table
from snowsim.tracker.calibration import fused_logits


def calibrate_picks(network, calibration, scenes, confidence, reliability, *, bin_shares):
    trained = read_tracker(network).network
    calibrated = read_calibration(calibration)
    held = scenes_in_bins(scenes, bin_shares)
    logits = [fused_logits(trained, scene.image) for scene in progress(held, "tracked")]
    found = fit_confidence(logits, held, calibrated)
    tracker = Compared("fitted", trained, calibrated, found)
    pairs = zip(logits, held, strict=True)
    picks = [followed(each, tracker, scene.image.shape) for each, scene in pairs]
    curve = reliability_of(picks, held)
    offset, near, far = found
    row = {"offset": offset, "near": near, "far": far, "deviation": curve.deviation}
    write_table(confidence, pd.DataFrame([row]))
    write_table(reliability, pd.DataFrame(vars(curve)))


run(calibrate_picks)
