"""The stability atlas of the estimators: sweeps, and border cases with the rule that applied."""

from job import job

from lib.figures.statistics import plot_borders, plot_sweeps
from lib.figures.style import new_figure, note_source, write_figure
from snowsim.io.files import read_table


def plot(path_to_atlas, path_to_sweeps, path_to_borders):
    atlas = read_table(path_to_atlas)
    figure, axes = new_figure(3, 5, width=12, height=6.5)
    plot_sweeps(axes, atlas)
    note_source(figure, "planted layers, no observed data")
    write_figure(path_to_sweeps, figure)

    figure, axes = new_figure(1, 1, width=8, height=4.5)
    plot_borders(axes[0, 0], atlas)
    note_source(figure, "planted layers, no observed data")
    write_figure(path_to_borders, figure)


if __name__ == "__main__":
    with job(snakemake):
        plot(snakemake.input.atlas, *snakemake.output)
