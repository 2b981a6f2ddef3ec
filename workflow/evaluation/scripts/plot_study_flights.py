"""Figure of the study of flights."""

from main_path import job

from evaluation.lib.figures.study_flights import flights_worth
from evaluation.lib.figures.style import save_figure
from snowsim.io.files import read_table

with job(snakemake):
    figure = flights_worth(read_table(snakemake.input.worth))
    save_figure(snakemake.output.flights_worth_svg, figure, snakemake.params.source)
