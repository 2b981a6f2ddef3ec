"""Figures of the flight's statistics."""

from main_path import run

from evaluation.lib.figures import flight
from evaluation.lib.figures.style import save_figure
from snowsim.io.files import read_dataset


def plot_flight(statistics, waveforms_svg, along_track_svg, source):
    statistics = read_dataset(statistics)
    save_figure(waveforms_svg, flight.waveforms(statistics), source)
    save_figure(along_track_svg, flight.along_track(statistics), source)


run(plot_flight)
