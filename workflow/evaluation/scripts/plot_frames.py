"""Figures of the flight's frames, and tables of what two of them show."""

from main_path import run

from evaluation.lib.figures import flight
from evaluation.lib.figures.style import save_figure
from snowsim.io.files import read_dataset, write_table


def plot_frames(
    frame,
    picks,
    frames,
    frame_picks,
    echogram_svg,
    flight_line_svg,
    pixel_grid_svg,
    flight_table,
    pixel_table,
    source,
):
    frame = read_dataset(frame)
    picks = read_dataset(picks)
    save_figure(echogram_svg, flight.echogram(frame, picks), source)
    figure, table = flight.flight_line(map(read_dataset, frames), map(read_dataset, frame_picks))
    write_table(flight_table, table)
    save_figure(flight_line_svg, figure, source)
    figure, table = flight.pixel_grid(frame, picks)
    write_table(pixel_table, table)
    save_figure(pixel_grid_svg, figure, source)


run(plot_frames)
