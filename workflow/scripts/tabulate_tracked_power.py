"""Quantiles of tracked peak power beside those of the Gamma law of as many looks."""

import pandas as pd
from job import job

from snowsim.io.files import read_dataset, write_table


def tabulate(path_to_statistics, path_to_table):
    statistics = read_dataset(path_to_statistics)
    table = pd.DataFrame(
        {
            "probability": statistics["probability"].values,
            "gamma": statistics["gamma_quantile"].values,
            "tracked": statistics["tracked_power_quantile"].values,
            "n_looks": float(statistics.attrs["n_looks"]),
        }
    )
    write_table(path_to_table, table)


if __name__ == "__main__":
    with job(snakemake):
        tabulate(snakemake.input.statistics, *snakemake.output)
