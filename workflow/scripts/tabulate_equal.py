"""Table III of trackers that were all trained with the same number of gradients."""

from job import job

from lib.score_tables import counts_of_runs, tracker_intervals, tracker_table
from snowsim.io.files import read_table, write_table
from snowsim.seeding import random_stream

with job(snakemake):
    training_sets = snakemake.params.training_sets
    tables = [read_table(path) for path in snakemake.input.counts]
    counts = counts_of_runs(tables, training_sets, len(tables) // len(training_sets))
    rng = random_stream(snakemake.params.seed, "tabulate_trackers")
    n_bootstrap = snakemake.params.n_bootstrap
    intervals = tracker_intervals(counts, training_sets, n_bootstrap=n_bootstrap, rng=rng)
    write_table(snakemake.output.table3, tracker_table(intervals))
