"""Box plots of the three metrics and SSIM against depth."""

from job import job

from lib.figures.similarity import plot_boxes, plot_ssim_depth
from lib.figures.style import new_figure, note_source, write_figure
from snowsim.io.files import read_table


def plot(path_to_images, path_to_ssim_depth, path_to_boxplots, path_to_depth_figure, source):
    images = read_table(path_to_images)
    figure, axes = new_figure(1, 3, width=7)
    for ax, metric in zip(axes.flat, ("ssim", "psnr", "rmse"), strict=True):
        plot_boxes(ax, images, metric)
    note_source(figure, source)
    write_figure(path_to_boxplots, figure)

    figure, axes = new_figure()
    plot_ssim_depth(axes[0, 0], read_table(path_to_ssim_depth))
    note_source(figure, source)
    write_figure(path_to_depth_figure, figure)


if __name__ == "__main__":
    with job(snakemake):
        plot(*snakemake.input[:2], *snakemake.output, **snakemake.params)
