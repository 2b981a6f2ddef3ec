"""Figures of the studies of the tracker."""

from job import job

from lib.figures.style import new_figure, note_source, write_figure
from lib.figures.tracker import plot_ablation, plot_chosen, plot_panel, plot_seeds, plot_speed
from snowsim.io.files import read_table


def plot(paths_to_tables, paths_to_figures, source):
    ablation, chosen, seeds, speed, stability = (read_table(path) for path in paths_to_tables)
    figures = []
    figure, axes = new_figure(1, 2, width=9, height=4.5, width_ratios=(2, 1))
    plot_ablation(axes[0, 0], ablation)
    plot_chosen(axes[0, 1], chosen)
    figures.append(figure)

    figure, axes = new_figure(1, 2, width=9)
    for ax, metric in zip(axes.flat, ("ods", "ap"), strict=True):
        plot_seeds(ax, seeds, metric)
    figures.append(figure)

    figure, axes = new_figure(width=5)
    plot_speed(axes[0, 0], speed)
    figures.append(figure)

    figure, axes = new_figure(2, 2, width=8, height=5.5)
    plot_panel(axes[0, 0], stability, "loss", "learning rate", "loss after a short training", "log")
    plot_panel(axes[0, 1], stability, "brightness", "shift [grey levels]", "ODS of fuse")
    plot_panel(axes[1, 0], stability, "rows cut", "rows above a multiple of 16 less", "ODS of fuse")
    plot_panel(axes[1, 1], stability, "layers", "level layers below the surface", "ODS of fuse")
    figures.append(figure)
    for path, figure in zip(paths_to_figures, figures, strict=True):
        note_source(figure, source)
        write_figure(path, figure)


if __name__ == "__main__":
    with job(snakemake):
        plot(snakemake.input[:5], snakemake.output, **snakemake.params)
