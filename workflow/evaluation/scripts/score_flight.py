"""Fused edge scores of every training of one flight."""

from main_path import job

from evaluation.lib.flight_scores import training_scores
from snowsim.io.files import read_table, write_table

with job(snakemake):
    counts = map(read_table, snakemake.input.counts)
    write_table(snakemake.output.scores, training_scores(counts, snakemake.params.trainings))
