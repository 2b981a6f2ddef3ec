"""Summaries of frames, from which statistics are estimated: picks, their power, means and air.

The summary of a frame is a dataset of about 0.4 kB per range line. Those of a flight are merged in
any order.
"""

import warnings

import numpy as np
import pandas as pd
import xarray as xr

from snowsim.alignment import along_track_m, bin_size_s, data_of, layer_bins_of
from snowsim.constants import BLOCK_LINES
from snowsim.echogram import check_echogram, check_layers
from snowsim.limits import BIN_S_LIMITS, check_content, check_count, check_values

# Least number of blocks that give a change over a lag, or the mean of a slab. With fewer, the
# standard error of a variance is as large as the variance, and a zone is pooled with the others.
MINIMUM_BLOCKS = 4
GROUP_LINES = 20  # lines averaged incoherently, Yari et al. (2021), section III
FIRST_ROW = -40  # averaged lines begin here, in bins from the surface
# Parts of a group's picks of a layer, sorted by depth: the rows that a sloping layer covers.
PARTS = 2
# Bins above the surface that still hold its rise: 8 standard deviations at a variance of 15.
AIR_MARGIN_BINS = 30
# Number of lags of products down range, from 0. The last lie beyond the range response and give the
# part that whole lines share.
AIR_LAGS = 13
ROWS_BELOW = 60  # averaged lines end here below the frame's deepest pick
MOST_ZEROS = 0.005  # share of pixels within range lines that may be 0 without a warning
SAME_BIN_SIZE = 1e-4  # a tenth of a bin over 1000 bins
SAME_LINE_SPACING = 1.1  # ratio of spacings from which on a warning is given
OVERLOADED = 6.0  # a line is overloaded if its gain is this many robust deviations off
CONTENT = "snowsim flight summary 6"


