"""One observed frame and its layers, flattened and resampled to the bin size of the flight."""

from types import SimpleNamespace

from job import job

from snowsim.alignment import count_flagged
from snowsim.echogram import ECHOGRAM_ALONG_TRACK
from snowsim.io.files import write_dataset
from snowsim.io.frames import read_frame

with job(snakemake) as log:
    name = snakemake.params.name
    reading = snakemake.params.reading
    row = SimpleNamespace(echogram=snakemake.input.echogram, layers=snakemake.input.layers)
    observed, picked = read_frame(row, **reading)
    n_flagged, flags = count_flagged(observed)
    if flags:
        n_lines = observed.sizes["slow_time"]
        log.info("%s: %d of %d range lines left out; flags: %s", name, n_flagged, n_lines, flags)
    kept = observed[["Data", *ECHOGRAM_ALONG_TRACK]]
    attributes = {"frame": name, "source": reading["source"], "synthetic": "no"}
    kept.attrs = attributes
    picked.attrs = attributes
    write_dataset(snakemake.output.frame, kept)
    write_dataset(snakemake.output.layers, picked)
