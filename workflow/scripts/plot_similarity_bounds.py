"""Figure of the bounds of similarity, of what keeps renders from them, and of texture in the air."""

from job import job

from lib.figures.cgan import plot_air, plot_annotation, plot_cases, plot_parts
from lib.figures.style import new_figure, note_source, write_figure
from snowsim.io.files import read_table


def plot(path_to_bounds, path_to_parts, path_to_air, path_to_figure, source):
    bounds, parts, air = (read_table(path) for path in (path_to_bounds, path_to_parts, path_to_air))
    figure, axes = new_figure(2, 3, width=10, height=5.5)
    for ax, metric in zip(axes[0], ("psnr", "ssim", "rmse"), strict=True):
        plot_cases(ax, bounds, metric)
        if ax is not axes[0, 0]:
            ax.set_yticklabels([])
    axes[0, 0].legend(fontsize=6, loc="upper left")
    plot_parts(axes[1, 0], parts)
    plot_annotation(axes[1, 1], bounds, "psnr")
    plot_air(axes[1, 2], air, "air_blotches", "blotches in the air [grey levels]")
    note_source(figure, source)
    write_figure(path_to_figure, figure)


if __name__ == "__main__":
    with job(snakemake):
        plot(*snakemake.input[:3], snakemake.output.figure, **snakemake.params)
