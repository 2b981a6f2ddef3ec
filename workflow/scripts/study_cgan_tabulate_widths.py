"""Seconds per step and per render, and similarity on train scenes set aside, by width of the cGAN, beside PHY."""

import pandas as pd
from job import job

from snowsim.io.files import read_table, write_table

METRICS = ["psnr", "ssim", "rmse"]


def tabulate(path_to_speed, path_to_bounds, paths_to_validations, path_to_table, runs):
    seconds = read_table(path_to_speed).groupby(["method", "width", "work"])["seconds"].median()
    rows = []
    for (mode, width), path in zip(runs, paths_to_validations, strict=True):
        validation = read_table(path)
        best = validation.loc[validation["fitness"].idxmax()]
        rows.append(
            {
                "method": "cgan",
                "mode": mode,
                "width": width,
                "n_steps": int(validation["step"].iloc[-1]),
                "seconds_per_step": seconds["cgan", width, "step"],
                "seconds_per_render": seconds["cgan", width, "render"],
                **best[METRICS].to_dict(),
                "n_faults": int(best["n_faults"]),
            }
        )
    bounds = read_table(path_to_bounds)
    same_scenes = (bounds["scenes"] != "test") & (bounds["layers"] == "as picked") & (bounds["method"] == "phy")
    phy = {"method": "phy", "mode": "none", "width": 0, "n_steps": 0, "seconds_per_step": float("nan")}
    phy |= {"seconds_per_render": seconds["phy", 0, "render"]} | bounds.loc[same_scenes, METRICS].iloc[0].to_dict()
    phy |= {"n_faults": 0}
    write_table(path_to_table, pd.DataFrame([*rows, phy]))


if __name__ == "__main__":
    with job(snakemake):
        given = snakemake.input
        tabulate(given.speed, given.bounds, given.validations, *snakemake.output, **snakemake.params)
