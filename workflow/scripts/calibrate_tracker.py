"""Calibration of the shipped tracker on flights for tuning, and how sure its picks are there."""

import dataclasses

import pandas as pd
from job import job, progress

from lib.tracker_scores import read_tracker
from pretrained.confidence import fit_confidence, pick_curve, threshold_of
from pretrained.resizing import scenes_in_bins
from pretrained.scores import Calibrated, followed, reliability_of
from snowsim.io.files import write_table
from snowsim.tracker import calibrate, fused_logits, reliability, ridges_of

with job(snakemake):
    network = read_tracker(snakemake.input.network).network
    held = scenes_in_bins(snakemake.input.scenes, snakemake.params.bin_shares)
    logits = [fused_logits(network, scene.image) for scene in progress(held, "tracked")]
    calibration = calibrate(logits, held)
    ridges = ridges_of(logits, held)
    curve = reliability(calibration.probability(ridges.logits), ridges.hits)
    write_table(snakemake.output.reliability, pd.DataFrame(vars(curve)))

    curve = pick_curve(logits, held, calibration)
    calibration = dataclasses.replace(calibration, threshold=threshold_of(curve))
    write_table(snakemake.output.curve, curve)
    write_table(snakemake.output.calibration, pd.DataFrame([dataclasses.asdict(calibration)]))

    offset, near, far = fit_confidence(logits, held, calibration)
    tracker = Calibrated(network, calibration, (offset, near, far))
    pairs = zip(logits, held, strict=True)
    picks = [followed(each, tracker, scene.image.shape) for each, scene in pairs]
    curve = reliability_of(picks, held)
    row = {"offset": offset, "near": near, "far": far, "deviation": curve.deviation}
    write_table(snakemake.output.confidence, pd.DataFrame([row]))
    write_table(snakemake.output.pick_reliability, pd.DataFrame(vars(curve)))
