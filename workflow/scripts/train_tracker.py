"""Train one tracker on one training set."""

from job import job

from lib.tracker_training import train

with job(snakemake):
    train(
        snakemake.input.real,
        snakemake.input.get("phy", []),
        snakemake.input.get("cgan", []),
        snakemake.input.get("own", []),
        snakemake.output.network,
        snakemake.output.losses,
        threads=snakemake.threads,
        **snakemake.params,
    )
