"""Scores of the shipped tracker on flights that it never saw, and their means; accumulation.

Beside it the ODS of a tracker trained on annotated scenes of each flight.
"""

import pandas as pd
from job import job, progress

from lib.score_tables import counts_by_image
from lib.tracker_scores import count_edges, read_tracker
from pretrained.resizing import AS_THEY_ARE
from pretrained.scores import Calibrated, read_calibration, read_confidence, score_tracker
from pretrained.snow import CLIMATES, Snow, rows_of_flight, snow_of_climate
from snowsim.io.files import write_table
from snowsim.io.scenes import SceneSet
from snowsim.metrics.edges import score

with job(snakemake):
    tracker = Calibrated(
        read_tracker(snakemake.input.network).network,
        read_calibration(snakemake.input.calibration),
        read_confidence(snakemake.input.confidence),
    )
    files = dict(zip(snakemake.params.flights, snakemake.input.scenes, strict=True))
    rows = []
    for (flight, path), own in progress(
        list(zip(files.items(), snakemake.input.own, strict=True)), "flights"
    ):
        with SceneSet([path]) as annotated:
            scores = score_tracker(tracker, list(annotated), snakemake.params.scales[flight])
            counts, _ = count_edges(read_tracker(own), annotated, ["fuse"])
        scores["own_ods"] = score(counts_by_image(counts, "fuse"))["ods"]
        rows.append({"flight": flight, "tracker": "universal", **scores})
    means = pd.DataFrame(rows).mean(numeric_only=True)
    rows.append({"flight": "mean", "tracker": "universal", **means})
    write_table(snakemake.output.table, pd.DataFrame(rows))
    rows = []
    for flight, path in progress(files.items(), "accumulation"):
        with SceneSet([path]) as annotated:
            snows = [Snow(scene, snakemake.params.bin_s[flight]) for scene in annotated]
        rows += rows_of_flight(flight, snows, tracker, snakemake.params.scales[flight])
    for climate, accumulation_m in progress(CLIMATES.items(), "accumulation of climates"):
        snows = snow_of_climate(accumulation_m, snakemake.params.seed, len(snows))
        rows += rows_of_flight(climate, snows, tracker, AS_THEY_ARE)
    write_table(snakemake.output.accumulation, pd.DataFrame(rows))
