"""Seconds and error of every way to PHY's parts and to whole scenes."""

from main_path import job

from evaluation.lib.speed_accuracy import measured
from snowsim.io.files import write_table
from snowsim.seeding import random_stream

with job(snakemake):
    rng = random_stream(snakemake.params.seed, "measure_phy")
    settings = {"cgan": snakemake.params.cgan, "n_rounds": snakemake.params.n_rounds}
    write_table(snakemake.output.table, measured(**settings, rng=rng))
