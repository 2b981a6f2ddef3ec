"""Figure of the closed loop."""

from main_path import job

from evaluation.lib.figures.closed_loop import closed_loop
from evaluation.lib.figures.style import save_figure
from snowsim.io.files import read_table

with job(snakemake):
    figure = closed_loop(read_table(snakemake.input.table))
    save_figure(snakemake.output.closed_loop_svg, figure, snakemake.params.source)
