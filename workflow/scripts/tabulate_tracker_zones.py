"""Fused edge scores by accumulation zone, to see where synthetic data help."""

import pandas as pd
from job import job

from snowsim.io.files import read_dataset, read_table, write_table
from snowsim.metrics.pick_tables import ZONES, zone_of
from snowsim.metrics.tables import counts_of_runs, tracker_intervals
from snowsim.seeding import random_stream


def tabulate(
    paths_to_counts, path_to_picks, path_to_statistics, path_to_table, training_sets, replicas, n_bootstrap, seed
):
    counts = counts_of_runs(map(read_table, paths_to_counts), training_sets, len(replicas), outputs=["fuse"])
    # Counts come by name of the scene, as these do.
    thickness = read_table(path_to_picks).groupby("scene", sort=True)["first_thickness_bins"].first()
    zones = zone_of(thickness, read_dataset(path_to_statistics)["zone_edge_bins"].values)
    tables = []
    for number in range(-1, 4):
        places = [place for place, zone in enumerate(zones) if zone == number]
        if not places:
            continue
        inside = {key: [[images[i] for i in places] for images in of_key] for key, of_key in counts.items()}
        rng = random_stream(seed, "tabulate_tracker_zones", number)
        table = tracker_intervals(inside, training_sets, outputs=["fuse"], n_bootstrap=n_bootstrap, rng=rng)
        table.insert(0, "zone", ZONES[number + 1])
        tables.append(table)
    write_table(path_to_table, pd.concat(tables))


if __name__ == "__main__":
    with job(snakemake):
        tabulate(
            snakemake.input.counts,
            snakemake.input.picks,
            snakemake.input.statistics,
            *snakemake.output,
            **snakemake.params,
        )
