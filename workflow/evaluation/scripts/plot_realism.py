"""The flight beside real Snow Radar."""

from main_path import run

from evaluation.lib.figures import realism as figures
from evaluation.lib.figures.style import save_figure
from snowsim.io.files import read_table


def plot_realism(realism, realism_svg, source):
    save_figure(realism_svg, figures.realism(*map(read_table, realism)), source)


run(plot_realism)
