"""Sums over some frames, from which the statistics of the flight are estimated."""

from job import job, progress

from snowsim.io.files import read_dataset, write_dataset
from snowsim.statistics import merge, summarise, summary_to_dataset


def summarise_frame(path_to_echogram, path_to_layers):
    """Sums over one frame, and what it says of being synthetic."""
    echogram = read_dataset(path_to_echogram)
    summary = summarise(echogram, read_dataset(path_to_layers), where=path_to_echogram)
    return summary, echogram.attrs.get("synthetic", "no")


def summarise_frames(paths_to_echograms, paths_to_layers, path_to_summary):
    paths = list(zip(paths_to_echograms, paths_to_layers, strict=True))
    summaries, synthetic = zip(*(summarise_frame(*pair) for pair in progress(paths, "sums over frames")), strict=True)
    # One source makes all frames of a flight.
    write_dataset(path_to_summary, summary_to_dataset(merge(summaries)).assign_attrs(synthetic=synthetic[0]))


if __name__ == "__main__":
    with job(snakemake):
        summarise_frames(snakemake.input.echograms, snakemake.input.layers, snakemake.output.summary)
