"""Precision-recall curves, scores with intervals, and training losses of the trackers."""

from job import job

from lib.figures.style import COLOURS, NAMES, new_figure, note_source, write_figure
from lib.figures.tracker import plot_losses, plot_precision_recall, plot_scores
from snowsim.io.files import read_table


def plot(path_to_curves, path_to_intervals, paths_to_losses, paths_to_figures, training_sets, source):
    curves_figure, scores_figure, losses_figure = paths_to_figures
    figure, axes = new_figure(width=4, height=3.5)
    plot_precision_recall(axes[0, 0], read_table(path_to_curves))
    note_source(figure, source)
    write_figure(curves_figure, figure)

    intervals = read_table(path_to_intervals)
    figure, axes = new_figure(1, 3, width=7.5)
    for ax, metric in zip(axes.flat, ("ods", "ois", "ap"), strict=True):
        plot_scores(ax, intervals, metric)
    note_source(figure, source)
    write_figure(scores_figure, figure)

    figure, axes = new_figure()
    for training_set, path in zip(training_sets, paths_to_losses, strict=True):
        plot_losses(axes[0, 0], read_table(path), ["total"])
        axes[0, 0].lines[-1].set(color=COLOURS[training_set], label=NAMES[training_set])
    axes[0, 0].legend()
    note_source(figure, source)
    write_figure(losses_figure, figure)


if __name__ == "__main__":
    with job(snakemake):
        plot(
            snakemake.input.curves,
            snakemake.input.intervals,
            snakemake.input.losses,
            snakemake.output,
            **snakemake.params,
        )