def summarise(echogram, layers, where="frame"):
    """Summary of one frame, a dataset for `merge`.

    Lines are averaged in groups of 20, each shifted by the whole bin of its surface; the sub-bin
    remainder, a variance of up to 1/12 bins^2, stays in the positions.

    Parameters
    ----------
    echogram, layers : xarray.Dataset
        Open Polar Radar convention; layer 0 is the snow surface. Picks outside the record become
        gaps and are counted; a frame without a surface pick adds nothing; up to 19 range lines at
        its end belong to no group; data that are exactly zero are padding, not air, and a range
        line of nothing else is missing.
    where : str, optional
        How errors name the frame.

    Returns
    -------
    xarray.Dataset
        By `frame`: `start_ns` (UTC of the first line), `bin_size_s`, `line_spacing_m`, `n_lines`,
        `n_groups`, `n_outside`, and `power_sum` of the picks. By `range_line`, NaN in gaps:
        `depth_bins (layer)` below the surface, which is bridged linearly in its gaps but not in its
        own row; `tracked_power (layer)` in the bin of each pick; `surface_bins`. By `group`:
        averaged `power (row)` from `FIRST_ROW` below the surface, NaN outside the record; `position
        (layer, part)` and `spread`, mean row and its variance by halves of the picks in order of
        depth; `n_picks (layer)`; of power in the air `air_sum`, `air_count` and `gain_variance`, of
        the gain from line to line [nepers^2]. By `frame` and `air_lag`, `air_products` and
        `air_pairs` of the air, see `_air`.

    Raises
    ------
    ValueError
        If a dataset breaks the convention or no two range lines have a position.
    """
    check_echogram(echogram, where)
    check_layers(layers, where)
    power = np.ascontiguousarray(data_of(echogram).T)
    n_lines, n_bins = power.shape
    empty = (power == 0).all(axis=1)
    power = np.where(empty[:, None], np.nan, power)
    _warn_of_zeros(power, where)
    check_values(f"{where}: range bin of twtt [s]", bin_size_s(echogram), *BIN_S_LIMITS)
    layer_bins = layer_bins_of(layers, echogram)
    inside = (layer_bins > -0.5) & (layer_bins < n_bins - 0.5) & ~empty
    n_outside = (np.isfinite(layer_bins) & ~inside).sum()
    layer_bins = np.where(inside, layer_bins, np.nan)
    surface = pd.Series(layer_bins[0]).interpolate(limit_direction="both").to_numpy()
    # Without a surface pick, it is NaN throughout.
    layer_bins = np.where(np.isfinite(surface), layer_bins, np.nan)
    surface_row = np.rint(np.nan_to_num(surface)).astype(np.int64)
    n_groups = n_lines // GROUP_LINES * np.isfinite(surface).any()
    rows = np.rint(np.nan_to_num(layer_bins)).astype(int)
    tracked = np.where(np.isfinite(layer_bins), power[np.arange(n_lines), rows], np.nan)
    spacing_m = np.diff(along_track_m(echogram))
    what = f"{where}: neighbouring range lines with Latitude and Longitude"
    check_count(what, np.isfinite(spacing_m).sum())
    of_frame = {
        "start_ns": echogram["slow_time"].values[0].astype("datetime64[ns]").astype(np.int64),
        "bin_size_s": bin_size_s(echogram),
        "line_spacing_m": np.nanmedian(spacing_m),
        "n_lines": n_lines,
        "n_groups": n_groups,
        "n_outside": n_outside,
        "power_sum": np.nansum(tracked, dtype=float),
    }
    of_lines = {
        "depth_bins": (("layer", "range_line"), layer_bins - surface),
        "tracked_power": (("layer", "range_line"), tracked),
        "surface_bins": ("range_line", layer_bins[0]),
    }
    summary = xr.Dataset(of_lines).astype(np.float32).transpose("range_line", ...)
    summary = summary.assign(xr.Dataset(of_frame).expand_dims("frame"))
    summary = summary.assign(_averaged(power, layer_bins - surface_row, surface_row, n_groups))
    summary = summary.assign(_air(power, surface_row - AIR_MARGIN_BINS, n_groups))
    return summary.assign_attrs(content=CONTENT)


def _warn_of_zeros(power, where):
    """Warn if power (range_line, range_bin) is 0 within range lines more often than noise is."""
    held = power != 0
    inside = np.logical_or.accumulate(held, axis=1)
    inside &= np.logical_or.accumulate(held[:, ::-1], axis=1)[:, ::-1]
    share = 1 - held.sum() / max(inside.sum(), 1)
    if share > MOST_ZEROS:
        msg = (
            f"{where}: Data is 0 on {100 * share:.1f} % of the pixels within range lines, as where "
            "noise was subtracted or values were rounded: number of looks and power over noise of "
            "these statistics are then wrong"
        )
        warnings.warn(msg, stacklevel=3)


def _averaged(power, rows, surface_row, n_groups):
    """Variables of averaged lines, and of the rows of layers in them."""
    n_rows = int(np.ceil(np.nanmax(rows, initial=0))) + ROWS_BELOW - FIRST_ROW + 1
    n_lines = n_groups * GROUP_LINES
    lines = rows_from(power[:n_lines], surface_row[:n_lines] + FIRST_ROW, n_rows)
    lines = lines.reshape(n_groups, GROUP_LINES, n_rows)
    # A row that only some lines of a group reach would mix depths of different noise and fading.
    often = 2 * np.isfinite(lines).sum(axis=1) >= GROUP_LINES
    averaged = np.where(often, known_mean(lines.astype(float), axis=1), np.nan)
    # Rows of each group and layer, sorted by depth with NaN last, to be split into parts.
    rows = np.sort(rows[:, :n_lines].reshape(len(rows), n_groups, GROUP_LINES).swapaxes(0, 1))
    n_picks = np.isfinite(rows).sum(axis=2)
    part = np.arange(GROUP_LINES) * PARTS // np.maximum(n_picks, 1)[:, :, None]
    held = part[:, :, None] == np.arange(PARTS)[:, None]
    in_parts = np.where(held, rows[:, :, None], np.nan)
    position = known_mean(in_parts, axis=3)
    spread = np.maximum(known_mean(in_parts**2, axis=3) - position**2, 0)
    return {
        "power": (("group", "row"), averaged.astype(np.float32)),
        "position": (("group", "layer", "part"), position.astype(np.float32)),
        "spread": (("group", "layer", "part"), spread.astype(np.float32)),
        "n_picks": (("group", "layer"), n_picks),
    }


