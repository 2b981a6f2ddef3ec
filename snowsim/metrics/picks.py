"""Errors of picks: which true layer each pick belongs to, and sums by layer.

Sums can be pooled over many scenes: by training set, by accumulation zone or by depth.
"""

import numpy as np
import pandas as pd

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


def match_picks(picks, layer_bins, *, max_distance_bins=10.0):
    """Assign picks to true layers, both (row, range_line), line by line and keeping their order.

    Of all assignments that keep the order, the one with the least sum of distances, where a layer
    without a pick counts `max_distance_bins`; found by dynamic programming. Returns the error of
    each layer, pick less truth [range bins], NaN where the layer is absent or has no pick, and
    where each pick was used. Picks that cross and unlike widths are refused.
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
    """Index of what was found for each entry expected, -1 for none.

    The order-keeping assignment of least distance.
    """
    n = expected.size
    m = found.size
    # gain[i, j]: the most that the first i expected and j found can save of max_distance each.
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
    """Table of a scene: one row for each true and each false layer, summed over range lines.

    `picks` and `layer_bins` are those of `match_picks`; layer 0, the surface, must be present, or
    no layer at all. A picked layer is false if less than half of its picks belong to true layers.
    Columns are:

    - `layer`: number of the true layer, -1 for a false one;
    - `depth_bins`: its mean depth below the surface [range bins];
    - `n_true`, `n_found`: pixels of the true layer, and those of them with a pick;
    - `error`, `absolute_error`: sums of pick less truth and of its absolute value [range bins];
    - `n_within`: picks with an error of at most `within_bins`;
    - `n_thickness`, `thickness_error`, `thickness_absolute_error`: the same count and sums for the
      thickness of the slab above, where both of its bounds have a pick;
    - `n_picks`: picks of a false layer;
    - `n_layers`, `n_missed_layers`, `n_false_layers`: 1 or 0, whether the row is a true layer, a
      missed one (picked on less than half of its range lines), a false one.
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
    return values[np.isfinite(values)]


def pool_picks(rows, by, *, bin_size_m):
    """Pool rows of `layer_rows` over each group of equal values in the columns `by`.

    The table has one row a group, in order of first appearance. Beside the columns `by` it holds
    `mean_absolute_error_bins` and `bias_bins`, both also for the thickness, and all four in metres
    (`_m`), where a range bin spans `bin_size_m` of snow; `share_within`, of found pixels;
    `share_found`, of true pixels; `n_layers`, `n_missed_layers`, `n_false_layers`, `n_true` and
    `n_found`. Errors are NaN where nothing was found.
    """
    sums = rows.groupby(by, sort=False)[list(SUMS)].sum().reset_index()
    return errors_of_sums(sums, bin_size_m)


def errors_of_sums(sums, bin_size_m):
    """The table with its columns `SUMS` replaced by the error columns of `pool_picks`."""
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
    """Thickness of snow [m] that one range bin spans, there and back, ``c t / (2 n)``."""
    return SPEED_OF_LIGHT_M_S * bin_size_s / (2 * (1 + KOVACS_M3_KG * density_kg_m3))
