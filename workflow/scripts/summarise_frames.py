"""Summary of some frames, from which the statistics of the flight are estimated."""

from job import job, progress

from snowsim.io.files import read_dataset, write_dataset
from snowsim.statistics import merge, summarise

with job(snakemake):
    summaries = []
    frames = list(zip(snakemake.input.echograms, snakemake.input.layers, strict=True))
    for path, path_to_layers in progress(frames, "sums over frames"):
        echogram = read_dataset(path)
        summaries.append(summarise(echogram, read_dataset(path_to_layers), where=path))
    # One source makes all frames of a flight.
    synthetic = echogram.attrs.get("synthetic", "no")
    merged = merge(summaries)
    write_dataset(snakemake.output.summary, merged.assign_attrs(synthetic=synthetic))
