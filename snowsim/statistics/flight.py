"""Statistics of a flight by either estimator, from its frames or from their merged summary."""

import warnings
from collections.abc import Iterable

import numpy as np
import xarray as xr

from snowsim.alignment import FAR_BINS, surface_away_bins
from snowsim.constants import BLOCK_LINES, STATISTICS_CONTENT
from snowsim.echogram import check_choice
from snowsim.limits import check_count
from snowsim.progress import with_progress
from snowsim.seeding import rounded
from snowsim.statistics.deblend import WAVEFORM_LAGS, deblended_waveform
from snowsim.statistics.groups import Groups
from snowsim.statistics.paper import measure_groups, paper_waveform, thickness_spectra
from snowsim.statistics.radiometry import LAW_FALLS, radiometry
from snowsim.statistics.relief import relief_by_zone, surface_statistics
from snowsim.statistics.speckle import QUANTILES, looks
from snowsim.statistics.summaries import (
    AIR_MARGIN_BINS,
    GROUP_LINES,
    MINIMUM_BLOCKS,
    in_stretches,
    known_mean,
    merge,
    summarise,
)
from snowsim.statistics.thickness import blocks_in_zones, thickness_statistics

ESTIMATORS = ("deblended", "paper")
# Binary digits of statistics that are kept, a relative error of 1.5e-5. Processors agree on these:
# sums and fits differ by at most 1e-11 between them.
SHARED_BITS = 16
LEAST_SHARE = 2.0**-40  # values below this share of a variable's largest are rounding
MINIMUM_GROUPS = 5  # averaged lines a layer must be in to be reported
UNITS = {
    "_bins": "range bin",
    "_bins2": "range bin^2",
    "_rate": "1/range bin",
    "_psd": "range bin^2 line/cycle",
    "_db": "dB",
    "_lines": "range line",
    "_m": "m",
    "_power": "linear power",
    "_waveform": "linear power",
}  # by the ending of the name


def fit(
    frames: Iterable[tuple[xr.Dataset, xr.Dataset]], *, estimator: str = "deblended"
) -> xr.Dataset:
    """Statistics of a flight.

    Frames are read one at a time, in any order; each leaves a summary of about 0.4 kB per range
    line. Warns of each statistic that stands on too little of a flight, and says on how much, and
    where layer 0 lies far from the echogram's `Surface`: its power then counts as the surface's.

    Parameters
    ----------
    frames : iterable of (xarray.Dataset, xarray.Dataset)
        Echogram and layers of each frame (Open Polar Radar convention), one bin size throughout.
    estimator : {"deblended", "paper"}
        `deblended` solves for overlapping layers and noise jointly; `paper` is Yari et al. (2021)
        as printed.

    Returns
    -------
    xarray.Dataset
        See `estimate`.

    Raises
    ------
    ValueError
        If there is no frame, bin sizes differ, a dataset breaks the convention, or `estimate`
        refuses the flight.

    Examples
    --------
    Two simulated frames:

    >>> from snowsim import Climate, simulate
    >>> snow = Climate(accumulation_m=0.4)
    >>> frames = (simulate(snow, "snow-2012", n_range_lines=512, rng=i) for i in range(2))
    >>> statistics = fit(frames, estimator="paper")
    >>> statistics["thickness_mean_bins"].dims
    ('zone', 'slab')
    >>> statistics.attrs["n_frames"]
    2
    >>> bool(statistics["peak_power"][0] > statistics["peak_power"][1])
    True
    """
    summaries = []
    away_bins = []
    for number, (echogram, layers) in enumerate(with_progress(frames, unit="frame")):
        summaries.append(summarise(echogram, layers, where=f"frame {number}"))
        away_bins.append(surface_away_bins(echogram, layers))
    summary = merge(summaries)
    far_bins = [bins for bins in away_bins if bins > FAR_BINS]
    if far_bins:
        msg = (
            f"layer 0 lies {np.median(far_bins):.0f} range bins from the echogram's Surface in "
            f"{len(far_bins)} of {len(away_bins)} frames: is it the snow surface?"
        )
        warnings.warn(msg, UserWarning, stacklevel=2)
    statistics = estimate(summary, estimator=estimator)
    warn_of_little(statistics)
    return statistics


