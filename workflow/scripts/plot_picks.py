"""Errors of picks, edge scores by zone, and the sheet of side outputs."""

from job import job

from lib.figures.style import new_figure, note_source, write_figure
from lib.figures.tracker import (
    plot_pick_errors,
    plot_picks_by_depth,
    plot_side_outputs,
    plot_zone_differences,
)
from snowsim.io.files import read_dataset, read_table


def plot(
    path_to_picks, path_to_depths, path_to_zones, path_to_samples, picks_figure, zones_figure, sheet_figure, source
):
    picks, depths = read_table(path_to_picks), read_table(path_to_depths)
    figure, axes = new_figure(2, 3, width=10, height=5.5)
    plot_pick_errors(axes[0, 0], picks, "mean_absolute_error_bins", "mean absolute error [range bins]")
    plot_pick_errors(axes[0, 1], picks, "thickness_mean_absolute_error_m", "error of annual thickness [m]")
    plot_pick_errors(axes[0, 2], picks, "share_within", "share of errors within 2 bins")
    plot_pick_errors(axes[1, 0], picks, "n_missed_layers", "missed layers")
    plot_pick_errors(axes[1, 1], picks, "n_false_layers", "false layers")
    plot_picks_by_depth(axes[1, 2], depths, "share_found", "share of layer pixels picked")
    note_source(figure, source)
    write_figure(picks_figure, figure)

    zones = read_table(path_to_zones)
    figure, axes = new_figure(1, 2, width=9, height=3)
    for ax, metric in zip(axes.flat, ("ods", "ap"), strict=True):
        plot_zone_differences(ax, zones, metric)
    note_source(figure, source)
    write_figure(zones_figure, figure)

    samples = read_dataset(path_to_samples)
    rows = [(scene, name) for scene in samples["scene"].values for name in samples["training_set"].values]
    figure, axes = new_figure(len(rows), 7, width=9, height=1.2 * len(rows))
    for row, (scene, training_set) in zip(axes, rows, strict=True):
        plot_side_outputs(row, samples, scene, training_set)
    note_source(figure, source)
    write_figure(sheet_figure, figure)


if __name__ == "__main__":
    with job(snakemake):
        plot(*snakemake.input[:4], *snakemake.output, **snakemake.params)
