"""Layers tracked in two passes over one place, those found in both years in one colour."""

from main_path import run

from evaluation.lib.figures import repeat_pass as figures
from evaluation.lib.figures.style import save_figure
from snowsim.io.files import read_dataset


def plot_repeat_pass(picks, repeat_pass_svg, source):
    save_figure(repeat_pass_svg, figures.repeat_pass(read_dataset(picks)), source)


run(plot_repeat_pass)
