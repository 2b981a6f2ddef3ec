"""Thickness of the slabs of a flight: its means by accumulation zone, and what varies about them.

Blocks are 256 range lines of a frame. A zone holds blocks of like mean thickness of slab 0.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from snowsim.constants import BLOCK_LINES
from snowsim.echogram import zone_of
from snowsim.limits import check_count
from snowsim.statistics.summaries import MINIMUM_BLOCKS, in_blocks, known_mean

N_ZONES = 4
N_QUANTILES = 33  # of the block means of slab 0; they include the edges of 1, 2, 4 or 8 zones
MOST_SWEEPS = 200
LEVEL_TOLERANCE = 1e-12  # of the logarithm of thickness


@dataclass(frozen=True)
class Blocks:
    """Blocks that lie in a zone, and the zones."""

    depth_bins: np.ndarray  # layers below the surface, (block, layer, range_line), NaN in gaps
    mean: np.ndarray  # thickness, (block, slab), NaN where unknown
    level: np.ndarray  # mean thickness of slab 0, (block,)
    n_below: np.ndarray  # layers below the surface, down to the deepest slab known, (block,)
    zone: np.ndarray  # (block,)
    zone_edge_bins: np.ndarray  # (edge,)
    typical: np.ndarray  # thickness of slab 0, (zone,)
    counts: dict  # numbers of all blocks, of those without a zone and of those without layers


def blocks_in_zones(summary, zone_edge_bins=None):
    """`Blocks` of a merged summary.

    Zones hold equal numbers of blocks by mean thickness of slab 0 (Yari et al. 2021 have four and
    give no bounds), or lie between `zone_edge_bins (edge,)`. A block counts for the mean of a slab
    if half of its lines have both layers. One in which slab 0 is not picked is placed by its other
    slabs, see `block_levels`; its layers are those down to the deepest slab known. ValueError if no
    block has slab 0 picked in half of its lines.
    """
    depth_bins = in_blocks(summary, "depth_bins").swapaxes(1, 2)
    n_layers = depth_bins.shape[1]
    thickness = np.diff(depth_bins, axis=1)
    often = 2 * np.isfinite(thickness).sum(axis=2) >= thickness.shape[2]
    mean = np.where(often, known_mean(thickness, axis=2), np.nan)
    what = f"zones need slab 0 picked in half of a block of {BLOCK_LINES} lines: blocks"
    check_count(what, np.isfinite(mean[:, :1]).sum())
    level = block_levels(mean)
    placed = np.isfinite(level)
    n_below = np.where(np.isfinite(mean), np.arange(1, n_layers), 0).max(axis=1, initial=0)
    if zone_edge_bins is None:
        zone_edge_bins = np.quantile(level[placed], np.linspace(0, 1, N_ZONES + 1))
    edges = np.asarray(zone_edge_bins, dtype=float)
    zone = zone_of(level[placed], edges)
    # The middle of a zone without blocks.
    middle = pd.Series((edges[:-1] + edges[1:]) / 2)
    typical = pd.Series(level[placed]).groupby(zone).mean().combine_first(middle).to_numpy()
    counts = {
        "n_blocks": len(mean),
        "n_blocks_not_placed": int((~placed).sum()),
        "n_blocks_without_layers": int((n_below == 0).sum()),
    }
    return Blocks(
        depth_bins=depth_bins[placed],
        mean=mean[placed],
        level=level[placed],
        n_below=n_below[placed],
        zone=zone,
        zone_edge_bins=edges,
        typical=typical,
        counts=counts,
    )


def thickness_statistics(blocks):
    """Statistics of mean thickness in `Blocks`: variables, name to (dimensions, values).

    `zone_edge_bins (edge)`; `thickness_mean_bins`, `thickness_variance_bins2`,
    `relative_thickness_mean`, `relative_thickness_variance`, `n_samples (zone, slab)` of block
    means; `first_thickness_quantile_bins (quantile)`, evenly from 0 to 1; `n_blocks_by_layers
    (zone, n_layers)` by layers below the surface, from 0. A zone with fewer than `MINIMUM_BLOCKS`
    of a slab takes that slab in all zones, relative to slab 0; a slab with too few everywhere takes
    the one above.
    """
    by_layers = np.zeros((blocks.typical.size, blocks.depth_bins.shape[1]), dtype=int)
    np.add.at(by_layers, (blocks.zone, blocks.n_below), 1)
    quantiles = np.quantile(blocks.level, np.linspace(0, 1, N_QUANTILES))
    return moments_by_zone(blocks) | {
        "zone_edge_bins": ("edge", blocks.zone_edge_bins),
        "first_thickness_quantile_bins": ("quantile", quantiles),
        "n_blocks_by_layers": (("zone", "n_layers"), by_layers),
    }


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
    # Slab 0 defines the zones: placed blocks give its mean even if it is rarely picked.
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
