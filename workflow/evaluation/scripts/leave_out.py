"""Statistics of the flight without one part of the scene model."""

from main_path import job

from evaluation.lib.choices import without
from snowsim.io.files import read_dataset, write_dataset

with job(snakemake):
    flight = read_dataset(snakemake.input.statistics)
    write_dataset(snakemake.output.statistics, without(flight, snakemake.params.part))
