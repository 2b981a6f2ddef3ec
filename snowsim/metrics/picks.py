"""Errors of picks against true layers, and sums of these errors by layer.

Sums can be pooled over many scenes, for example by training set, accumulation zone or depth.
"""

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

from snowsim.compiling import compiled
from snowsim.constants import KOVACS_M3_KG, SPEED_OF_LIGHT_M_S
from snowsim.echogram import check_layer_bins

ZONES = ("none", "shallow", "medium", "high", "very high")  # names of zones -1, 0, 1, 2, 3
SUMS = (
    "n_true",
    "n_found",
    "error",
    "absolute_error",
    "n_within",
    "n_thickness",
    "thickness_error",
    "thickness_absolute_error",
    "n_picks",
    "n_layers",
    "n_missed_layers",
    "n_false_layers",
)


def match_picks(
    picks: ArrayLike, layer_bins: ArrayLike, *, max_distance_bins: float = 10.0
) -> tuple[NDArray[np.floating], NDArray[np.bool_]]:
    """Errors of picks, and a mask of the picks that belong to a true layer.

    `picks` and `layer_bins` are (layer, range_line) in range bins. Picks are assigned to layers
    line by line, and neither changes its order. Dynamic programming finds the assignment with the
    smallest sum of distances; a layer without a pick counts as a distance of `max_distance_bins`.

    The errors are pick less truth [range bins], in the shape of `layer_bins`, NaN where a layer is
    absent or has no pick. The mask is bool in the shape of `picks`. ValueError if picks cross, or
    if numbers of range lines differ.
    """
    picks = np.asarray(picks, dtype=float)
    layer_bins = np.asarray(layer_bins, dtype=float)
    check_layer_bins(picks, "picks")
    if picks.shape[1] != layer_bins.shape[1]:
        msg = f"picks cover {picks.shape[1]} range lines, the layers {layer_bins.shape[1]}"
        raise ValueError(msg)
    error_bins = np.full(layer_bins.shape, np.nan)
    used = np.zeros(picks.shape, dtype=bool)
    for line in range(layer_bins.shape[1]):
        layer = np.flatnonzero(np.isfinite(layer_bins[:, line]))
        pick = np.flatnonzero(np.isfinite(picks[:, line]))
        assigned = _align(layer_bins[layer, line], picks[pick, line], max_distance_bins)
        layer = layer[assigned >= 0]
        pick = pick[assigned[assigned >= 0]]
        error_bins[layer, line] = picks[pick, line] - layer_bins[layer, line]
        used[pick, line] = True
    return error_bins, used


@compiled()
def _align(expected, found, max_distance):
    """Index in `found` for each entry of `expected`, or -1, by the rule of `match_picks`.

    Both arrays are one range line of bins, ascending.
    """
    n = expected.size
    m = found.size
    # A pair gains max_distance less its distance. gain[i, j] is the largest sum of gains of pairs
    # among the first i of expected and the first j of found.
    gain = np.zeros((n + 1, m + 1))
    for i in range(1, n + 1):
        for j in range(1, m + 1):
            gain[i, j] = max(gain[i - 1, j], gain[i, j - 1])
            saved = max_distance - abs(expected[i - 1] - found[j - 1])
            if saved > 0:
                gain[i, j] = max(gain[i, j], gain[i - 1, j - 1] + saved)
    assigned = np.full(n, -1)
    i, j = n, m
    while i > 0 and j > 0:
        if gain[i, j] == gain[i - 1, j]:
            i -= 1
        elif gain[i, j] == gain[i, j - 1]:
            j -= 1
        else:
            i, j = i - 1, j - 1
            assigned[i] = j
    return assigned


