"""Sums over one frame, from which the statistics of the flight are estimated."""

from job import job

from snowsim.io.files import read_dataset, write_dataset
from snowsim.statistics import summarise, summary_to_dataset


def summarise_frame(path_to_echogram, path_to_layers, path_to_summary):
    echogram = read_dataset(path_to_echogram)
    summary = summarise(echogram, read_dataset(path_to_layers), where=path_to_echogram)
    dataset = summary_to_dataset(summary)
    write_dataset(path_to_summary, dataset.assign_attrs(synthetic=echogram.attrs.get("synthetic", "no")))


if __name__ == "__main__":
    with job(snakemake):
        summarise_frame(snakemake.input.echogram, snakemake.input.layers, snakemake.output.summary)
