"""Statistics of PHY's renders of all label sets beside those they were rendered from."""

from main_path import job

from evaluation.lib.closed_loop import recovery_table
from snowsim.io.files import read_dataset, write_table
from snowsim.statistics import merge

with job(snakemake):
    renders = merge(map(read_dataset, snakemake.input.summaries))
    flight = read_dataset(snakemake.input.statistics)
    table = recovery_table(renders, flight, varies=snakemake.params.varies)
    write_table(snakemake.output.table, table)
