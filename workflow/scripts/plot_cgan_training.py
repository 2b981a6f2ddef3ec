"""Losses of the conditional GAN, and a sheet of what it rendered as it was trained."""

import numpy as np
from job import job

from lib.figures.cgan import plot_losses, plot_validation
from lib.figures.similarity import plot_echogram, plot_layers
from lib.figures.style import new_figure, note_source, write_figure
from snowsim.io.files import read_table
from snowsim.io.scenes import SceneSet

N_STEPS_SHOWN = 4


def plot(path_to_losses, path_to_validation, path_to_samples, path_to_figure, path_to_sheet, source):
    losses, validation = read_table(path_to_losses), read_table(path_to_validation)
    figure, axes = new_figure(1, 3, width=9)
    plot_losses(axes[0, 0], losses, [name for name in losses.columns if name != "step"])
    plot_validation(axes[0, 1], validation, "psnr")
    plot_validation(axes[0, 2], validation, "ssim")
    note_source(figure, source)
    write_figure(path_to_figure, figure)

    with SceneSet(path_to_samples) as samples:
        sheets = {}
        for sample in samples:
            sheets.setdefault(sample.name, []).append(sample)
    steps = [sample.notes["step"] for sample in next(iter(sheets.values()))[1:]]
    shown = sorted({int(n) for n in np.rint(np.linspace(0, len(steps) - 1, N_STEPS_SHOWN))})
    figure, axes = new_figure(len(sheets), 2 + len(shown), width=9, height=1.8 * len(sheets), sharey="row")
    for row, (name, (observed, *rendered)) in zip(axes, sheets.items(), strict=True):
        plot_layers(row[0], observed.layer_bins, observed.n_range_bins, title=f"{name}: layers")
        plot_echogram(row[1], observed.image, title="observed")
        for ax, number in zip(row[2:], shown, strict=True):
            plot_echogram(ax, rendered[number].image, title=f"step {steps[number]}")
    note_source(figure, source)
    write_figure(path_to_sheet, figure)


if __name__ == "__main__":
    with job(snakemake):
        plot(*snakemake.input[:3], *snakemake.output, **snakemake.params)
