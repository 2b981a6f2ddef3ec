"""Error of what the closed loop gives back, by layer and by zone, and the conventions of PHY side by side."""

from job import job

from lib.figures.statistics import plot_conventions, plot_layer_errors, plot_slab_errors, plot_spectrum_errors
from lib.figures.style import new_figure, note_source, write_figure
from snowsim.io.files import read_table


def plot(path_to_table, path_to_conventions, path_to_figure, source):
    table = read_table(path_to_table)
    figure, axes = new_figure(2, 3, width=9.5, height=5.5)
    for ax, quantity in zip(axes.flat, ("peak_power", "decay_rate", "width_bins"), strict=False):
        plot_layer_errors(ax, table, quantity)
    plot_slab_errors(axes[1, 0], table, "relative_thickness_mean")
    plot_spectrum_errors(axes[1, 1], table)
    plot_conventions(axes[1, 2], read_table(path_to_conventions))
    note_source(figure, f"{source}, and PHY renders of its statistics")
    write_figure(path_to_figure, figure)


if __name__ == "__main__":
    with job(snakemake):
        plot(*snakemake.input[:2], *snakemake.output, **snakemake.params)