def rows_from(power, first, n_rows):
    """Rows of power (line, row) from `first` (line,) down, (line, n_rows), NaN outside it."""
    row = first[:, None] + np.arange(n_rows)
    inside = (row >= 0) & (row < power.shape[1])
    return np.where(inside, np.take_along_axis(power, np.where(inside, row, 0), axis=1), np.nan)


def _air(power, air_end, n_groups):
    """Variables of the air above the bin `air_end (range_line,)`, of whole groups.

    These are the sum and number of bins, the variance of gain and, for each lag, the sum and number
    of products of bins that far apart. Before that, power is divided by the mean of its line, which
    removes gain and overloaded lines, and the mean of its row is subtracted, which removes bands of
    coherent noise. Both change a product by the same amount at every lag.
    """
    air_end = np.maximum(air_end[: n_groups * GROUP_LINES], 0)
    n_bins = air_end.max(initial=0)
    air = power[: air_end.size, :n_bins].astype(float)
    held = (air > 0) & (np.arange(n_bins) < air_end[:, None])
    air = np.where(held, air, np.nan)
    relative = air / known_mean(air, axis=1)[:, None]
    relative = np.nan_to_num(relative - known_mean(relative, axis=0))
    air = air.reshape(n_groups, GROUP_LINES, n_bins)
    gains = map(_gain_variance, air, air_end.reshape(n_groups, GROUP_LINES).min(axis=1))
    return {
        "air_sum": ("group", np.nansum(air, axis=(1, 2))),
        "air_count": ("group", np.isfinite(air).sum(axis=(1, 2))),
        "air_products": (("frame", "air_lag"), [_products(relative)]),
        "air_pairs": (("frame", "air_lag"), [_products(held.astype(np.int64))]),
        "gain_variance": ("group", np.array(list(gains), dtype=float)),
    }


