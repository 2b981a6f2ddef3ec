"""Errors of the convolution model by what causes them, and what each model costs."""

import pandas as pd
from job import job

from lib.figures.convolution import plot_costs, plot_stacks, plot_tails
from lib.figures.style import new_figure, note_source, write_figure
from snowsim.io.files import read_table

SWEEPS = (
    ("density contrast", "density contrast of 20 slabs [kg m-3]", "log"),
    ("layers", "slabs of the default horizon contrast", "log"),
    ("ice lenses", "ice lenses of 3 cm among 20 slabs", "symlog"),
    ("fine layering", "s.d. of fine layering [kg m-3]", "log"),
)


def plot(path_to_table, path_to_figure, studies, source):
    table = pd.concat([read_table(path) for path in (path_to_table, *studies)])
    figure, axes = new_figure(2, 3, width=9.5, height=5.5)
    for ax, (sweep, xlabel, scale) in zip(axes.flat, SWEEPS, strict=False):
        plot_stacks(ax, table, sweep, xlabel, scale)
    axes[0, 0].legend(frameon=False, fontsize=6, loc="upper left")
    plot_tails(axes[1, 1], table)
    plot_costs(axes[1, 2], table)
    missing = "" if studies else "; SMRT: not run (target study_convolution)"
    note_source(figure, f"models beside each other, settings of the {source}{missing}")
    write_figure(path_to_figure, figure)


if __name__ == "__main__":
    with job(snakemake):
        plot(snakemake.input.table, snakemake.output.figure, **snakemake.params)
