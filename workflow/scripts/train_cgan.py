"""Train the conditional GAN on the observed train scenes and their layers."""

from job import job

from lib.cgan_training import train

with job(snakemake):
    train(
        snakemake.input.scenes,
        snakemake.output.generator,
        snakemake.output.losses,
        threads=snakemake.threads,
        **snakemake.params,
    )