def _gain_variance(air, n_bins):
    """Variance of the gain from line to line of a group [nepers^2], from its air (line, bin).

    It is the covariance of the logarithms of mean power in the upper and the lower half of the air.
    Lines far from the median are left out; NaN if half of the lines are, or if one is missing or
    padding.
    """
    halves = air[:, : n_bins // 2], air[:, n_bins // 2 : n_bins]
    logarithm = np.log([known_mean(half, axis=1) for half in halves])
    both = logarithm.mean(axis=0) - np.median(logarithm)
    # 1.4826 is the standard deviation of a normal law over its median absolute deviation.
    near = np.abs(both) <= OVERLOADED * 1.4826 * np.median(np.abs(both))
    return np.cov(logarithm[:, near])[0, 1] if 2 * near.sum() > near.size else np.nan


def _products(values):
    """Sums of products of values (range_line, range_bin) that lie each lag apart, (air_lag,)."""
    by_lag = []
    for lag in range(AIR_LAGS):
        lower = values[:, lag:]
        by_lag.append(np.einsum("ij,ij->", values[:, : lower.shape[1]], lower))
    return by_lag


def merge(summaries):
    """One summary of the frames in all summaries, merged ones too, sorted by time.

    Layers and rows that a frame lacks are NaN. ValueError if there is no frame, one is there twice,
    their bin sizes differ, or a summary is one of an earlier version.
    """
    summaries = list(summaries)
    check_count("frames of a flight", len(summaries))
    for summary in summaries:
        check_content(summary, CONTENT, "summarise its frames again", "summary of a flight")
    sizes = {dim: max(summary.sizes[dim] for summary in summaries) for dim in ("layer", "row")}
    variables = {}
    for name, first in summaries[0].data_vars.items():
        fill = np.nan if first.dtype.kind == "f" else 0
        parts = []
        for variable in (summary[name] for summary in summaries):
            lacking = [(0, sizes.get(dim, n) - n) for dim, n in variable.sizes.items()]
            parts.append(np.pad(variable.values, lacking, constant_values=fill))
        variables[name] = first.dims, np.concatenate(parts)
    merged = xr.Dataset(variables, attrs=summaries[0].attrs)
    # By content where frames share a time.
    order = np.lexsort([merged[name] for name in ("power_sum", "n_lines", "start_ns")])
    index = {"frame": order}
    for dim, n in (("range_line", "n_lines"), ("group", "n_groups")):
        place = np.repeat(np.argsort(order), merged[n])
        index[dim] = np.argsort(place, kind="stable")
    merged = merged.isel(index)
    _refuse_copies(merged)
    bin_s = merged["bin_size_s"].values
    others = np.flatnonzero(np.abs(bin_s - bin_s[0]) > SAME_BIN_SIZE * bin_s[0])
    if others.size:
        time = np.datetime64(int(merged["start_ns"][others[0]]), "ns")
        msg = (
            f"frames of a flight must share one bin size, got {bin_s[0]:g} s and, at {time}, "
            f"{bin_s[others[0]]:g} s"
        )
        raise ValueError(msg)
    spacing_m = merged["line_spacing_m"].values
    least_m, most_m = np.nanmin(spacing_m), np.nanmax(spacing_m)
    if most_m > SAME_LINE_SPACING * least_m:
        warnings.warn(
            f"lines of frames lie {least_m:.3g} to {most_m:.3g} m apart: statistics along track, "
            "such as the relief of layers, mix these spacings",
            stacklevel=2,
        )
    return merged


def _refuse_copies(merged):
    """Raise ValueError if two frames, in order of time, have one time, length and sum of power."""
    alike = [np.diff(merged[name]) == 0 for name in ("start_ns", "n_lines", "power_sum")]
    copies = np.flatnonzero(np.all(alike, axis=0) & (merged["power_sum"].values[1:] > 0))
    if copies.size:
        time = np.datetime64(int(merged["start_ns"][copies[0]]), "ns")
        msg = (
            f"frames of a flight must differ, got {copies.size} that are there twice: one of "
            f"{time} with the same power"
        )
        raise ValueError(msg)


def numbered(of_frame):
    """Numbers of things within their frame, from 0; `of_frame` (frame,) counts them."""
    return np.concatenate(list(map(np.arange, of_frame)))


def in_stretches(summary, name, n_lines, n_whole):
    """A variable of range lines, cut into stretches, float64 (stretch, range_line, ...).

    Each has `n_lines` range lines; each frame has `n_whole` (frame,) of them.
    """
    of_frame = summary["n_lines"].values
    within = numbered(of_frame) < np.repeat(n_whole * n_lines, of_frame)
    values = summary[name].values[within].astype(float)
    return values.reshape(-1, n_lines, *values.shape[1:])


def in_blocks(summary, name):
    """A variable of range lines in the whole blocks of all frames, (block, range_line, ...)."""
    return in_stretches(summary, name, BLOCK_LINES, summary["n_lines"].values // BLOCK_LINES)


def known_mean(values, axis=None):
    """Mean of the values that are finite, NaN if none is."""
    known = np.isfinite(values)
    n = known.sum(axis=axis)
    total = np.where(known, values, 0).sum(axis=axis)
    return np.where(n > 0, total / np.maximum(n, 1), np.nan)
