"""Four range lines of the flight pixel by pixel, with the pixels of three layers."""

import numpy as np
import pandas as pd
from job import job

from lib.figures.flight import plot_lines_power, plot_pixel_grid
from lib.figures.style import new_figure, note_source, write_figure
from snowsim.echogram import layer_bins_of
from snowsim.io.files import read_dataset, write_table

N_LINES, N_LAYERS, MARGIN_BINS = 4, 3, 6


def chosen_pixels(layer_bins):
    """First of the four range lines in a row with most picked layers, and the uppermost three of these layers."""
    picked = np.lib.stride_tricks.sliding_window_view(np.isfinite(layer_bins), N_LINES, axis=1).all(axis=2)
    # More than three layers are no better than three: the first such lines are taken.
    line = int(np.argmax(np.minimum(picked.sum(axis=0), N_LAYERS)))
    return line, np.flatnonzero(picked[:, line])[:N_LAYERS]


def chosen_bins(layer_bins, n_range_bins):
    """Range bins to show: those of the layers and some around; the uppermost where no layer is picked."""
    if layer_bins.size == 0:
        return 0, min(8 * MARGIN_BINS, n_range_bins)
    return max(int(layer_bins.min()) - MARGIN_BINS, 0), min(int(layer_bins.max()) + 2 * MARGIN_BINS, n_range_bins)


def plot(path_to_echogram, path_to_layers, path_to_table, path_to_figure, source):
    echogram = read_dataset(path_to_echogram)
    layer_bins = layer_bins_of(read_dataset(path_to_layers), echogram)
    line, layers = chosen_pixels(layer_bins)
    layer_bins = layer_bins[layers, line : line + N_LINES]
    power = echogram["Data"].transpose("twtt", "slow_time").values[:, line : line + N_LINES]
    first, last = chosen_bins(layer_bins, power.shape[0])
    power_db = 10 * np.log10(np.where(power[first:last] > 0, power[first:last], np.nan))  # blank where there is no echo
    bins, lines = np.meshgrid(np.arange(first, last), np.arange(N_LINES), indexing="ij")
    table = {"range_bin": bins.ravel(), "range_line": lines.ravel() + line, "power_db": power_db.ravel()}
    for layer, tracked in zip(layers, layer_bins, strict=True):
        table[f"layer_{layer}"] = (bins == np.rint(tracked)).astype(int).ravel()
    write_table(path_to_table, pd.DataFrame(table))

    figure, axes = new_figure(1, 2, width=6.5, height=4.6, width_ratios=[1, 1.2])
    plot_pixel_grid(axes[0, 0], power_db, dict(zip(layers, layer_bins, strict=True)), first)
    plot_lines_power(axes[0, 1], power_db, layer_bins, first)
    note_source(figure, source)
    write_figure(path_to_figure, figure)


if __name__ == "__main__":
    with job(snakemake):
        plot(*snakemake.input[:2], *snakemake.output, **snakemake.params)
