"""Figure of the cGAN's speed and similarity by width."""

from job import run

from lib.figures.cgan import plot_widths
from lib.figures.style import new_figure, note_source, write_figure
from snowsim.io.files import read_table


def plot(table, figure, *, source):
    runs = read_table(table)
    drawn, axes = new_figure(1, 3, width=9)
    for ax, metric in zip(axes[0], ("psnr", "ssim", "rmse"), strict=True):
        plot_widths(ax, runs, metric)
    axes[0, 0].legend(fontsize=7)
    note_source(drawn, source)
    write_figure(figure, drawn)


run(plot)
