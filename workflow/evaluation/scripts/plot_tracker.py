"""Figures of the trackers."""

from main_path import run

from evaluation.lib.figures import tracker
from evaluation.lib.figures.style import save_figure
from snowsim.io.files import read_dataset, read_table


def plot_tracker(
    picks,
    table3_zones,
    samples,
    precision_recall,
    table3,
    losses,
    picks_svg,
    table3_zones_svg,
    side_outputs_png,
    precision_recall_svg,
    table3_svg,
    tracker_losses_svg,
    source,
):
    save_figure(picks_svg, tracker.picks(*map(read_table, picks)), source)
    save_figure(table3_zones_svg, tracker.table3_zones(*map(read_table, table3_zones)), source)
    save_figure(side_outputs_png, tracker.side_outputs(read_dataset(samples)), source)
    save_figure(
        precision_recall_svg, tracker.precision_recall(*map(read_table, precision_recall)), source
    )
    save_figure(table3_svg, tracker.table3(*map(read_table, table3)), source)
    save_figure(tracker_losses_svg, tracker.tracker_losses(map(read_table, losses)), source)


run(plot_tracker)
