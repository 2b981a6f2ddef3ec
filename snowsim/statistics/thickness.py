"""Thickness of the slabs of a flight: its means by accumulation zone, and what varies about them.

Blocks are 256 range lines of a frame. A zone holds blocks of like mean thickness of slab 0.
"""

from dataclasses import dataclass

import numpy as np

from snowsim.constants import BLOCK_LINES
from snowsim.echogram import zone_of
from snowsim.limits import check_count
from snowsim.statistics.moments import mean_where
from snowsim.statistics.relief import relief_by_zone
from snowsim.statistics.spectrum import thickness_spectra
from snowsim.statistics.surface import surface_statistics

N_ZONES = 4
# With fewer a variance has a standard error of its own size: the zone is pooled with the others.
MINIMUM_BLOCKS = 4
N_QUANTILES = 33  # of slab 0's block means: the inner edges of 1, 2, 4 or 8 zones among them
MINIMUM_PAIRS = 4  # (block, slab) pairs needed to estimate the correlation at a separation
MOST_SWEEPS = 200
LEVEL_TOLERANCE = 1e-12  # of the logarithm of thickness


@dataclass(frozen=True)
class Blocks:
    """Blocks that lie in a zone."""

    mean: np.ndarray  # thickness, (block, slab), NaN where unknown
    level: np.ndarray  # mean thickness of slab 0, (block,)
    zone: np.ndarray  # (block,)
    typical: np.ndarray  # thickness of slab 0, (zone,)


def thickness_statistics(summary, n_layers, *, estimator, zone_edge_bins=None):
    """Statistics of thickness and of the surface's row: variables and attributes, two dicts.

    Variables are name to (dimensions, values): `zone_edge_bins (edge)`; `thickness_mean_bins`,
    `thickness_variance_bins2`, `relative_thickness_mean`, `relative_thickness_variance`,
    `n_samples (zone, slab)` of block means; `relative_thickness_correlation (separation)`;
    `first_thickness_quantile_bins (quantile)`, evenly from 0 to 1; `n_blocks_by_layers (zone,
    n_layers)` by layers below the surface, from 0; those of `relief_by_zone`, by the estimator
    `paper` those of `thickness_spectra` instead; and those of `surface_statistics`. Attributes are
    the counts `n_blocks`, `n_blocks_not_placed`, `n_blocks_without_layers` and, of zones whose
    relief is that of all together, `n_zones_of_all_relief`.

    Zones hold equal numbers of blocks by mean thickness of slab 0 (Yari et al. 2021 have four and
    give no bounds), or lie between `zone_edge_bins (edge,)`. A block counts for the mean of a slab
    if half of its lines have both layers. One in which slab 0 is not picked is placed by its other
    slabs, see `block_levels`; its layers are those down to the deepest slab known. A zone with
    fewer than `MINIMUM_BLOCKS` of a slab takes that slab in all zones, relative to slab 0; a slab
    with too few everywhere takes the one above. ValueError if no block has slab 0 picked in half of
    its lines.
    """
    depth_bins = depth_blocks(summary, n_layers)
    mean = block_means(np.diff(depth_bins, axis=1))
    what = f"zones need slab 0 picked in half of a block of {BLOCK_LINES} lines: blocks"
    check_count(what, np.isfinite(mean[:, :1]).sum())
    level = block_levels(mean)
    placed = np.isfinite(level)
    edges = zone_edge_bins
    if edges is None:
        edges = np.quantile(level[placed], np.linspace(0, 1, N_ZONES + 1))
    edges = np.asarray(edges, dtype=float)
    zone = zone_of(level[placed], edges)
    blocks = Blocks(mean[placed], level[placed], zone, _typical(level[placed], zone, edges))
    # Below the surface, down to the deepest slab known.
    n_below = np.where(np.isfinite(mean), np.arange(1, mean.shape[1] + 1), 0).max(axis=1)
    by_layers = np.zeros((len(edges) - 1, n_layers), dtype=int)
    np.add.at(by_layers, (zone, n_below[placed]), 1)
    quantiles = np.quantile(blocks.level, np.linspace(0, 1, N_QUANTILES))
    moments = moments_by_zone(blocks)
    variables = moments | {
        "zone_edge_bins": ("edge", edges),
        "relative_thickness_correlation": ("separation", mean_correlation(blocks, moments)),
        "first_thickness_quantile_bins": ("quantile", quantiles),
        "n_blocks_by_layers": (("zone", "n_layers"), by_layers),
    }
    attributes = {
        "n_blocks": len(mean),
        "n_blocks_not_placed": int((~placed).sum()),
        "n_blocks_without_layers": int((n_below == 0).sum()),
    }
    if estimator == "paper":
        variables |= thickness_spectra(np.diff(depth_bins[placed], axis=1), blocks)
    else:
        spacing_m = float(np.median([frame.line_spacing_m for frame in summary]))
        relief, n_of_all = relief_by_zone(depth_bins[placed], zone, len(edges) - 1, spacing_m)
        variables |= relief
        attributes["n_zones_of_all_relief"] = n_of_all
    return variables | surface_statistics(summary), attributes


