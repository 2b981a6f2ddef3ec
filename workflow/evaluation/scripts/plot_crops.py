"""Crops of the flight beside those of real Snow Radar."""

from main_path import run

from evaluation.lib.figures import realism
from evaluation.lib.figures.style import save_figure
from snowsim.io.files import read_dataset


def plot_crops(crops, realism_crops_svg, source):
    save_figure(realism_crops_svg, realism.realism_crops(read_dataset(crops)), source)


run(plot_crops)
