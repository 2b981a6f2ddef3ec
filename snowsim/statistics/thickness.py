"""Thickness of the slabs of a flight: its means by accumulation zone, and what varies about them.

Blocks are 256 range lines of a frame. A zone holds blocks of like mean thickness of slab 0.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from snowsim.constants import BLOCK_LINES
from snowsim.echogram import zone_of
from snowsim.limits import check_count
from snowsim.statistics.paper import thickness_spectra
from snowsim.statistics.relief import MINIMUM_BLOCKS, relief_by_zone, surface_statistics
from snowsim.statistics.summaries import in_blocks, known_mean

N_ZONES = 4
N_QUANTILES = 33  # of slab 0's block means: the inner edges of 1, 2, 4 or 8 zones among them
MOST_SWEEPS = 200
LEVEL_TOLERANCE = 1e-12  # of the logarithm of thickness


@dataclass(frozen=True)
class Blocks:
    """Blocks that lie in a zone."""

    mean: np.ndarray  # thickness, (block, slab), NaN where unknown
    level: np.ndarray  # mean thickness of slab 0, (block,)
    zone: np.ndarray  # (block,)
    typical: np.ndarray  # thickness of slab 0, (zone,)


def thickness_statistics(summary, *, estimator, zone_edge_bins=None):
    """Statistics of thickness and of the surface's row: variables and attributes, two dicts.

    Variables are name to (dimensions, values): `zone_edge_bins (edge)`; `thickness_mean_bins`,
    `thickness_variance_bins2`, `relative_thickness_mean`, `relative_thickness_variance`,
    `n_samples (zone, slab)` of block means; `first_thickness_quantile_bins (quantile)`, evenly from
    0 to 1; `n_blocks_by_layers (zone, n_layers)` by layers below the surface, from 0; those of
    `relief_by_zone`, by the estimator `paper` those of `thickness_spectra` instead; and those of
    `surface_statistics`. Attributes are the counts `n_blocks`, `n_blocks_not_placed`,
    `n_blocks_without_layers` and, of zones whose relief is that of all together,
    `n_zones_of_all_relief`.

    Zones hold equal numbers of blocks by mean thickness of slab 0 (Yari et al. 2021 have four and
    give no bounds), or lie between `zone_edge_bins (edge,)`. A block counts for the mean of a slab
    if half of its lines have both layers. One in which slab 0 is not picked is placed by its other
    slabs, see `block_levels`; its layers are those down to the deepest slab known. A zone with
    fewer than `MINIMUM_BLOCKS` of a slab takes that slab in all zones, relative to slab 0; a slab
    with too few everywhere takes the one above. ValueError if no block has slab 0 picked in half of
    its lines.
    """
    depth_bins = in_blocks(summary, "depth_bins").swapaxes(1, 2)
    n_layers = depth_bins.shape[1]
    mean = block_means(np.diff(depth_bins, axis=1))
    what = f"zones need slab 0 picked in half of a block of {BLOCK_LINES} lines: blocks"
    check_count(what, np.isfinite(mean[:, :1]).sum())
    level = block_levels(mean)
    placed = np.isfinite(level)
    # Below the surface, down to the deepest slab known.
    n_below = np.where(np.isfinite(mean), np.arange(1, n_layers), 0).max(axis=1, initial=0)
    attributes = {
        "n_blocks": len(mean),
        "n_blocks_not_placed": int((~placed).sum()),
        "n_blocks_without_layers": int((n_below == 0).sum()),
    }
    level, mean, depth_bins = level[placed], mean[placed], depth_bins[placed]
    if zone_edge_bins is None:
        zone_edge_bins = np.quantile(level, np.linspace(0, 1, N_ZONES + 1))
    edges = np.asarray(zone_edge_bins, dtype=float)
    zone = zone_of(level, edges)
    # The middle of a zone without blocks.
    middle = pd.Series((edges[:-1] + edges[1:]) / 2)
    typical = pd.Series(level).groupby(zone).mean().combine_first(middle).to_numpy()
    blocks = Blocks(mean, level, zone, typical)
    by_layers = np.zeros((typical.size, n_layers), dtype=int)
    np.add.at(by_layers, (zone, n_below[placed]), 1)
    quantiles = np.quantile(level, np.linspace(0, 1, N_QUANTILES))
    variables = moments_by_zone(blocks)
    variables |= {
        "zone_edge_bins": ("edge", edges),
        "first_thickness_quantile_bins": ("quantile", quantiles),
        "n_blocks_by_layers": (("zone", "n_layers"), by_layers),
    }
    if estimator == "paper":
        variables |= thickness_spectra(np.diff(depth_bins, axis=1), blocks)
    else:
        spacing_m = float(np.median(summary["line_spacing_m"]))
        relief, n_of_all = relief_by_zone(depth_bins, zone, typical.size, spacing_m)
        variables |= relief
        attributes["n_zones_of_all_relief"] = n_of_all
    return variables | surface_statistics(summary), attributes


def block_means(thickness):
    """Mean thickness by block and slab, (block, slab), over the lines that have it.

    NaN where fewer than half do.
    """
    often = 2 * np.isfinite(thickness).sum(axis=2) >= thickness.shape[2]
    return np.where(often, known_mean(thickness, axis=2), np.nan)


def block_levels(mean):
    """Mean thickness of slab 0 in every block [bins], (block,).

    From block means (block, slab), NaN where not picked. Where slab 0 is missing, thickness is
    modelled as the block's level times the slab's factor: both follow by least squares of the
    logarithms, in alternating sweeps that start from blocks with slab 0. NaN for a block that
    shares no slab with the others.
    """
    logarithm = np.log(mean)
    picked = level = logarithm[:, 0]
    for _ in range(MOST_SWEEPS):
        before = level
        factor = known_mean(logarithm - level[:, None], axis=0)
        others = known_mean(logarithm - factor, axis=1)
        level = np.where(np.isfinite(picked), picked, others)
        if np.allclose(level, before, rtol=0, atol=LEVEL_TOLERANCE, equal_nan=True):
            break
    return np.exp(level)


def moments_by_zone(blocks):
    """Moments of block-mean thickness, absolute and relative, as variables (zone, slab)."""
    thickness = pd.DataFrame(blocks.mean)
    share = thickness.div(blocks.level, axis=0)
    zones = range(blocks.typical.size)
    n = thickness.groupby(blocks.zone).count().reindex(zones, fill_value=0)
    own = n >= MINIMUM_BLOCKS
    known = own | (n.sum() >= MINIMUM_BLOCKS)
    # It defines a zone: the placed blocks give it even where its own picks are few.
    known[0] = True
    mean, variance = share.mean(), share.var().fillna(0)
    absolute = np.outer(blocks.typical**2, variance)
    absolute[:, 0] = np.var(blocks.level - blocks.typical[blocks.zone], ddof=min(len(share) - 1, 1))
    moments = {
        "thickness_mean_bins": (thickness, "mean", np.outer(blocks.typical, mean)),
        "thickness_variance_bins2": (thickness, "var", absolute),
        "relative_thickness_mean": (share, "mean", mean),
        "relative_thickness_variance": (share, "var", variance),
    }
    variables = {"n_samples": (("zone", "slab"), n.to_numpy())}
    for name, (table, moment, of_all) in moments.items():
        of_zone = table.groupby(blocks.zone).agg(moment).reindex(zones)
        values = of_zone.where(own, of_all, axis=1).where(known).ffill(axis=1)
        variables[name] = ("zone", "slab"), values.to_numpy()
    return variables
