"""What several trainings of every training set say of their differences, and how small a one they could have told."""

from itertools import combinations

from job import job

from snowsim.io.files import read_table, write_table
from snowsim.metrics.comparison import compare
from snowsim.metrics.tables import counts_of_runs
from snowsim.seeding import random_stream


def tabulate(paths_to_counts, path_to_table, training_sets, replicas, n_bootstrap, seed):
    counts = counts_of_runs(map(read_table, paths_to_counts), training_sets, len(replicas), outputs=["fuse"])
    fused = {training_set: counts[training_set, "fuse"] for training_set in training_sets}
    pairs = [(later, earlier) for earlier, later in combinations(training_sets, 2)]
    table = compare(fused, pairs, n_bootstrap=n_bootstrap, rng=random_stream(seed, "tabulate_seeds"))
    write_table(path_to_table, table.rename(columns={"name": "training_set"}))


if __name__ == "__main__":
    with job(snakemake):
        tabulate(snakemake.input.counts, *snakemake.output, **snakemake.params)
