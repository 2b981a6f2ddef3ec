"""Table III with its intervals and curves; scores by zone; errors of picks."""

import pandas as pd
from job import job

from lib import tracker_tables
from lib.score_tables import NAMES, counts_of_runs, tracker_intervals, tracker_table
from snowsim.echogram import zone_of
from snowsim.io.files import read_dataset, read_table, write_table
from snowsim.metrics.picks import pool_picks, snow_per_bin_m
from snowsim.seeding import random_stream

with job(snakemake):
    seed = snakemake.params.seed
    runs = snakemake.params.runs
    n_bootstrap = snakemake.params.n_bootstrap
    flight = read_dataset(snakemake.input.statistics)
    training_sets = list(dict.fromkeys(training_set for training_set, _ in runs))
    n_replicas = len(runs) // len(training_sets)
    tables = [read_table(path) for path in snakemake.input.counts]
    scores = {}
    found = []
    for grid in [name for name in NAMES if name in set(tables[0]["grid"])]:
        scores[grid] = counts_of_runs(tables, training_sets, n_replicas, grid=grid)
        rng = random_stream(seed, "tabulate_trackers")
        found.append(
            tracker_intervals(
                scores[grid], training_sets, grid=grid, n_bootstrap=n_bootstrap, rng=rng
            )
        )
    intervals = pd.concat(found)
    write_table(snakemake.output.intervals, intervals)
    write_table(snakemake.output.table3, tracker_table(intervals))
    curves = tracker_tables.fused_curves(scores["quantiles"], training_sets)
    write_table(snakemake.output.curves, curves)

    picks = [read_table(path) for path in snakemake.input.picks]
    edges = flight["zone_edge_bins"].values
    # Every run has picks of the same scenes, by name as the counts.
    thickness = picks[0].groupby("scene", sort=True)["first_thickness_bins"].first()
    zone = zone_of(thickness, edges)
    by_zone = tracker_tables.intervals_by_zone(
        scores["quantiles"], training_sets, zone, n_bootstrap=n_bootstrap, seed=seed
    )
    write_table(snakemake.output.zones, by_zone)
    rows = tracker_tables.rows_of_picks(picks, runs, edges, snakemake.params.depth_step_bins)
    density = snakemake.params.snow_density_kg_m3
    bin_size_m = snow_per_bin_m(flight.attrs["bin_size_s"], density)
    errors = pool_picks(rows, tracker_tables.RUN, bin_size_m=bin_size_m)
    write_table(snakemake.output.pick_errors, errors)
    by_zone = tracker_tables.picks_by_zone(rows, bin_size_m)
    write_table(snakemake.output.picks_by_zone, by_zone)
    by_depth = tracker_tables.picks_by_depth(rows, bin_size_m)
    write_table(snakemake.output.picks_by_depth, by_depth)
