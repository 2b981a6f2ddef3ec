"""Figures of the flight's frames and of its statistics."""

from main_path import job

from evaluation.lib.figures import flight
from evaluation.lib.figures.style import Scale, save_figure
from snowsim.io.files import read_dataset

with job(snakemake):
    output = snakemake.output
    source = snakemake.params.source
    statistics = read_dataset(snakemake.input.statistics)
    save_figure(output.waveforms_svg, flight.waveforms(statistics), source)
    save_figure(output.along_track_svg, flight.along_track(statistics), source)
    frames = snakemake.input.frames
    picks = snakemake.input.picks
    if frames:
        scale = Scale.of(statistics, snakemake.params.snow_density_kg_m3)
        positions = flight.positions_of(map(read_dataset, frames), map(read_dataset, picks))
        save_figure(output.flight_line_svg, flight.flight_line(positions, scale), source)
        most = positions["n_picks"].argmax()
        shown = flight.echogram(read_dataset(frames[most]), read_dataset(picks[most]), scale)
        save_figure(output.echogram_svg, shown, source)
