"""What several trainings of every training set say of their differences, and how small a one they could have told."""

from itertools import combinations

from job import run

from snowsim.io.files import read_table, write_table
from snowsim.metrics.comparison import compare
from snowsim.metrics.tables import counts_of_runs
from snowsim.seeding import random_stream


def tabulate_seeds(counts, table, *, training_sets, n_replicas, n_bootstrap, seed):
    of_runs = counts_of_runs(map(read_table, counts), training_sets, n_replicas, outputs=["fuse"])
    fused = {training_set: of_runs[training_set, "fuse"] for training_set in training_sets}
    pairs = [(later, earlier) for earlier, later in combinations(training_sets, 2)]
    compared = compare(fused, pairs, n_bootstrap=n_bootstrap, rng=random_stream(seed, "tabulate_seeds"))
    write_table(table, compared.rename(columns={"name": "training_set"}))


run(tabulate_seeds)
