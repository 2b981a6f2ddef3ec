"""Row profile, texture, histogram and visibility of the flight, with what is published of real echograms."""

from job import job

from snowsim.io.figures import write_figure
from snowsim.io.files import read_table
from snowsim.plotting import new_figure, note_source
from snowsim.plotting.realism import plot_autocorrelation, plot_histogram, plot_profile, plot_visibility


def plot(path_to_table, path_to_curves, path_to_figure, source):
    table, curves = read_table(path_to_table), read_table(path_to_curves)
    figure, axes = new_figure(2, 2, width=7.5, height=5.5)
    plot_profile(axes[0, 0], curves)
    plot_autocorrelation(axes[0, 1], curves, table)
    plot_histogram(axes[1, 0], curves)
    plot_visibility(axes[1, 1], curves)
    note_source(figure, source)
    write_figure(path_to_figure, figure)


if __name__ == "__main__":
    with job(snakemake):
        plot(*snakemake.input[:2], *snakemake.output, **snakemake.params)
