"""Figures of the flight's statistics and, where it has frames, of these."""

import numpy as np
from main_path import checkout_files, job

from evaluation.lib.figures import flight
from evaluation.lib.figures.style import Scale, save_figure
from snowsim.io.files import read_dataset, read_table

with job(snakemake):
    frames = snakemake.input.frames
    picks = snakemake.input.picks
    figures = snakemake.output
    params = snakemake.params
    statistics = read_dataset(snakemake.input.statistics)
    save_figure(figures.waveforms_svg, flight.waveforms(statistics), params.source)
    if frames:
        (coast,) = checkout_files(params.coast)
        line = flight.flight_line(map(read_dataset, frames), read_table(coast))
        save_figure(figures.flight_line_svg, line, params.source)
        most = np.argmax([read_dataset(path)["twtt"].count() for path in picks])
        scale = Scale.of(statistics, params.snow_density_kg_m3)
        shown = flight.echogram(read_dataset(frames[most]), read_dataset(picks[most]), scale)
        save_figure(figures.echogram_svg, shown, params.source)
