"""Table III, its intervals, and precision-recall curves from the per-threshold counts."""

import numpy as np
import pandas as pd
from job import job

from snowsim.io.files import read_table, write_table
from snowsim.metrics.comparison import compare
from snowsim.metrics.edges import precision_recall
from snowsim.metrics.tables import counts_of_runs, tracker_intervals, tracker_table
from snowsim.seeding import random_stream


def fused_curves(counts, training_sets):
    """Precision and recall of the fused output at every threshold, means over replicas."""
    frames = []
    for training_set in training_sets:
        curves = [precision_recall(images) for images in counts[training_set, "fuse"]]
        mean = {name: np.mean([curve[name] for curve in curves], axis=0) for name in ("precision", "recall")}
        frames.append(pd.DataFrame({"training_set": training_set, **mean}))
    return pd.concat(frames)


def paired_tests(counts, training_sets, n_bootstrap, rng):
    """Fused scores of every training set against those of the first."""
    fused = {training_set: counts[training_set, "fuse"] for training_set in training_sets}
    pairs = [(training_set, training_sets[0]) for training_set in training_sets[1:]]
    return compare(fused, pairs, n_bootstrap=n_bootstrap, rng=rng).rename(columns={"name": "training_set"})


def tabulate(
    paths_to_counts, path_to_table3, path_to_intervals, path_to_tests, path_to_curves, training_sets, replicas,
    n_bootstrap, seed,
):  # fmt: skip
    counts = counts_of_runs(map(read_table, paths_to_counts), training_sets, len(replicas))
    rng = random_stream(seed, "tabulate_trackers")
    intervals = tracker_intervals(counts, training_sets, n_bootstrap=n_bootstrap, rng=rng)
    write_table(path_to_intervals, intervals)
    write_table(path_to_table3, tracker_table(intervals))
    tests = paired_tests(counts, training_sets, n_bootstrap, random_stream(seed, "tabulate_trackers", "tests"))
    write_table(path_to_tests, tests)
    write_table(path_to_curves, fused_curves(counts, training_sets))


if __name__ == "__main__":
    with job(snakemake):
        tabulate(snakemake.input.counts, *snakemake.output, **snakemake.params)