def warn_of_little(statistics):
    """Warn of each statistic that stands on too little of a flight."""
    attrs = statistics.attrs
    n_placed = attrs["n_blocks"] - attrs["n_blocks_not_placed"]
    stands_on = f"{attrs['n_frames']} frames and {n_placed} blocks with layers"
    for name in filter(None, attrs["radiometry_missing"].split(", ")):
        msg = f"{name} is held constant: {stands_on} are too few for it"
        warnings.warn(msg, UserWarning, stacklevel=3)
    n_zones = statistics.sizes["zone"]
    n_needed = n_zones * MINIMUM_BLOCKS
    if n_placed < n_needed:
        msg = f"thickness of {n_zones} zones stands on {n_placed} blocks, {n_needed} are needed"
        warnings.warn(msg, UserWarning, stacklevel=3)


def estimate(summary, *, estimator="deblended", zone_edge_bins=None):
    """Statistics of a flight from its merged summary.

    Parameters
    ----------
    summary : xarray.Dataset
        A summary as from `merge`.
    estimator : {"deblended", "paper"}
    zone_edge_bins : array_like, (edge,), optional
        Zones to use instead of the flight's own quartiles, to compare two flights zone by zone.

    Returns
    -------
    xarray.Dataset
        `noise_power`; of the waveform `peak_power`, `decay_rate`, `width_bins`, `variance_bins2`,
        `offset_bins` of its peak below the pick, `n_picks` and `substituted (layer)`; of
        `deblended` alone `mean_waveform (layer, lag)`; of thickness and of the surface's row what
        `thickness_by_zone` returns; how power varies, see `radiometry`; tracked
        power against Gamma(M), autocorrelation of speckle down range and along-track spectra of
        power, see `looks`.

    Raises
    ------
    ValueError
        If the estimator is unknown, there is no air above the surface, no layer, or no
        block has slab 0 picked in half of its lines.

    Notes
    -----
    Layers are reported down to the last that is in `MINIMUM_GROUPS` averaged lines. If a layer
    yields no value of its own, `substituted` is 1, see `paper_waveform` and `deblended_waveform`.
    The power of a layer that is never picked is interpolated in dB between its neighbours'. Only
    the decay rate of the deepest layer in `paper` is NaN.
    """
    check_choice("estimator", estimator, ESTIMATORS)
    n_picks = summary["n_picks"].values
    present = 2 * n_picks >= GROUP_LINES
    n_groups = present.sum(axis=0)
    n_frames = summary.sizes["frame"]
    what = f"groups of {GROUP_LINES} range lines with the surface picked in {n_frames} frames"
    check_count(what, n_groups[0], MINIMUM_GROUPS)
    # Layers that are in enough of them.
    n_layers = np.flatnonzero(n_groups >= MINIMUM_GROUPS)[-1] + 1
    summary = summary.isel(layer=slice(n_layers))
    parts = (summary[name].values for name in ("power", "position", "spread"))
    groups = Groups(*parts, present[:, :n_layers], noise(summary))
    variables, powers = waveform(summary, groups, estimator)
    of_looks, n_looks = looks(summary)
    of_thickness, counts = thickness_by_zone(summary, estimator, zone_edge_bins)
    varies, missing = radiometry(summary, groups, powers, variables, n_looks)
    variables |= {"noise_power": groups.noise_power} | of_looks | of_thickness | dict(varies)
    coords = {"lag": WAVEFORM_LAGS, "fall": np.array(LAW_FALLS), "probability": QUANTILES}
    coords["wavenumber"] = np.fft.rfftfreq(BLOCK_LINES)
    attrs = {
        "content": STATISTICS_CONTENT,
        "estimator": estimator,
        "bin_size_s": float(summary["bin_size_s"].values[0]),
        "line_spacing_m": float(np.median(summary["line_spacing_m"])),
        "n_looks": n_looks,
        "radiometry_missing": ", ".join(missing),
        "n_frames": n_frames,
        "n_range_lines": summary.sizes["range_line"],
        "n_layers_seen": int(n_picks.any(axis=0).sum()),
        "n_picks_outside": int(summary["n_outside"].sum()),
        "n_frames_without_surface": int((summary["power_sum"] == 0).sum()),
        **counts,
    }
    return _rounded(xr.Dataset(variables, coords, attrs))


