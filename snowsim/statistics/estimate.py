"""From the merged summaries of a flight to its statistics, by either estimator."""

from dataclasses import dataclass

import numpy as np
import xarray as xr

from snowsim.constants import BLOCK_LINES
from snowsim.echogram import check_choice
from snowsim.limits import check_count
from snowsim.rounding import rounded
from snowsim.statistics.by_layer import LAGS, deblended_values, paper_values
from snowsim.statistics.lines import Groups
from snowsim.statistics.moments import ERROR_BITS, SHARED_BITS
from snowsim.statistics.paper import is_present, measure_groups, tracked_moments
from snowsim.statistics.radiometry import LAW_FALLS, power_on_picks, radiometry
from snowsim.statistics.speckle import (
    MOST_LOOKS,
    compare_with_gamma,
    detected_power_spectra,
    range_correlation,
)
from snowsim.statistics.summaries import AIR_MARGIN_BINS, GROUP_LINES, stacked, stacked_tracked
from snowsim.statistics.thickness import thickness_statistics

ESTIMATORS = ("deblended", "paper")
LEAST_SHARE = 2.0**-40  # of a variable's largest value; below lies rounding
MINIMUM_GROUPS = 5  # averaged lines a layer must be in to be reported
WIDTH_EDGES = np.arange(0, 40.5, 0.5)
UNITS = {
    "_bins": "range bin",
    "_bins2": "range bin^2",
    "_rate": "1/range bin",
    "_psd": "range bin^2 line/cycle",
    "_db": "dB",
    "_db2": "dB^2",
    "_lines": "range line",
    "_m": "m",
}  # by the ending of the name
LINEAR_POWER = (
    "peak_power",
    "noise_power",
    "background_power",
    "mean_waveform",
    "model_waveform",
    "layer_waveform",
)


def estimate(summary, *, estimator="deblended", zone_edge_bins=None):
    """Statistics of a flight from its merged summary.

    Parameters
    ----------
    summary : list of FrameSummary
        Of `merge`.
    estimator : {"deblended", "paper"}
    zone_edge_bins : array_like, (edge,), optional
        Zones to use instead of the flight's own quartiles, to compare two flights zone by zone.

    Returns
    -------
    xarray.Dataset
        The variables of the public interface, each with `<name>_standard_error`: `peak_power`,
        `decay_rate`, `width_bins`, `variance_bins2 (layer)`, `width_bound_bins (bound)`,
        `noise_power`, `zone_edge_bins (edge)`, `thickness_mean_bins`, `thickness_variance_bins2`,
        `relative_thickness_mean`, `relative_thickness_variance (zone, slab)`, and what else
        `thickness_statistics` gives. Beside them: counts (`n_picks`, `n_groups (layer)`), rules
        applied (`substituted (layer)`), `offset_bins (layer)` of the waveform's peak below the
        pick, the width histogram, mean waveforms, tracked
        power against Gamma(M), autocorrelation of speckle down range (`speckle_correlation
        (speckle_lag)`, by range bins from 0, and the attribute `speckle_correlation_source`, see
        `range_correlation`), along-track spectra of power, and how power, noise and decay vary, see
        `radiometry`.

    Raises
    ------
    ValueError
        If the estimator is unknown, there is no air above the surface, no layer, or what
        `thickness_statistics` refuses.

    Notes
    -----
    Layers are reported down to the last that is in `MINIMUM_GROUPS` averaged lines. If a layer
    yields no value of its own, `substituted` is 1: `paper` takes decay rate or width from the layer
    above; `deblended` replaces a power below two standard errors by tracked power above noise,
    times the share that deblending leaves of the other layers. The power of a layer that is never
    picked is interpolated in dB between its neighbours'. Only the decay rate of the deepest layer
    in `paper` is NaN.
    """
    check_choice("estimator", estimator, ESTIMATORS)
    check_count("frames of a flight", len(summary))
    noise = _noise(summary)
    groups, n_seen = _groups(summary, noise.power)
    n_layers = groups.present.shape[1]
    tracked = tracked_moments(summary, n_layers)
    decay, width = measure_groups(groups.power, groups.position.mean(axis=2), groups.present)
    if estimator == "paper":
        by_layer = paper_values(tracked, decay, width)
        powers = power_on_picks(summary, n_layers, noise.power)
    else:
        by_layer, powers = deblended_values(tracked, decay, groups)
    looks = compare_with_gamma(stacked_tracked(summary)[:, :n_layers])
    speckle = range_correlation(summary)
    varies, missing = radiometry(summary, groups, powers, decay, by_layer, looks.n_looks)
    thickness, counts = thickness_statistics(
        summary, n_layers, estimator=estimator, zone_edge_bins=zone_edge_bins
    )

    variables = {
        "noise_power": ((), noise.power),
        "noise_power_standard_error": ((), noise.standard_error),
    }
    for name, values in by_layer.items():
        variables[name] = ("layer", "lag")[: values.ndim], values
    variables |= thickness | _widths(width) | varies
    variables |= {
        "n_picks": ("layer", tracked.n_picks),
        "n_groups": ("layer", groups.present.sum(axis=0)),
        "tracked_power_quantile": ("probability", looks.tracked_quantile),
        "gamma_quantile": ("probability", looks.gamma_quantile),
        "speckle_correlation": ("speckle_lag", speckle.correlation),
        "speckle_correlation_standard_error": ("speckle_lag", speckle.standard_error),
    }
    variables |= _spectra(summary)
    coords = {
        "wavenumber": np.fft.rfftfreq(BLOCK_LINES),
        "lag": LAGS,
        "fall": np.array(LAW_FALLS),
        "speckle_lag": np.arange(speckle.correlation.size),
        "probability": looks.probability,
        "width_edge_bins": ("width_edge", WIDTH_EDGES),
    }
    attrs = {
        "estimator": estimator,
        "bin_size_s": summary[0].bin_size_s,
        "line_spacing_m": float(np.median([frame.line_spacing_m for frame in summary])),
        "n_looks": float(rounded(looks.n_looks, SHARED_BITS)),
        "n_looks_standard_error": float(rounded(looks.standard_error, ERROR_BITS)),
        "noise_looks": float(rounded(noise.looks, SHARED_BITS)),
        "speckle_correlation_source": speckle.source,
        "radiometry_missing": ", ".join(missing),
        "n_frames": len(summary),
        "n_range_lines": sum(frame.surface_bins.size for frame in summary),
        "n_layers_seen": n_seen,
        **counts,
        "n_picks_outside": sum(frame.n_outside for frame in summary),
        "n_frames_without_surface": sum(
            not np.isfinite(frame.depth_bins).any() for frame in summary
        ),
    }
    return _with_units(_on_shared_digits(xr.Dataset(variables, coords, attrs)))


