"""Errors of picks in bins and metres, by training set, by accumulation zone and against depth."""

import numpy as np
import pandas as pd
from job import job

from snowsim.io.files import read_dataset, read_table, write_table
from snowsim.metrics.pick_tables import ZONES, pool_picks, snow_per_bin_m, zone_of

KEYS = ["training_set", "replica"]


def read_rows(paths, runs, zone_edge_bins, depth_step_bins):
    """Rows of all runs, with the zone of every scene and the range of depth of every layer."""
    tables = []
    for (training_set, replica), path in zip(runs, paths, strict=True):
        table = read_table(path)
        zone = zone_of(table["first_thickness_bins"], zone_edge_bins)
        # A false layer above the surface counts with the shallowest.
        depth = np.maximum(np.floor(table["depth_bins"] / depth_step_bins), 0).astype(int) * depth_step_bins
        keys = {"training_set": training_set, "replica": replica}
        tables.append(table.assign(**keys, zone=[ZONES[number + 1] for number in zone], depth_from_bins=depth))
    return pd.concat(tables)


def tabulate(
    paths_to_picks, path_to_statistics, path_to_picks, path_to_zones, path_to_depths, runs, depth_step_bins,
    snow_density_kg_m3,
):  # fmt: skip
    statistics = read_dataset(path_to_statistics)
    rows = read_rows(paths_to_picks, runs, statistics["zone_edge_bins"].values, depth_step_bins)
    bin_size_m = snow_per_bin_m(statistics.attrs["bin_size_s"], snow_density_kg_m3)
    write_table(path_to_picks, pool_picks(rows, KEYS, bin_size_m=bin_size_m))
    by_zone = pool_picks(rows, [*KEYS, "zone"], bin_size_m=bin_size_m)
    order = by_zone["zone"].map(ZONES.index)
    write_table(path_to_zones, by_zone.assign(order=order).sort_values([*KEYS, "order"]).drop(columns="order"))
    by_depth = pool_picks(rows, [*KEYS, "depth_from_bins"], bin_size_m=bin_size_m)
    write_table(path_to_depths, by_depth.sort_values([*KEYS, "depth_from_bins"]))


if __name__ == "__main__":
    with job(snakemake):
        tabulate(
            snakemake.input.picks,
            snakemake.input.statistics,
            *snakemake.output,
            **snakemake.params,
        )
