"""One observed frame, levelled and at the bin size of the flight, with its layers."""

from types import SimpleNamespace

from job import logger, run

from snowsim.echogram import ECHOGRAM_ALONG_TRACK
from snowsim.frames import count_flagged
from snowsim.io.files import write_dataset
from snowsim.io.frame_table import read_frame


def import_frame(echogram, layers, frame, frame_layers, *, name, reading):
    observed, picked = read_frame(SimpleNamespace(echogram=echogram, layers=layers), **reading)
    n_flagged, flags = count_flagged(observed)
    if flags:
        logger.info(
            "%s: %d of %d range lines left out; flags: %s",
            name,
            n_flagged,
            observed.sizes["slow_time"],
            flags,
        )
    kept = observed[["Data", *ECHOGRAM_ALONG_TRACK]]
    kept.attrs = picked.attrs = {"frame": name, "source": reading["source"], "synthetic": "no"}
    write_dataset(frame, kept)
    write_dataset(frame_layers, picked)


run(import_frame)
