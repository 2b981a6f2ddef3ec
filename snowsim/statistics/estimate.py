"""From the merged summaries of a flight to its statistics, by either estimator."""

import numpy as np
import xarray as xr

from snowsim.echogram import check_choice
from snowsim.statistics.blocks import BAND_EDGES, BLOCK_LINES, thickness_blocks
from snowsim.statistics.by_layer import LAGS, deblended_values, paper_values
from snowsim.statistics.lines import Groups
from snowsim.statistics.paper import is_present, measure_groups, tracked_moments
from snowsim.statistics.radiometry import LAW_FALLS, power_on_picks, radiometry
from snowsim.statistics.speckle import (
    MOST_LOOKS,
    compare_with_gamma,
    detected_power_spectra,
    range_correlation,
)
from snowsim.statistics.summaries import AIR_MARGIN_BINS, stacked, stacked_tracked
from snowsim.statistics.surface import surface_statistics
from snowsim.statistics.zones import MINIMUM_BLOCKS, as_variables, zone_statistics

ESTIMATORS = ("deblended", "paper")
MINIMUM_GROUPS = 5  # averaged lines a layer must be in to be reported
WIDTH_EDGES = np.arange(0, 40.5, 0.5)


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
        `relative_thickness_mean`, `relative_thickness_variance (zone, slab)`, `thickness_psd (zone,
        slab, wavenumber)`, `n_samples (zone, slab)`. Beside them: counts (`n_picks`, `n_groups
        (layer)`, `n_gap_blocks (slab)`, `n_psd_samples (zone, slab)`), rules applied (`substituted
        (layer)`, `source`, `psd_source (zone, slab)`), `offset_bins (layer)` of the waveform's peak
        below the pick, the width histogram, correlations between slabs, mean waveforms, tracked
        power against Gamma(M), autocorrelation of speckle down range (`speckle_correlation
        (speckle_lag)`, by range bins from 0, and the attribute `speckle_correlation_source`, see
        `range_correlation`), along-track spectra of power, and how power, noise and decay vary, see
        `radiometry`.

    Raises
    ------
    ValueError
        If the estimator is unknown, there is no air above the surface, no layer, or what
        `zone_statistics` refuses.

    Notes
    -----
    Layers are reported down to the last that is in `MINIMUM_GROUPS` averaged lines. If a layer yields no value of its
    own, `substituted` is 1: `paper` takes decay rate or width from the layer above; `deblended` replaces a power below
    two standard errors by tracked power above noise, times the share that deblending leaves of the other layers.
    The power of a layer that is never picked is interpolated in dB between its neighbours'.
    Only the decay rate of the deepest layer in `paper` is NaN.
    """
    check_choice("estimator", estimator, ESTIMATORS)
    if not any(np.isfinite(frame.depth_bins).any() for frame in summary):
        msg = f"a flight needs layers, none of its {len(summary)} frames has the surface picked"
        raise ValueError(msg)
    noise_power, noise_error, noise_looks = _noise(summary)
    groups, n_seen = _groups(summary, noise_power)
    n_layers = groups.present.shape[1]
    tracked = tracked_moments(summary, n_layers)
    decay, width = measure_groups(groups.power, groups.position.mean(axis=2), groups.present)
    if estimator == "paper":
        layer_values = paper_values(tracked, decay, width)
        powers = power_on_picks(summary, n_layers, noise_power)
    else:
        layer_values, powers = deblended_values(tracked, decay, groups)
    looks = compare_with_gamma(stacked_tracked(summary)[:, :n_layers])
    speckle = range_correlation(summary)
    varies, missing = radiometry(summary, groups, powers, decay, layer_values, looks.n_looks)
    tapered = estimator != "paper"
    zones = zone_statistics(thickness_blocks(summary, n_layers), zone_edge_bins, tapered=tapered)
    dataset = xr.Dataset(
        {"noise_power": ((), noise_power), "noise_power_standard_error": ((), noise_error)}
        | {
            name: (("layer", "lag")[: np.ndim(value)], value)
            for name, value in layer_values.items()
        }
        | as_variables(zones)
        | surface_statistics(summary, MINIMUM_BLOCKS)
        | _widths(width)
        | varies
        | {"n_picks": ("layer", tracked.n_picks), "n_groups": ("layer", groups.present.sum(axis=0))}
        | {
            "tracked_power_quantile": ("probability", looks.tracked_quantile),
            "gamma_quantile": ("probability", looks.gamma_quantile),
        }
        | {"speckle_correlation": ("speckle_lag", speckle.correlation)}
        | {"speckle_correlation_standard_error": ("speckle_lag", speckle.standard_error)}
        | _spectra(summary),
        coords={
            "wavenumber": np.fft.rfftfreq(BLOCK_LINES),
            "lag": LAGS,
            "fall": np.array(LAW_FALLS),
            "speckle_lag": np.arange(speckle.correlation.size),
            "band_edge_wavenumber": ("band_edge", BAND_EDGES / BLOCK_LINES),
            "probability": looks.probability,
            "width_edge_bins": ("width_edge", WIDTH_EDGES),
        },
        attrs={
            "estimator": estimator,
            "bin_size_s": summary[0].bin_size_s,
            "line_spacing_m": float(np.median([frame.line_spacing_m for frame in summary])),
            "n_looks": float(looks.n_looks),
            "n_looks_standard_error": float(looks.standard_error),
            "noise_looks": float(noise_looks),
            "speckle_correlation_source": speckle.source,
            "radiometry_missing": ", ".join(missing),
            "n_frames": len(summary),
            "n_range_lines": sum(frame.depth_bins.shape[1] for frame in summary),
            "n_layers_seen": n_seen,
            **{name: value for name, value in zones.items() if not np.ndim(value)},
            "n_picks_outside": sum(frame.n_outside for frame in summary),
            "n_frames_without_surface": sum(
                not np.isfinite(frame.depth_bins).any() for frame in summary
            ),
        },
    )
    return _with_units(dataset)


def _noise(summary):
    """Noise power, its standard error from the scatter of groups, and the looks of the air."""
    total, square, count = (
        stacked(summary, name) for name in ("air_sum", "air_square", "air_count")
    )
    held = count > 0
    if not held.any():
        msg = f"noise needs air more than {AIR_MARGIN_BINS} range bins above the surface, no range line has it"
        raise ValueError(msg)
    mean = total.sum() / count.sum()
    if held.sum() > 1:
        residual = total[held] - mean * count[held]
        error = np.sqrt((residual**2).sum() * held.sum() / (held.sum() - 1)) / count.sum()
    else:
        error = mean / np.sqrt(count.sum())
    # Within groups, so that drifting gain does not count as speckle.
    variance = (square[held] / count[held] - (total[held] / count[held]) ** 2).mean()
    return mean, error, mean**2 / max(variance, mean**2 / MOST_LOOKS)


def _groups(summary, noise_power):
    """Averaged lines with the layers seen often enough, and how many layers were seen at all."""
    n_picks = stacked(summary, "n_picks")
    present = is_present(n_picks)
    enough = present.sum(axis=0) >= MINIMUM_GROUPS
    n_layers = int(np.flatnonzero(enough)[-1]) + 1 if enough.any() else 0
    if n_layers == 0 or not enough[0]:
        n = int(present[:, 0].sum()) if present.shape[1] else 0
        msg = f"a flight needs the surface picked in {MINIMUM_GROUPS} groups of 20 range lines, got {n}"
        raise ValueError(msg)
    position, spread = (stacked(summary, name)[:, :n_layers] for name in ("position", "spread"))
    groups = Groups(stacked(summary, "power"), position, spread, present[:, :n_layers], noise_power)
    return groups, int((n_picks > 0).any(axis=0).sum())


def _widths(width):
    """Histogram of measured widths and the bounds of the uniform law with their mean and variance."""
    values = np.sort(width[np.isfinite(width)])
    if values.size == 0:
        msg = "width bounds need a layer whose power falls to 1/e before the next, no averaged line has one"
        raise ValueError(msg)
    counts = np.array(
        [np.histogram(column[np.isfinite(column)], bins=WIDTH_EDGES)[0] for column in width.T],
        dtype=np.int64,
    )
    mean, half = values.mean(), np.sqrt(3) * values.std()
    # Of mean -+ sqrt(3) s: variances s^2 / n and, for a uniform law of kurtosis 1.8, 3 s^2 0.8 / 4
    # n.
    error = values.std() * np.sqrt(1.6 / values.size)
    return {
        "width_bound_bins": (
            "bound",
            np.array([max(mean - half, values[0]), min(mean + half, values[-1])]),
        ),
        "width_bound_bins_standard_error": ("bound", np.full(2, error)),
        "width_histogram": (("layer", "width_bin"), counts),
    }


def _spectra(summary):
    first, mean = detected_power_spectra(summary)
    spectra = {"detected_power_spectrum_layer_1": first, "detected_power_spectrum_layer_mean": mean}
    return {name: ("wavenumber", value) for name, value in spectra.items() if value is not None}


def _with_units(dataset):
    """Units by the ending of the name."""
    units = {
        "_bins": "range bin",
        "_bins2": "range bin^2",
        "_rate": "1/range bin",
        "_psd": "range bin^2 line/cycle",
    }
    units |= {"_db": "dB", "_db2": "dB^2", "_lines": "range line"}
    for name, variable in dataset.variables.items():
        ending = next(
            (e for e in units if str(name).removesuffix("_standard_error").endswith(e)), None
        )
        variable.attrs["units"] = units.get(ending, "1")
    for name in (
        "peak_power",
        "noise_power",
        "background_power",
        "mean_waveform",
        "model_waveform",
        "layer_waveform",
    ):
        if name in dataset:
            dataset[name].attrs["units"] = "linear power"
    return dataset
