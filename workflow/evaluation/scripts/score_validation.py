"""Fused edge scores of trackers on validation scenes."""

from main_path import job, progress

from evaluation.lib.flight_scores import training_scores
from lib.tracker_scores import count_edges, read_tracker
from snowsim.io.files import write_table
from snowsim.io.scenes import SceneSet

with job(snakemake), SceneSet(snakemake.input.scenes) as scenes:
    trackers = (read_tracker(path).calibrated(scenes) for path in snakemake.input.networks)
    counts = (count_edges(each, scenes, ["fuse"])[0] for each in trackers)
    trainings = progress(snakemake.params.trainings, "trackers")
    write_table(snakemake.output.scores, training_scores(counts, trainings))
