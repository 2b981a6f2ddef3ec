"""Four range lines of the flight pixel by pixel, with the pixels of three layers."""

import numpy as np
import pandas as pd
from job import job

from snowsim.echogram import layer_bins_of
from snowsim.io.figures import write_figure
from snowsim.io.files import read_dataset, write_table
from snowsim.plotting import new_figure, note_source
from snowsim.plotting.flight import plot_lines_power, plot_pixel_grid

N_LINES, N_LAYERS, MARGIN_BINS = 4, 3, 6


def first_picked_lines(layer_bins):
    """Index of the first of four range lines in a row in which all three layers are picked."""
    picked = np.isfinite(layer_bins[:N_LAYERS]).all(axis=0)
    together = np.lib.stride_tricks.sliding_window_view(picked, N_LINES).all(axis=1)
    if not together.any():
        msg = f"expected {N_LINES} range lines in a row with {N_LAYERS} picked layers, found none"
        raise ValueError(msg)
    return int(np.argmax(together))


def plot(path_to_echogram, path_to_layers, path_to_table, path_to_figure, source):
    echogram = read_dataset(path_to_echogram)
    layer_bins = layer_bins_of(read_dataset(path_to_layers), echogram)
    line = first_picked_lines(layer_bins)
    layer_bins = layer_bins[:N_LAYERS, line : line + N_LINES]
    first, last = int(layer_bins.min()) - MARGIN_BINS, int(layer_bins.max()) + 2 * MARGIN_BINS
    power = echogram["Data"].transpose("twtt", "slow_time").values[first:last, line : line + N_LINES]
    power_db = 10 * np.log10(power)
    bins, lines = np.meshgrid(np.arange(first, last), np.arange(N_LINES), indexing="ij")
    table = {"range_bin": bins.ravel(), "range_line": lines.ravel() + line, "power_db": power_db.ravel()}
    for layer in range(N_LAYERS):
        table[f"layer_{layer}"] = (bins == np.rint(layer_bins[layer])).astype(int).ravel()
    write_table(path_to_table, pd.DataFrame(table))

    figure, axes = new_figure(1, 2, width=6.5, height=4.6, width_ratios=[1, 1.2])
    plot_pixel_grid(axes[0, 0], power_db, layer_bins, first)
    plot_lines_power(axes[0, 1], power_db, layer_bins, first)
    note_source(figure, source)
    write_figure(path_to_figure, figure)


if __name__ == "__main__":
    with job(snakemake):
        plot(*snakemake.input[:2], *snakemake.output, **snakemake.params)
