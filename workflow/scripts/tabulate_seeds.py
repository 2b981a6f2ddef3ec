"""What several trainings of every training set say of their differences, and how small a one they could have told."""

from itertools import combinations

from job import job
from tabulate_trackers import read_counts

from snowsim.io.files import write_table
from snowsim.metrics.comparison import compare
from snowsim.seeding import random_stream


def tabulate(paths_to_counts, path_to_table, training_sets, replicas, n_bootstrap, seed):
    counts = read_counts(paths_to_counts, training_sets, replicas, outputs=["fuse"])
    fused = {training_set: counts[training_set, "fuse"] for training_set in training_sets}
    pairs = [(later, earlier) for earlier, later in combinations(training_sets, 2)]
    table = compare(fused, pairs, n_bootstrap=n_bootstrap, rng=random_stream(seed, "tabulate_seeds"))
    write_table(path_to_table, table.rename(columns={"name": "training_set"}))


if __name__ == "__main__":
    with job(snakemake):
        tabulate(snakemake.input.counts, *snakemake.output, **snakemake.params)
