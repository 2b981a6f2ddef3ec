"""Figures of the studies of the tracker."""

from main_path import run

from evaluation.lib.figures import study_tracker
from evaluation.lib.figures.style import save_figure
from snowsim.io.files import read_table


def plot_study_tracker(
    ablation, worth, atlas, tracker_ablation_svg, tracker_worth_svg, atlas_tracker_svg, source
):
    save_figure(tracker_ablation_svg, study_tracker.tracker_ablation(read_table(ablation)), source)
    save_figure(tracker_worth_svg, study_tracker.tracker_worth(read_table(worth)), source)
    save_figure(atlas_tracker_svg, study_tracker.atlas_tracker(read_table(atlas)), source)


run(plot_study_tracker)
