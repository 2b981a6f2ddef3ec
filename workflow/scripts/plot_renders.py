"""Where layers lie in renders, against slope and curvature, and texture above and below the surface."""

from job import job

from lib.figures.similarity import plot_position_error, plot_texture
from lib.figures.style import new_figure, note_source, write_figure
from snowsim.io.files import read_table


def plot(path_to_positions, path_to_textures, path_to_positions_figure, path_to_texture_figure, source):
    positions, textures = read_table(path_to_positions), read_table(path_to_textures)
    figure, axes = new_figure(1, 2, width=8, height=3.2, sharey=True)
    for ax, against in zip(axes[0], ("slope", "curvature"), strict=True):
        plot_position_error(ax, positions, against)
    axes[0, 1].set_ylabel("")
    axes[0, 0].legend(loc="lower left")
    note_source(figure, source)
    write_figure(path_to_positions_figure, figure)

    figure, axes = new_figure(2, 2, width=8, height=5.5)
    columns = {
        "deviation": "deviation [grey levels]",
        "autocorrelation_line": "autocorrelation, next range line",
        "autocorrelation_bin": "autocorrelation, next range bin",
        "spectrum_distance_db": "distance of spectra [dB]",
    }
    for ax, (column, label) in zip(axes.flat, columns.items(), strict=True):
        plot_texture(ax, textures, column, label)
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=3)
    note_source(figure, source)
    write_figure(path_to_texture_figure, figure)


if __name__ == "__main__":
    with job(snakemake):
        plot(*snakemake.input[:2], *snakemake.output, **snakemake.params)
