"""Fused edge scores of trackers against others, by pairs of setting and training set."""

from main_path import run

from evaluation.lib.tracker_studies import runs_table
from lib.score_tables import counts_by_image
from snowsim.io.files import read_table, write_table
from snowsim.seeding import random_stream


def tabulate_ablation(counts, table, *, runs, pairs, replicas, n_bootstrap, seed):
    paths = iter(counts)
    by_run = {}
    for setting, training_set in runs:
        of_replicas = [counts_by_image(read_table(next(paths))) for _ in replicas]
        by_run[setting, training_set] = of_replicas
    pairs = [tuple(map(tuple, pair)) for pair in pairs]
    rng = random_stream(seed, "tabulate_ablation")
    write_table(table, runs_table(by_run, pairs, n_bootstrap=n_bootstrap, rng=rng))


run(tabulate_ablation)
