"""Figures of the label sets."""

from main_path import run

from evaluation.lib.figures import labels as figures
from evaluation.lib.figures.style import save_figure
from snowsim.io.files import read_table


def plot_labels(label_models, labels, label_models_svg, labels_svg, source):
    save_figure(label_models_svg, figures.label_models(*map(read_table, label_models)), source)
    save_figure(labels_svg, figures.labels(*map(read_table, labels)), source)


run(plot_labels)
