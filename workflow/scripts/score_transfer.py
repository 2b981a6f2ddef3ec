"""Scores of the shipped tracker on flights that it never saw, and their means."""

import pandas as pd
from job import job, progress

from lib.tracker_scores import read_calibration, read_confidence, read_tracker
from lib.transfer_scores import Calibrated, score_tracker
from snowsim.io.files import write_table
from snowsim.io.scenes import SceneSet

with job(snakemake):
    tracker = Calibrated(
        read_tracker(snakemake.input.network).network,
        read_calibration(snakemake.input.calibration),
        read_confidence(snakemake.input.confidence),
    )
    files = dict(zip(snakemake.params.flights, snakemake.input.scenes, strict=True))
    rows = []
    for flight, path in progress(files.items(), "flights"):
        with SceneSet([path]) as annotated:
            scores = score_tracker(tracker, list(annotated), snakemake.params.scales[flight])
        rows.append({"flight": flight, "tracker": "universal", **scores})
    means = pd.DataFrame(rows).mean(numeric_only=True)
    rows.append({"flight": "mean", "tracker": "universal", **means})
    write_table(snakemake.output.table, pd.DataFrame(rows))
