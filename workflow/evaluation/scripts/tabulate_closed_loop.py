"""The closed loop of the convention PHY uses, and all conventions side by side."""

from main_path import run

from evaluation.lib.closed_loop import convention_table, recover, summarise_loop
from evaluation.lib.conventions import Convention
from snowsim.io.files import read_dataset, read_table, write_dataset, write_table
from snowsim.statistics import merge, summary_from_dataset


def tabulate_closed_loop(
    summaries,
    statistics,
    tried_tables,
    tried_statistics,
    recovered,
    errors,
    table,
    summary,
    conventions,
    *,
    tried,
    varies,
):
    merged = merge(summary_from_dataset(read_dataset(path)) for path in summaries)
    found, compared = recover(merged, read_dataset(statistics), varies=varies)
    write_dataset(recovered, found)
    write_table(errors, compared)
    write_table(table, compared)
    write_table(summary, summarise_loop(read_table(table)))
    n_scenes = [int(read_dataset(path).attrs["n_frames"]) for path in tried_statistics]
    named = [Convention(**choices) for choices in tried]
    rows = zip(named, map(read_table, tried_tables), n_scenes, strict=True)
    write_table(conventions, convention_table(rows))


run(tabulate_closed_loop)
