"""Statistics of the flight from the sums over its frames, with the Doppler spectrum of a complex segment if any."""

from job import job

from snowsim.echogram import bin_size_s
from snowsim.io.files import read_dataset, write_dataset
from snowsim.statistics import doppler_spectra, estimate, merge, summary_from_dataset


def doppler(path_to_segment):
    """Variables of the Doppler spectrum under the layers of a complex segment."""
    segment = read_dataset(path_to_segment)
    amplitude = (segment["Real"] + 1j * segment["Imaginary"]).transpose("twtt", "slow_time").values
    layer_twtt = segment["layer_twtt"].transpose("layer", "slow_time").values
    layer_bins = (layer_twtt - segment["twtt"].values[0]) / bin_size_s(segment)
    wavenumber, first, mean = doppler_spectra(amplitude, layer_bins, segment.attrs["line_spacing_m"])
    dim = "doppler_wavenumber"
    return {dim: wavenumber, "doppler_layer_1": (dim, first), "doppler_layer_mean": (dim, mean)}


def fit_statistics(paths_to_summaries, paths_to_segments, path_to_statistics, estimator):
    datasets = [read_dataset(path) for path in paths_to_summaries]
    statistics = estimate(merge(summary_from_dataset(dataset) for dataset in datasets), estimator=estimator)
    for path in paths_to_segments:
        statistics = statistics.assign(doppler(path))
    write_dataset(path_to_statistics, statistics.assign_attrs(synthetic=datasets[0].attrs["synthetic"]))


if __name__ == "__main__":
    with job(snakemake):
        fit_statistics(
            snakemake.input.summaries, snakemake.input.segment, snakemake.output.statistics, **snakemake.params
        )
