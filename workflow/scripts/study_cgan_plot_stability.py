"""Figure of the stability study of the cGAN."""

from job import job

from lib.figures.cgan import plot_stability
from lib.figures.style import new_figure, note_source, write_figure
from snowsim.io.files import read_table


def plot(path_to_table, path_to_figure, source):
    figure, axes = new_figure(width=5, height=3.5)
    plot_stability(axes[0, 0], read_table(path_to_table))
    note_source(figure, source)
    write_figure(path_to_figure, figure)


if __name__ == "__main__":
    with job(snakemake):
        plot(snakemake.input.table, snakemake.output.figure, **snakemake.params)
