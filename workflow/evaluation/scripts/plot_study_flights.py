"""Figures of the study of flights."""

from main_path import run

from evaluation.lib.figures import study_flights
from evaluation.lib.figures.style import save_figure
from snowsim.io.files import read_table


def plot_study_flights(worth, scores, curve, flights_worth_svg, learning_curve_svg, source):
    of_worth = study_flights.flights_worth(read_table(worth), read_table(scores))
    save_figure(flights_worth_svg, of_worth, source)
    save_figure(learning_curve_svg, study_flights.learning_curve(read_table(curve)), source)


run(plot_study_flights)
