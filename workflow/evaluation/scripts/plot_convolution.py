"""Accuracy of the convolution model."""

from main_path import run

from evaluation.lib.figures import convolution
from evaluation.lib.figures.style import save_figure
from snowsim.io.files import read_table


def plot_convolution(convolution_accuracy, convolution_accuracy_svg, studies, source):
    (table,) = map(read_table, convolution_accuracy)
    made = map(read_table, studies)
    save_figure(
        convolution_accuracy_svg, convolution.convolution_accuracy(table, made, source), source
    )


run(plot_convolution)
