"""Means of Table II by seed of the cGAN, their spread, and PHY's."""

import pandas as pd
from job import job

from snowsim.io.files import read_table, write_table

METRICS = ["ssim", "psnr", "rmse"]


def tabulate(path_to_default, paths_to_seeds, path_to_table, seeds):
    default = read_table(path_to_default)
    runs = [default[default["method"] == "cgan"], *(read_table(path) for path in paths_to_seeds)]
    means = pd.DataFrame([run[METRICS].mean() for run in runs], index=[f"cGAN, seed {seed}" for seed in seeds])
    table = pd.concat(
        [
            means,
            means.mean().to_frame("cGAN, mean").T,
            means.std(ddof=1).to_frame("cGAN, standard deviation").T,
            default.loc[default["method"] == "phy", METRICS].mean().to_frame("PHY").T,
        ]
    )
    write_table(path_to_table, table.rename_axis("run").reset_index())


if __name__ == "__main__":
    with job(snakemake):
        tabulate(snakemake.input.default, snakemake.input.seeds, snakemake.output.table, **snakemake.params)