@dataclass(frozen=True)
class Noise:
    """Noise power, its standard error from the scatter of groups, and the looks of the air."""

    power: float
    standard_error: float
    looks: float


def _noise(summary):
    """`Noise` of the air in all groups that have any; first of all, groups need a surface."""
    n_surface = is_present(stacked(summary, "n_picks"))[:, :1].sum()
    what = f"groups of {GROUP_LINES} range lines with the surface picked in {len(summary)} frames"
    check_count(what, n_surface, MINIMUM_GROUPS)
    held = stacked(summary, "air_count") > 0
    n_groups = held.sum()
    check_count(
        f"noise: averaged lines with air {AIR_MARGIN_BINS} range bins above the surface", n_groups
    )
    count = stacked(summary, "air_count")[held]
    total = stacked(summary, "air_sum")[held]
    mean = total.sum() / count.sum()
    error = mean / np.sqrt(count.sum())
    if n_groups > 1:
        residual = total - mean * count
        error = np.sqrt((residual**2).sum() * n_groups / (n_groups - 1)) / count.sum()
    # Within groups, so that drifting gain does not count as speckle.
    square = stacked(summary, "air_square")[held] / count
    variance = (square - (total / count) ** 2).mean()
    return Noise(mean, error, mean**2 / max(variance, mean**2 / MOST_LOOKS))


def _groups(summary, noise_power):
    """Averaged lines with the layers seen often enough, and how many layers were seen at all."""
    n_picks = stacked(summary, "n_picks")
    present = is_present(n_picks)
    n_groups = present.sum(axis=0)
    enough = n_groups >= MINIMUM_GROUPS
    n_layers = int(np.flatnonzero(enough)[-1]) + 1
    groups = Groups(
        stacked(summary, "power"),
        stacked(summary, "position")[:, :n_layers],
        stacked(summary, "spread")[:, :n_layers],
        present[:, :n_layers],
        noise_power,
    )
    return groups, int((n_picks > 0).any(axis=0).sum())


def _widths(width):
    """Histogram of measured widths, and bounds of the uniform law of their mean and variance."""
    values = np.sort(width[np.isfinite(width)])
    check_count("averaged layers whose power falls to 1/e before the next", values.size)
    # NaN lies in no class.
    counts = [np.histogram(column, bins=WIDTH_EDGES)[0] for column in width.T]
    mean = values.mean()
    half = np.sqrt(3) * values.std()
    bounds = np.array([max(mean - half, values[0]), min(mean + half, values[-1])])
    # Of mean -+ sqrt(3) s: variances s^2 / n and, for a uniform law of kurtosis 1.8, 3 s^2 0.8 / 4
    # n.
    error = values.std() * np.sqrt(1.6 / values.size)
    return {
        "width_bound_bins": ("bound", bounds),
        "width_bound_bins_standard_error": ("bound", np.full(2, error)),
        "width_histogram": (("layer", "width_bin"), np.array(counts, dtype=np.int64)),
    }


def _spectra(summary):
    first, mean = detected_power_spectra(summary)
    spectra = {}
    if first is not None:
        spectra["detected_power_spectrum_layer_1"] = "wavenumber", first
    if mean is not None:
        spectra["detected_power_spectrum_layer_mean"] = "wavenumber", mean
    return spectra


def _on_shared_digits(dataset):
    """The dataset with its variables rounded by `_shared`."""
    for name, variable in dataset.data_vars.items():
        if variable.dtype.kind == "f":
            n_bits = ERROR_BITS if name.endswith("_standard_error") else SHARED_BITS
            variable.values = _shared(variable.values, n_bits)
    return dataset


def _shared(values, n_bits):
    """Values to digits that processors share; what is rounding beside the largest is zero."""
    magnitude = np.abs(np.asarray(values))
    known = magnitude[np.isfinite(magnitude)]
    is_rounding = magnitude < LEAST_SHARE * known.max(initial=0.0)
    return np.where(is_rounding, 0.0, rounded(values, n_bits))


def _with_units(dataset):
    """Units by the ending of the name, and 1."""
    for name, variable in dataset.variables.items():
        of = str(name).removesuffix("_standard_error")
        endings = [ending for ending in UNITS if of.endswith(ending)]
        variable.attrs["units"] = UNITS[endings[0]] if endings else "1"
    for name in LINEAR_POWER:
        if name in dataset:
            dataset[name].attrs["units"] = "linear power"
    return dataset
