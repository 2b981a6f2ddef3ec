"""The stability atlas of PHY: a panel per sweep."""

from job import job

from lib.figures.phy import plot_atlas
from lib.figures.style import new_figure, note_source, write_figure
from snowsim.io.files import read_table


def plot(path_to_atlas, path_to_figure):
    figure, axes = new_figure(3, 3, width=10, height=9)
    plot_atlas(figure, axes, read_table(path_to_atlas))
    note_source(figure, "planted layers, no observed data")
    write_figure(path_to_figure, figure)


if __name__ == "__main__":
    with job(snakemake):
        plot(snakemake.input.atlas, *snakemake.output)