def depth_blocks(summary, n_layers):
    """Picks below the surface in whole blocks of all frames, (block, layer, range_line) [bins]."""
    blocks = []
    for frame in summary:
        n_blocks = frame.depth_bins.shape[1] // BLOCK_LINES
        held = frame.depth_bins[:n_layers, : n_blocks * BLOCK_LINES]
        depth = np.full((n_layers, n_blocks, BLOCK_LINES), np.nan)
        depth[: len(held)] = held.reshape(len(held), n_blocks, BLOCK_LINES)
        blocks.append(depth.swapaxes(0, 1))
    return np.concatenate(blocks)


def block_means(thickness):
    """Mean thickness by block and slab, (block, slab), over the lines that have it.

    NaN where fewer than half do.
    """
    known = np.isfinite(thickness)
    often = 2 * known.sum(axis=2) >= thickness.shape[2]
    return np.where(often, mean_where(known, thickness, axis=2), np.nan)


def block_levels(mean):
    """Mean thickness of slab 0 in every block [bins], (block,).

    From block means (block, slab), NaN where not picked. Where slab 0 is missing, thickness is
    modelled as the block's level times the slab's factor: both follow by least squares of the
    logarithms, in alternating sweeps that start from blocks with slab 0. NaN for a block that
    shares no slab with the others.
    """
    known = np.isfinite(mean)
    own = known[:, 0]
    logarithm = np.log(np.where(known, mean, 1))
    picked = np.where(own, logarithm[:, 0], np.nan)
    level = picked
    for _ in range(MOST_SWEEPS):
        before = level
        placed = known & np.isfinite(level)[:, None]
        factor = mean_where(placed, logarithm - level[:, None], axis=0)
        rated = known & np.isfinite(factor)
        level = np.where(own, picked, mean_where(rated, logarithm - factor, axis=1))
        if np.allclose(level, before, rtol=0, atol=LEVEL_TOLERANCE, equal_nan=True):
            break
    return np.exp(level)


def moments_by_zone(blocks):
    """Moments of block-mean thickness, absolute and relative, as variables (zone, slab)."""
    known = np.isfinite(blocks.mean)
    shape = (blocks.typical.size, known.shape[1])
    n = np.zeros(shape, dtype=int)
    np.add.at(n, blocks.zone, known)
    names = ("thickness_mean_bins", "thickness_variance_bins2")
    names += ("relative_thickness_mean", "relative_thickness_variance")
    moments = {name: np.zeros(shape) for name in names}
    n_in_all = n.sum(axis=0)
    for zone, slab in np.ndindex(shape):
        if n[zone, slab] >= MINIMUM_BLOCKS:
            held = known[:, slab] & (blocks.zone == zone)
            values = blocks.mean[held, slab]
        elif slab == 0:
            # It defines a zone: the placed blocks give it even where its own picks are few.
            held = known[:, 0]
            away = blocks.level - blocks.typical[blocks.zone]
            values = blocks.typical[zone] + away
        elif n_in_all[slab] >= MINIMUM_BLOCKS:
            held = known[:, slab]
            values = blocks.mean[held, slab] / blocks.level[held] * blocks.typical[zone]
        else:
            for table in moments.values():
                table[zone, slab] = table[zone, slab - 1]
            continue
        share = blocks.mean[held, slab] / blocks.level[held]
        for name, cell in zip(names, (*_gaussian(values), *_gaussian(share)), strict=True):
            moments[name][zone, slab] = cell
    on = ("zone", "slab")
    return {name: (on, table) for name, table in moments.items()} | {"n_samples": (on, n)}


def mean_correlation(blocks, moments):
    """Correlation between slabs of relative block means about those of their zone, (separation,).

    A zone needs `MINIMUM_BLOCKS` of a slab for a mean; a separation with fewer than `MINIMUM_PAIRS`
    (block, slab) pairs takes the value of the one before, the first 0. Slab 0 is 1 by definition
    and is left out.
    """
    names = ("relative_thickness_mean", "relative_thickness_variance", "n_samples")
    mean, variance, n = (moments[name][1][blocks.zone] for name in names)
    relative = blocks.mean / blocks.level[:, None]
    counts = np.isfinite(relative) & (n >= MINIMUM_BLOCKS) & (variance > 0)
    deviation = np.sqrt(np.where(counts, variance * (n - 1) / np.maximum(n, 1), 1))
    anomaly = np.where(counts, relative - mean, 0) / deviation
    n_slabs = relative.shape[1]
    correlation = np.zeros(n_slabs)
    for apart in range(1, n_slabs):
        above = anomaly[:, 1 : n_slabs - apart]
        below = anomaly[:, 1 + apart :]
        both = (above != 0) & (below != 0)
        correlation[apart] = correlation[apart - 1]
        if both.sum() >= MINIMUM_PAIRS:
            squares = (above[both] ** 2).sum() * (below[both] ** 2).sum()
            correlation[apart] = (above * below).sum() / np.sqrt(squares)
    # Of separation 0 it is 1, set last: until then its 0 stands in at separation 1.
    correlation[:1] = 1
    return correlation


def _typical(level, zone, edges):
    """Mean thickness of slab 0 in each zone, (zone,); the middle of one without blocks."""
    typical = (edges[:-1] + edges[1:]) / 2
    for z in np.unique(zone):
        typical[z] = level[zone == z].mean()
    return typical


def _gaussian(values):
    """Mean and variance of independent values; a single one has no variance."""
    return values.mean(), values.var(ddof=1) if values.size > 1 else 0.0
