"""Figures of the closed loop and of the validation."""

from main_path import run

from evaluation.lib.figures import closed_loop as figures
from evaluation.lib.figures.style import save_figure
from snowsim.io.files import read_table


def plot_closed_loop(
    closed_loop,
    validation_thickness,
    validation,
    superposition,
    closed_loop_svg,
    validation_thickness_svg,
    validation_svg,
    superposition_svg,
    source,
):
    loop = figures.closed_loop(*map(read_table, closed_loop), source)
    save_figure(closed_loop_svg, loop, source)
    save_figure(
        validation_thickness_svg,
        figures.validation_thickness(*map(read_table, validation_thickness)),
        source,
    )
    save_figure(validation_svg, figures.validation(*map(read_table, validation)), source)
    save_figure(superposition_svg, figures.superposition(*map(read_table, superposition)), source)


run(plot_closed_loop)
