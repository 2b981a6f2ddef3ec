"""Waveforms of layers, their superposition, and spectra along track, as the flight gave them (Figs 6-8)."""

from job import job

from lib.figures.flight import plot_layer_powers, plot_looks, plot_track_spectra, plot_waveform
from lib.figures.style import new_figure, note_source, write_figure
from snowsim.io.files import read_dataset


def plot(path_to_statistics, path_to_waveforms, path_to_spectra, source):
    statistics = read_dataset(path_to_statistics)
    figure, axes = new_figure(1, 3, width=8)
    for ax, layer in zip(axes[0], (0, 1), strict=False):
        plot_waveform(ax, statistics, layer)
    plot_layer_powers(axes[0, 2], statistics)
    note_source(figure, source)
    write_figure(path_to_waveforms, figure)

    figure, axes = new_figure(1, 2, width=7)
    plot_track_spectra(axes[0, 0], statistics)
    plot_looks(axes[0, 1], statistics)
    note_source(figure, source)
    write_figure(path_to_spectra, figure)


if __name__ == "__main__":
    with job(snakemake):
        plot(snakemake.input.statistics, *snakemake.output, **snakemake.params)