def layer_rows(picks, layer_bins, *, max_distance_bins=10.0, within_bins=2.0):
    """Table of sums over range lines, with a row for each true and each false layer of a scene.

    `picks` and `layer_bins` are those of `match_picks`. Layer 0 must be the surface, unless there
    is no layer. A picked layer is false if less than half of its picks belong to true layers.
    Columns are:

    - `layer`: number of the true layer, -1 for a false one;
    - `depth_bins`: its mean depth below the surface [range bins];
    - `n_true`, `n_found`: number of pixels of the true layer, and of those with a pick;
    - `error`, `absolute_error`: sums of pick less truth and of its absolute value [range bins];
    - `n_within`: number of picks with an error of at most `within_bins`;
    - `n_thickness`, `thickness_error`, `thickness_absolute_error`: count and sums of errors in the
      thickness of the slab above, on range lines where both layers that bound it have a pick;
    - `n_picks`: number of picks of a false layer;
    - `n_layers`, `n_missed_layers`, `n_false_layers`: 1 if the row is a true layer, a missed layer
      (picked on less than half of its range lines) or a false layer, else 0.
    """
    picks = np.asarray(picks, dtype=float)
    layer_bins = np.asarray(layer_bins, dtype=float)
    error_bins, used = match_picks(picks, layer_bins, max_distance_bins=max_distance_bins)
    surface_bin = np.nanmean(layer_bins[0]) if len(layer_bins) else np.nan
    thickness_error = np.diff(error_bins, axis=0, prepend=np.nan)
    rows = []
    for layer, truth in enumerate(layer_bins):
        n_true = int(np.isfinite(truth).sum())
        if n_true == 0:
            continue
        error = _finite(error_bins[layer])
        thickness = _finite(thickness_error[layer])
        row = {
            "layer": layer,
            "depth_bins": np.nanmean(truth) - surface_bin,
            "n_true": n_true,
            "n_found": error.size,
            "error": error.sum(),
            "absolute_error": np.abs(error).sum(),
            "n_within": int((np.abs(error) <= within_bins).sum()),
            "n_thickness": thickness.size,
            "thickness_error": thickness.sum(),
            "thickness_absolute_error": np.abs(thickness).sum(),
            "n_layers": 1,
            "n_missed_layers": int(2 * error.size < n_true),
        }
        rows.append(dict.fromkeys(SUMS, 0) | row)
    n_picks = np.isfinite(picks).sum(axis=1)
    for pick in np.flatnonzero(2 * used.sum(axis=1) < n_picks):
        row = {
            "layer": -1,
            "depth_bins": np.nanmean(picks[pick]) - surface_bin,
            "n_picks": int(n_picks[pick]),
            "n_false_layers": 1,
        }
        rows.append(dict.fromkeys(SUMS, 0) | row)
    return pd.DataFrame(rows, columns=["layer", "depth_bins", *SUMS])


def _finite(values):
    """Values that are not NaN or infinite."""
    return values[np.isfinite(values)]


def pool_picks(rows, by, *, bin_size_m):
    """Errors of picks for each group of rows of `layer_rows` with equal values in columns `by`.

    The table has one row for each group, in order of first appearance. Besides `by` its columns
    are:

    - `mean_absolute_error_bins` and `bias_bins` of layers, the same of thickness with the prefix
      `thickness_`, and all four in metres with the ending `_m`, where a range bin is `bin_size_m`
      of snow; NaN if nothing was found;
    - `share_within`, a share of the found pixels, and `share_found`, a share of the true pixels;
    - `n_layers`, `n_missed_layers`, `n_false_layers`, `n_true` and `n_found`.
    """
    sums = rows.groupby(by, sort=False)[list(SUMS)].sum().reset_index()
    return errors_of_sums(sums, bin_size_m)


def errors_of_sums(sums, bin_size_m):
    """Table of sums with the error columns of `pool_picks` in place of its columns `SUMS`."""
    # A count of 0 becomes NaN, so that no division warns.
    n_found = sums["n_found"].where(sums["n_found"] > 0)
    n_thickness = sums["n_thickness"].where(sums["n_thickness"] > 0)
    n_true = sums["n_true"].where(sums["n_true"] > 0)
    means_bins = {
        "mean_absolute_error": sums["absolute_error"] / n_found,
        "bias": sums["error"] / n_found,
        "thickness_mean_absolute_error": sums["thickness_absolute_error"] / n_thickness,
        "thickness_bias": sums["thickness_error"] / n_thickness,
    }
    table = sums.drop(columns=list(SUMS))
    for name, mean_bins in means_bins.items():
        table[f"{name}_bins"] = mean_bins
        table[f"{name}_m"] = mean_bins * bin_size_m
    table["share_within"] = sums["n_within"] / n_found
    table["share_found"] = sums["n_found"] / n_true
    return table.join(sums[["n_layers", "n_missed_layers", "n_false_layers", "n_true", "n_found"]])


def snow_per_bin_m(bin_size_s, density_kg_m3):
    """Thickness of snow in one range bin [m], ``c t / (2 n)`` for the two-way travel time t."""
    return SPEED_OF_LIGHT_M_S * bin_size_s / (2 * (1 + KOVACS_M3_KG * density_kg_m3))
