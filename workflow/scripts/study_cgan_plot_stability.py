"""Figure of the stability study of the cGAN."""

from job import job

from snowsim.io.figures import write_figure
from snowsim.io.files import read_table
from snowsim.plotting import new_figure, note_source
from snowsim.plotting.cgan import plot_stability


def plot(path_to_table, path_to_figure, source):
    figure, axes = new_figure(width=5, height=3.5)
    plot_stability(axes[0, 0], read_table(path_to_table))
    note_source(figure, source)
    write_figure(path_to_figure, figure)


if __name__ == "__main__":
    with job(snakemake):
        plot(snakemake.input.table, snakemake.output.figure, **snakemake.params)
