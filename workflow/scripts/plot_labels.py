"""Synthetic labels beside the flight: number of layers, thickness, spectra, correlation of slabs."""

from job import job

from lib.figures.labels import plot_correlation, plot_layer_counts, plot_spectra, plot_thickness
from lib.figures.style import new_figure, note_source, write_figure
from snowsim.io.files import read_table


def plot(path_to_layers, path_to_moments, path_to_spectra, path_to_correlation, path_to_figure, source):
    figure, axes = new_figure(2, 2, width=7, height=5)
    plot_layer_counts(axes[0, 0], read_table(path_to_layers))
    plot_thickness(axes[0, 1], read_table(path_to_moments))
    plot_spectra(axes[1, 0], read_table(path_to_spectra), slab=0)
    plot_correlation(axes[1, 1], read_table(path_to_correlation))
    note_source(figure, source)
    write_figure(path_to_figure, figure)


if __name__ == "__main__":
    with job(snakemake):
        plot(*snakemake.input[:4], *snakemake.output, **snakemake.params)
