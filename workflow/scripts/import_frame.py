"""One observed frame, levelled and at the bin size of the flight, with its layers."""

from types import SimpleNamespace

from job import job

from snowsim.echogram import ECHOGRAM_ALONG_TRACK
from snowsim.frames import count_unfit
from snowsim.io.files import write_dataset
from snowsim.io.frame_table import read_frame


def import_frame(path_to_frame, path_to_layers, path_to_echogram_out, path_to_layers_out, name, reading, log):
    echogram, layers = read_frame(SimpleNamespace(echogram=path_to_frame, layers=path_to_layers), **reading)
    n_unfit, flags = count_unfit(echogram)
    if flags:
        log.info("%s: %d of %d range lines left out; flags: %s", name, n_unfit, echogram.sizes["slow_time"], flags)
    attributes = {"frame": name, "source": reading["source"], "synthetic": "no"}
    kept = echogram[["Data", *ECHOGRAM_ALONG_TRACK]]
    kept.attrs = layers.attrs = attributes
    write_dataset(path_to_echogram_out, kept)
    write_dataset(path_to_layers_out, layers)


if __name__ == "__main__":
    with job(snakemake) as logger:
        import_frame(
            snakemake.input.echogram, snakemake.input.layers, *snakemake.output, log=logger, **snakemake.params
        )
