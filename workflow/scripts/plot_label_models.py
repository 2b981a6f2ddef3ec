"""Label models with fewer parameters: criteria, spectra, and how far thickness statistics of their scenes change."""

from job import job

from lib.figures.labels import plot_changes, plot_criterion, plot_families
from lib.figures.style import new_figure, note_source, write_figure
from snowsim.io.files import read_table


def plot(path_to_criteria, path_to_savings, path_to_families, path_to_figure, source):
    figure, axes = new_figure(1, 3, width=10, height=3.4)
    plot_criterion(axes[0, 0], read_table(path_to_criteria), "bic")
    plot_families(axes[0, 1], read_table(path_to_families), zone=0)
    plot_changes(axes[0, 2], read_table(path_to_savings))
    note_source(figure, source)
    write_figure(path_to_figure, figure)


if __name__ == "__main__":
    with job(snakemake):
        plot(*snakemake.input[:3], *snakemake.output, **snakemake.params)
