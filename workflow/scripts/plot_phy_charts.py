"""Speed against accuracy of PHY's parts and of whole scenes, and growth of cost."""

from job import job

from lib.figures.phy import plot_growth, plot_movement, plot_speed_accuracy
from lib.figures.style import new_figure, note_source, write_figure
from snowsim.io.files import read_table

PLANTED = "planted layers, no observed data"


def plot_waveforms(path_to_runs, path_to_figure):
    figure, axes = new_figure(width=7, height=3.6)
    plot_speed_accuracy(axes[0, 0], read_table(path_to_runs))
    note_source(figure, PLANTED)
    write_figure(path_to_figure, figure)


def plot_speckle(path_to_runs, path_to_figure):
    runs = read_table(path_to_runs)
    figure, axes = new_figure(1, 2, width=9, height=3.4, width_ratios=(3, 2))
    xlabel = "distance of distribution functions from the literal sum"
    plot_movement(axes[0, 1], runs)
    plot_speed_accuracy(axes[0, 0], runs[runs["seconds"].notna()], "distance", xlabel)
    note_source(figure, PLANTED)
    write_figure(path_to_figure, figure)


def plot_scenes(path_to_runs, path_to_figure):
    figure, axes = new_figure(width=7, height=3.6)
    plot_speed_accuracy(axes[0, 0], read_table(path_to_runs))
    note_source(figure, PLANTED)
    write_figure(path_to_figure, figure)


def plot_growths(path_to_runs, path_to_figure):
    runs = read_table(path_to_runs)
    figure, axes = new_figure(1, 2, width=7)
    plot_growth(axes[0, 0], runs[runs["setting"] == "pixels"], "n_pixels", "pixels of a scene of 15 layers", "log")
    plot_growth(axes[0, 1], runs[runs["setting"] == "layers"], "n_layers", "layers of a scene of 1024 x 256 pixels")
    note_source(figure, PLANTED)
    write_figure(path_to_figure, figure)


if __name__ == "__main__":
    with job(snakemake):
        plot_waveforms(snakemake.input.waveforms, snakemake.output.waveforms)
        plot_speckle(snakemake.input.speckle, snakemake.output.speckle)
        plot_scenes(snakemake.input.scenes, snakemake.output.scenes)
        plot_growths(snakemake.input.growth, snakemake.output.growth)
