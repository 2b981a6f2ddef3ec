"""Picks of many scenes in sums that can be pooled: by training set, by accumulation zone, against depth."""

import numpy as np
import pandas as pd

from snowsim.constants import KOVACS_M3_KG, SPEED_OF_LIGHT_M_S
from snowsim.metrics.picks import match_picks

ZONES = ("none", "shallow", "medium", "high", "very high")  # of zone -1, 0, 1, 2, 3
SUMS = (
    *("n_true", "n_found", "error", "absolute_error", "n_within"),
    *("n_thickness", "thickness_error", "thickness_absolute_error"),
    *("n_picks", "n_layers", "n_missed_layers", "n_false_layers"),
)


def layer_rows(picks, layer_bins, *, max_distance_bins=10.0, within_bins=2.0):
    """What became of every true layer of a scene, and every picked layer that is none, as sums over range lines.

    `picks` and `layer_bins` are those of `match_picks`, layer 0 the surface, which must be present.
    Columns `layer` (-1: a picked layer of which less than half belongs to any true one),
    `depth_bins` (mean below the surface) and `SUMS`: true pixels, those with a pick, sum of errors
    (pick less truth) and of their absolute values [range bins], errors of at most `within_bins`;
    the same of the thickness of the slab above, where both of its bounds have a pick; picks of
    false layers; 1 or 0 for a layer, one missed (a pick in less than half of its range lines), a
    false one.
    """
    picks, layer_bins = np.asarray(picks, dtype=float), np.asarray(layer_bins, dtype=float)
    error_bins, used = match_picks(picks, layer_bins, max_distance_bins=max_distance_bins)
    if not np.isfinite(layer_bins[:1]).any():
        msg = "layer_bins: expected the snow surface in row 0, it is absent"
        raise ValueError(msg)
    surface_bin = np.nanmean(layer_bins[0])
    thickness_error = np.diff(error_bins, axis=0, prepend=np.nan)
    rows = []
    for layer, truth in enumerate(layer_bins):
        n_true = int(np.isfinite(truth).sum())
        if n_true == 0:
            continue
        found = error_bins[layer][np.isfinite(error_bins[layer])]
        thickness = thickness_error[layer][np.isfinite(thickness_error[layer])]
        of_layer = (
            n_true,
            found.size,
            found.sum(),
            np.abs(found).sum(),
            int((np.abs(found) <= within_bins).sum()),
        )
        of_slab = (thickness.size, thickness.sum(), np.abs(thickness).sum())
        sums = (*of_layer, *of_slab, 0, 1, int(2 * found.size < n_true), 0)
        rows.append((layer, np.nanmean(truth) - surface_bin, *sums))
    picked = np.isfinite(picks)
    for pick in np.flatnonzero(2 * used.sum(axis=1) < picked.sum(axis=1)):
        none = dict.fromkeys(SUMS, 0) | {"n_picks": int(picked[pick].sum()), "n_false_layers": 1}
        rows.append((-1, np.nanmean(picks[pick]) - surface_bin, *none.values()))
    return pd.DataFrame(rows, columns=["layer", "depth_bins", *SUMS])


def pool_picks(rows, by, *, bin_size_m):
    """Errors of picks, from rows of `layer_rows`, pooled over all pixels of each group of the columns `by`.

    Columns of `by`, in order of first appearance, then `mean_absolute_error_bins`, `bias_bins`, the
    same of the thickness and all four as `_m`, with range bins of `bin_size_m` in snow;
    `share_within`, `share_found` of the true pixels, `n_layers`, `n_missed_layers`,
    `n_false_layers`, `n_true`, `n_found`. NaN where nothing was found.
    """
    if len(rows) == 0 or not bin_size_m > 0:
        msg = f"expected rows of picks and bin_size_m above 0, got {len(rows)} and {bin_size_m}"
        raise ValueError(msg)
    sums = rows.groupby(by, sort=False)[list(SUMS)].sum().reset_index()
    return errors_of_sums(sums, bin_size_m)


def errors_of_sums(sums, bin_size_m):
    """Columns of `pool_picks` beside the others of a table, from its columns `SUMS`."""
    # NaN, not a warning, where a group has none.
    n_found, n_thickness, n_true = (
        sums[n].where(sums[n] > 0) for n in ("n_found", "n_thickness", "n_true")
    )
    table = sums.drop(columns=list(SUMS))
    for name, total, n in (
        ("mean_absolute_error", "absolute_error", n_found),
        ("bias", "error", n_found),
        ("thickness_mean_absolute_error", "thickness_absolute_error", n_thickness),
        ("thickness_bias", "thickness_error", n_thickness),
    ):
        table[f"{name}_bins"] = sums[total] / n
        table[f"{name}_m"] = sums[total] / n * bin_size_m
    table["share_within"] = sums["n_within"] / n_found
    table["share_found"] = sums["n_found"] / n_true
    return table.join(sums[["n_layers", "n_missed_layers", "n_false_layers", "n_true", "n_found"]])


def snow_per_bin_m(bin_size_s, density_kg_m3):
    """Thickness of snow [m] that a pulse crosses and comes back through in one range bin, ``c t / (2 n)``."""
    return SPEED_OF_LIGHT_M_S * bin_size_s / (2 * (1 + KOVACS_M3_KG * density_kg_m3))


def zone_of(first_thickness_bins, zone_edge_bins):
    """Accumulation zone, 0 to 3, of thicknesses of the first slab [range bins], by the flight's quartiles; -1 for NaN.

    Thicknesses beyond the flight's fall in the outermost zones.
    """
    thickness = np.asarray(first_thickness_bins, dtype=float)
    zone = np.searchsorted(np.asarray(zone_edge_bins)[1:-1], thickness, side="right")
    return np.where(np.isnan(thickness), -1, zone)
