"""The closed loop of the convention PHY uses, value by value and in short, and all conventions side by side."""

import pandas as pd
from job import job

from lib.diagnostics.closed_loop import largest_errors, summarise_loop
from snowsim.io.files import read_dataset, read_table, write_table


def convention_table(conventions, paths_to_tables, paths_to_statistics):
    """A row a convention: what it is, scenes it was tried on, its errors; the least `score` comes closest."""
    rows = []
    for convention, path_to_table, path_to_statistics in zip(
        conventions, paths_to_tables, paths_to_statistics, strict=True
    ):
        names = dict(zip(("estimator", "normalise", "align", "width"), convention.split("_"), strict=True))
        n_scenes = int(read_dataset(path_to_statistics).attrs["n_frames"])
        rows.append(names | {"n_scenes": n_scenes} | largest_errors(read_table(path_to_table)))
    table = pd.DataFrame(rows)
    table.insert(5, "closest", table["score"] == table["score"].min())
    return table


def tabulate(path_to_loop, paths_to_tables, paths_to_statistics, paths_to_outputs, conventions):
    path_to_table, path_to_summary, path_to_conventions = paths_to_outputs
    table = read_table(path_to_loop)
    write_table(path_to_table, table)
    write_table(path_to_summary, summarise_loop(table))
    write_table(path_to_conventions, convention_table(conventions, paths_to_tables, paths_to_statistics))


if __name__ == "__main__":
    with job(snakemake):
        tabulate(
            snakemake.input.table,
            snakemake.input.tables,
            snakemake.input.statistics,
            snakemake.output,
            **snakemake.params,
        )
