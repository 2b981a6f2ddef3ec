"""Distributions of the flight beside labels and renders, tests of normality, one line as a sum of layers."""

from job import job

from lib.diagnostics.validation import superposition, validate
from snowsim.io.files import read_dataset, read_table, write_table
from snowsim.seeding import random_stream
from snowsim.statistics import merge, summary_from_dataset


def tabulate(paths_to_summaries, path_to_statistics, path_to_zones, path_to_rendered, paths_to_labels, paths, seed):
    summary = merge(summary_from_dataset(read_dataset(path)) for path in paths_to_summaries)
    statistics = read_dataset(path_to_statistics)
    labels = [read_table(path) for path in paths_to_labels]
    rng = random_stream(seed, "tabulate_validation")
    edges = read_dataset(path_to_zones)["zone_edge_bins"].values
    tables = validate(summary, statistics, read_dataset(path_to_rendered), labels, edges, rng=rng)
    tables["superposition"] = superposition(summary, statistics)
    for name, path in paths.items():
        write_table(path, tables[name])


if __name__ == "__main__":
    with job(snakemake):
        tabulate(
            snakemake.input.summaries,
            snakemake.input.statistics,
            snakemake.input.zones,
            snakemake.input.rendered,
            (snakemake.input.label_layers, snakemake.input.label_histograms),
            dict(snakemake.output.items()),
            **snakemake.params,
        )
