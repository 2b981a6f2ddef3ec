"""Fused edge scores of every setting of the ablation against the default of the same training set."""

from job import run

from lib.diagnostics.tracker_studies import ablation_table
from snowsim.io.files import read_table, write_table
from snowsim.metrics.tables import counts_by_image
from snowsim.seeding import random_stream


def tabulate_ablation(counts, table, *, runs, replicas, n_bootstrap, seed):
    paths = iter(counts)
    by_run = {tuple(run): [counts_by_image(read_table(next(paths))) for _ in replicas] for run in runs}
    rng = random_stream(seed, "tabulate_ablation")
    write_table(table, ablation_table(by_run, n_bootstrap=n_bootstrap, rng=rng))


run(tabulate_ablation)
