"""Seconds per step and per render, and similarity on held-out train scenes, by width of the cGAN, beside PHY."""

from job import run

from lib.diagnostics.cgan_studies import widths_table
from snowsim.io.files import read_table, write_table


def tabulate(speed, bounds, validations, table, *, runs):
    by_run = {tuple(run): read_table(path) for run, path in zip(runs, validations, strict=True)}
    write_table(table, widths_table(read_table(speed), read_table(bounds), by_run))


run(tabulate)
