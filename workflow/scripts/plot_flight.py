"""An echogram of the sample flight with its picks, and where its frames lie."""

import numpy as np
import pandas as pd
from job import job

from lib.figures.flight import image_with_gaps, plot_picks, plot_positions
from lib.figures.similarity import plot_echogram
from lib.figures.style import new_figure, note_source, write_figure
from snowsim.echogram import layer_bins_of
from snowsim.io.files import read_dataset, write_table


def positions(paths_to_echograms, paths_to_layers):
    """Position and mean thickness of the first slab of every frame."""
    rows = []
    for path, path_to_layers in zip(paths_to_echograms, paths_to_layers, strict=True):
        echogram = read_dataset(path)
        layer_bins = layer_bins_of(read_dataset(path_to_layers), echogram)
        first_slab = np.diff(layer_bins[:2], axis=0)  # empty where the surface alone is picked
        rows.append(
            {
                "latitude_deg": float(echogram["Latitude"].mean()),
                "longitude_deg": float(echogram["Longitude"].mean()),
                "first_slab_bins": float(np.nanmean(first_slab)) if np.isfinite(first_slab).any() else np.nan,
                "n_range_lines": echogram.sizes["slow_time"],
                "picked": float(np.isfinite(layer_bins).mean()),
            }
        )
    return pd.DataFrame(rows)


def plot(paths_to_echograms, paths_to_layers, path_to_table, path_to_echogram_figure, path_to_map, source):
    table = positions(paths_to_echograms, paths_to_layers)
    write_table(path_to_table, table)
    middle = len(paths_to_echograms) // 2
    echogram = read_dataset(paths_to_echograms[middle])
    layer_bins = layer_bins_of(read_dataset(paths_to_layers[middle]), echogram)
    figure, axes = new_figure(1, 2, width=8, height=4, sharey=True)
    image = image_with_gaps(echogram["Data"].transpose("twtt", "slow_time").values)
    for ax, title in zip(axes[0], ("echogram", "with picks"), strict=True):
        plot_echogram(ax, image, title)
    plot_picks(axes[0, 1], layer_bins)
    axes[0, 0].set_ylabel("range bin")
    note_source(figure, source)
    write_figure(path_to_echogram_figure, figure)

    figure, axes = new_figure(width=4.2, height=5.4)
    plot_positions(axes[0, 0], table)
    note_source(figure, source)
    write_figure(path_to_map, figure)


if __name__ == "__main__":
    with job(snakemake):
        plot(snakemake.input.echograms, snakemake.input.layers, *snakemake.output, **snakemake.params)
