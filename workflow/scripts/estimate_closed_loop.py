"""Statistics of renders, zone by zone as the flight's, and their table beside those that went in."""

from job import job

from lib.diagnostics.closed_loop import compare
from snowsim.io.files import read_dataset, write_dataset, write_table
from snowsim.statistics import estimate, merge, summary_from_dataset


def estimate_loop(summary, given, path_to_recovered, path_to_table):
    """Statistics of the renders in a summary, whose own were to be `given`, written with their table."""
    recovered = estimate(summary, estimator=given.attrs["estimator"], zone_edge_bins=given["zone_edge_bins"].values)
    write_dataset(path_to_recovered, recovered.assign_attrs(synthetic="renders by PHY, not observed data"))
    write_table(path_to_table, compare(given, recovered))


if __name__ == "__main__":
    with job(snakemake):
        summary = merge(summary_from_dataset(read_dataset(path)) for path in snakemake.input.summaries)
        estimate_loop(summary, read_dataset(snakemake.input.statistics), *snakemake.output)