def noise(summary):
    """Noise power: the mean over the air of all groups."""
    n_air = summary["air_count"].values
    what = f"noise: averaged lines with air {AIR_MARGIN_BINS} range bins above the surface"
    check_count(what, (n_air > 0).sum())
    return summary["air_sum"].values.sum() / n_air.sum()


def waveform(summary, groups, estimator):
    """Variables of the waveform by layer, and powers (group, layer)."""
    tracked = summary["tracked_power"].values.astype(float)
    tracked_power = np.nan_to_num(known_mean(tracked, axis=0))
    decay, width = measure_groups(groups)
    what = "averaged layers whose power falls to 1/e before the next"
    check_count(what, np.isfinite(width).sum())
    if estimator == "paper":
        variables = paper_waveform(tracked_power, decay, width)
        # Power on the picks less noise, with its neighbours' tails.
        n_groups = summary["n_groups"].values
        of_groups = in_stretches(summary, "tracked_power", GROUP_LINES, n_groups)
        powers = known_mean(of_groups, axis=1) - groups.noise_power
    else:
        variables, powers = deblended_waveform(groups, tracked_power, decay)
    variables["n_picks"] = "layer", np.isfinite(tracked).sum(axis=0)
    return variables, powers


def thickness_by_zone(summary, estimator, zone_edge_bins):
    """Variables of thickness and of the surface's row, and counts, two dicts.

    Variables are those of `thickness_statistics`, of `relief_by_zone` (of `thickness_spectra` by
    the estimator `paper`) and of `surface_statistics`; counts those of `blocks_in_zones` and, of
    zones whose relief is that of all together, `n_zones_of_all_relief`.
    """
    blocks = blocks_in_zones(summary, zone_edge_bins)
    variables = thickness_statistics(blocks)
    counts = blocks.counts
    if estimator == "paper":
        variables |= thickness_spectra(np.diff(blocks.depth_bins, axis=1), blocks)
    else:
        spacing_m = float(np.median(summary["line_spacing_m"]))
        n_zones = blocks.typical.size
        relief, n_of_all = relief_by_zone(blocks.depth_bins, blocks.zone, n_zones, spacing_m)
        variables |= relief
        counts = counts | {"n_zones_of_all_relief": n_of_all}
    return variables | surface_statistics(summary), counts


def _rounded(statistics):
    """Statistics with units, rounded to digits on which processors agree.

    Values that are rounding beside their variable's largest become zero.
    """
    for name, variable in statistics.variables.items():
        endings = [ending for ending in UNITS if str(name).endswith(ending)]
        variable.attrs["units"] = UNITS[endings[0]] if endings else "1"
        if name in statistics.data_vars and variable.dtype.kind == "f":
            magnitude = np.abs(variable.values)
            is_rounding = magnitude < LEAST_SHARE * np.nanmax(magnitude, initial=0.0)
            variable.values = np.where(is_rounding, 0.0, rounded(variable.values, SHARED_BITS))
    n_looks = float(rounded(statistics.attrs["n_looks"], SHARED_BITS))
    return statistics.assign_attrs(n_looks=n_looks)
