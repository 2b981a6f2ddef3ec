"""Statistics of the flight from sums over its frames, and the Doppler spectrum of any segment."""

from job import job

from snowsim.alignment import bin_size_s
from snowsim.io.files import read_dataset, write_dataset
from snowsim.statistics import doppler_spectra, estimate, merge, warn_of_little


def doppler(segment):
    """Variables of the Doppler spectrum under the layers of a complex segment."""
    amplitude = segment["Real"] + 1j * segment["Imaginary"]
    layer_twtt = segment["layer_twtt"].transpose("layer", "slow_time").values
    layer_bins = (layer_twtt - segment["twtt"].values[0]) / bin_size_s(segment)
    wavenumber, first, mean = doppler_spectra(
        amplitude.transpose("twtt", "slow_time").values,
        layer_bins,
        segment.attrs["line_spacing_m"],
    )
    dim = "doppler_wavenumber"
    return {dim: wavenumber, "doppler_layer_1": (dim, first), "doppler_layer_mean": (dim, mean)}


with job(snakemake):
    datasets = [read_dataset(path) for path in snakemake.input.summaries]
    fitted = estimate(merge(datasets), estimator=snakemake.params.estimator)
    warn_of_little(fitted)
    for path in snakemake.input.segment:
        fitted = fitted.assign(doppler(read_dataset(path)))
    synthetic = datasets[0].attrs["synthetic"]
    write_dataset(snakemake.output.statistics, fitted.assign_attrs(synthetic=synthetic))
