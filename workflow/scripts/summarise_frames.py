"""Sums over some frames, from which the statistics of the flight are estimated."""

from job import job, progress

from snowsim.io.files import read_dataset, write_dataset
from snowsim.statistics import merge, summarise, summary_to_dataset


def summarise_frames(paths_to_echograms, paths_to_layers, path_to_summary):
    summaries = []
    paths = list(zip(paths_to_echograms, paths_to_layers, strict=True))
    for path_to_echogram, path_to_layers in progress(paths, "sums over frames"):
        echogram = read_dataset(path_to_echogram)
        summaries.append(summarise(echogram, read_dataset(path_to_layers), where=path_to_echogram))
    synthetic = echogram.attrs.get("synthetic", "no")  # one source makes all frames of a flight
    write_dataset(path_to_summary, summary_to_dataset(merge(summaries)).assign_attrs(synthetic=synthetic))


if __name__ == "__main__":
    with job(snakemake):
        summarise_frames(snakemake.input.echograms, snakemake.input.layers, snakemake.output.summary)
