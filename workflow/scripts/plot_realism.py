"""Row profile, texture, histogram, visibility and thickness of the flight, with what is known of real echograms."""

from job import job

from lib.figures.realism import (
    plot_autocorrelation,
    plot_histogram,
    plot_levels,
    plot_profile,
    plot_standard_histogram,
    plot_standard_profile,
    plot_thickness_spectrum,
    plot_visibility,
)
from lib.figures.style import new_figure, note_source, write_figure
from snowsim.io.files import read_table


def plot(path_to_table, path_to_curves, path_to_figure, source):
    table, curves = read_table(path_to_table), read_table(path_to_curves)
    figure, axes = new_figure(2, 4, width=13, height=5.5)
    plot_profile(axes[0, 0], curves)
    plot_histogram(axes[0, 1], curves)
    plot_autocorrelation(axes[0, 2], curves, table)
    plot_visibility(axes[0, 3], curves)
    plot_standard_profile(axes[1, 0], curves)
    plot_standard_histogram(axes[1, 1], curves)
    plot_thickness_spectrum(axes[1, 2], curves)
    plot_levels(axes[1, 3], table)
    note_source(figure, source)
    write_figure(path_to_figure, figure)


if __name__ == "__main__":
    with job(snakemake):
        plot(*snakemake.input[:2], *snakemake.output, **snakemake.params)
