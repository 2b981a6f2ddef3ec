"""Table III with its intervals, tests and curves; scores by zone; errors of picks."""

from job import run

from lib import tracker_tables
from lib.score_tables import counts_of_runs, tracker_intervals, tracker_table
from snowsim.echogram import zone_of
from snowsim.io.files import read_dataset, read_table, write_table
from snowsim.metrics.pick_tables import pool_picks, snow_per_bin_m
from snowsim.seeding import random_stream


def tabulate(
    counts, picks, statistics,
    table3, intervals, tests, curves, zones, pick_errors, picks_by_zone, picks_by_depth,
    *, runs, n_bootstrap, depth_step_bins, snow_density_kg_m3, seed,
):  # fmt: skip
    flight = read_dataset(statistics)
    training_sets = list(dict.fromkeys(training_set for training_set, _ in runs))
    n_replicas = len(runs) // len(training_sets)
    scores = counts_of_runs(map(read_table, counts), training_sets, n_replicas)
    rng = random_stream(seed, "tabulate_trackers")
    scored = tracker_intervals(scores, training_sets, n_bootstrap=n_bootstrap, rng=rng)
    write_table(intervals, scored)
    write_table(table3, tracker_table(scored))
    rng = random_stream(seed, "tabulate_trackers", "tests")
    to_first = [(training_set, training_sets[0]) for training_set in training_sets[1:]]
    tested = tracker_tables.paired_tests(scores, to_first, n_bootstrap=n_bootstrap, rng=rng)
    write_table(tests, tested)
    write_table(curves, tracker_tables.fused_curves(scores, training_sets))

    picked = [read_table(path) for path in picks]
    edges = flight["zone_edge_bins"].values
    # Every run has picks of the same scenes, by name as the counts.
    thickness = picked[0].groupby("scene", sort=True)["first_thickness_bins"].first()
    zone = zone_of(thickness, edges)
    by_zone = tracker_tables.intervals_by_zone(
        scores, training_sets, zone, n_bootstrap=n_bootstrap, seed=seed
    )
    write_table(zones, by_zone)
    rows = tracker_tables.rows_of_picks(picked, runs, edges, depth_step_bins)
    bin_size_m = snow_per_bin_m(flight.attrs["bin_size_s"], snow_density_kg_m3)
    write_table(pick_errors, pool_picks(rows, tracker_tables.RUN, bin_size_m=bin_size_m))
    write_table(picks_by_zone, tracker_tables.picks_by_zone(rows, bin_size_m))
    write_table(picks_by_depth, tracker_tables.picks_by_depth(rows, bin_size_m))


run(tabulate)
