"""Thickness by zone with its Gaussian, flight beside labels and renders, and one averaged line as a sum of layers."""

from job import job

from lib.figures.labels import (
    plot_correlation,
    plot_distribution,
    plot_first_thickness,
    plot_given_and_recovered,
    plot_spectra,
    plot_superposition,
    plot_test_values,
    plot_thickness_histogram,
)
from lib.figures.style import new_figure, note_source, write_figure
from snowsim.io.files import read_table

SHOWN_SLABS = (0, 4)


def plot_thickness(path, thickness, tests, source):
    zones = sorted(thickness.loc[thickness["slab"] == 0, "zone"].unique())[:4]
    figure, axes = new_figure(len(SHOWN_SLABS), 4, width=10, height=4.6)
    for i, slab in enumerate(SHOWN_SLABS):
        for j, zone in enumerate(zones):
            plot_thickness_histogram(axes[i, j], thickness, tests, zone, slab)
    axes[0, 0].legend(fontsize=6)
    for ax in axes[:, 0]:
        ax.set_ylabel("share per bin")
    note_source(figure, source)
    write_figure(path, figure)


def plot_flight_and_labels(path, tables, source):
    figure, axes = new_figure(3, 3, width=10, height=7.5)
    plot_distribution(axes[0, 0], tables["distributions"], "n_layers", "layers below the surface", ("flight", "labels"))
    plot_first_thickness(axes[0, 1], tables["thickness"])
    plot_test_values(axes[0, 2], tables["tests"])
    for ax, slab in zip(axes[1], (0, 4), strict=False):
        plot_spectra(ax, tables["spectra"], slab)
    plot_correlation(axes[1, 2], tables["correlation"])
    plot_given_and_recovered(axes[2, 0], tables["loop"], "peak_power", "peak power [dB]", decibels=True)
    plot_given_and_recovered(axes[2, 1], tables["loop"], "decay_rate", "decay rate [1 / bin]")
    plot_distribution(axes[2, 2], tables["distributions"], "width_bins", "1/e width of averaged lines [bins]")
    note_source(figure, source)
    write_figure(path, figure)


def plot_line(path, line, source):
    figure, axes = new_figure(1, 1, width=8, height=3.4)
    plot_superposition(axes[0, 0], line)
    note_source(figure, source)
    write_figure(path, figure)


def plot(paths_to_tables, paths_to_figures, source):
    tables = {name: read_table(path) for name, path in paths_to_tables.items() if name != "code"}
    plot_thickness(paths_to_figures["thickness"], tables["thickness"], tables["tests"], source)
    plot_flight_and_labels(paths_to_figures["validation"], tables, source)
    plot_line(paths_to_figures["superposition"], tables["superposition"], source)


if __name__ == "__main__":
    with job(snakemake):
        plot(dict(snakemake.input.items()), dict(snakemake.output.items()), **snakemake.params)
