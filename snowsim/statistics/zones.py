"""Accumulation zones: quartiles of first-slab thickness, with moments and spectra of every slab in each."""

import numpy as np

from snowsim.statistics.blocks import (
    BLOCK_LINES,
    block_levels,
    block_means,
    mean_correlation,
    periodogram,
    spectral_blocks,
    undulation_correlation,
)

N_ZONES = 4
MINIMUM_BLOCKS = 4  # with fewer a variance has a standard error of its own size: the zone is pooled with the others
OWN_ZONE, ALL_ZONES, OTHER_SLABS = 0, 1, 2


def zone_statistics(thickness, zone_edge_bins=None, *, n_zones=N_ZONES):
    """Statistics of thickness by accumulation zone.

    Parameters
    ----------
    thickness : ndarray, (block, slab, range_line)
        [bins]; NaN in gaps.
    zone_edge_bins : array_like, (edge,), optional
        Edges of the zones in mean thickness of slab 0; by default its quantiles over all blocks.
    n_zones : int
        Zones of equally many blocks where no edges are given; quartiles in Yari et al. (2021).

    Returns
    -------
    dict
        Arrays by name: `zone_edge_bins (edge)`; `thickness_mean_bins`, `thickness_variance_bins2`,
        `relative_thickness_mean`, `relative_thickness_variance (zone, slab)`, `thickness_psd (zone, slab, wavenumber)`,
        each with `<name>_standard_error`; `n_samples`, `n_psd_samples`, `source`, `psd_source (zone, slab)`;
        `thickness_correlation (band, separation)`, `relative_thickness_correlation (separation)`; `n_gap_blocks (slab)`
        and `n_blocks`, `n_blocks_placed_by_other_slabs`, `n_blocks_not_placed`, `n_closed_blocks`.

    Raises
    ------
    ValueError
        If slab 0 is picked in half of the lines of no block.

    Notes
    -----
    A block counts for the mean of a slab where half of its lines have both layers, for its spectrum where all have,
    or fewer where hardly a block is without gaps (`spectral_blocks`, counted by `n_closed_blocks`). A block in
    which slab 0 is not picked is placed by its other slabs (`block_levels`). A zone with fewer than
    `MINIMUM_BLOCKS` of a slab takes that slab in all zones, as a share of the first (source 1); a slab with too few
    everywhere takes the one above, the first all slabs together (source 2). Standard errors take blocks as
    independent, those of variances take thickness as Gaussian.
    """
    mean = block_means(thickness)
    level, own = block_levels(mean) if mean.shape[1] else (np.zeros(len(mean)), np.zeros(len(mean), dtype=bool))
    if not own.any():
        msg = f"zones need slab 0 picked in half of a block of {BLOCK_LINES} lines, of {len(mean)} blocks none is so"
        raise ValueError(msg)
    closed, n_closed = spectral_blocks(thickness, MINIMUM_BLOCKS)
    served = np.isfinite(closed).all(axis=2)
    placed = np.isfinite(level)
    counts = {
        "n_gap_blocks": (~np.isfinite(thickness).all(axis=2)).sum(axis=0),
        "n_blocks": len(mean),
        "n_blocks_placed_by_other_slabs": int((placed & ~own).sum()),
        "n_blocks_not_placed": int((~placed).sum()),
        "n_closed_blocks": n_closed,
    }
    closed, mean, served, level = closed[placed], mean[placed], served[placed], level[placed]
    edges, edges_error = _edges(level, zone_edge_bins, n_zones)
    zone = zone_of(level, edges)
    held = [level[zone == z] for z in range(edges.size - 1)]
    typical = np.array([part.mean() if part.size else edges[z : z + 2].mean() for z, part in enumerate(held)])
    result = _moments_by_zone(mean, level, zone, typical)
    result |= _spectra_by_zone(closed, served, level, zone, typical)
    result |= {"zone_edge_bins": edges, "zone_edge_bins_standard_error": edges_error}
    result["thickness_correlation"] = undulation_correlation(closed, served, result["thickness_psd"][zone])
    result["relative_thickness_correlation"] = mean_correlation(mean / level[:, None], zone, MINIMUM_BLOCKS)
    return result | counts


def zone_of(first_thickness_bins, zone_edge_bins):
    """Zone of a mean first-slab thickness, 0 the shallowest; beyond the outer edges the outer zones."""
    return np.searchsorted(zone_edge_bins[1:-1], first_thickness_bins, side="right")


def _edges(level, given, n_zones):
    """Zone edges and their standard errors from the density of order statistics; given ones have none."""
    if given is not None:
        return np.asarray(given, dtype=float), np.zeros(len(given))
    at = np.linspace(0, 1, n_zones + 1)
    inner = np.clip(at, 1 / (level.size + 1), level.size / (level.size + 1))
    low, high = np.clip(inner - 0.1, 0, 1), np.clip(inner + 0.1, 0, 1)
    per_probability = (np.quantile(level, high) - np.quantile(level, low)) / (high - low)
    return np.quantile(level, at), np.sqrt(inner * (1 - inner) / level.size) * per_probability


def _sources(known, zone, n_zones):
    """Number of blocks and where values come from, two (zone, slab), for blocks `known (block, slab)`."""
    n = np.array([known[zone == z].sum(axis=0) for z in range(n_zones)])
    enough_in_all = np.where(n.sum(axis=0) >= MINIMUM_BLOCKS, ALL_ZONES, OTHER_SLABS)
    return n, np.where(n >= MINIMUM_BLOCKS, OWN_ZONE, enough_in_all)


def _moments_by_zone(mean, level, zone, typical):
    """Moments of block-mean thickness, absolute and relative, (zone, slab)."""
    known = np.isfinite(mean)
    n, source = _sources(known, zone, len(typical))
    # The thickness of slab 0 is what makes a zone: the placed blocks tell it even where its own picks are few.
    source[:, 0] = np.minimum(source[:, 0], ALL_ZONES)
    thickness, relative = (np.zeros((4, *n.shape)) for _ in range(2))  # value and error of two moments
    for z in range(len(typical)):
        for slab in range(mean.shape[1]):
            if source[z, slab] == OTHER_SLABS:
                thickness[:, z, slab], relative[:, z, slab] = thickness[:, z, slab - 1], relative[:, z, slab - 1]
                continue
            held = known[:, slab] & ((zone == z) | (source[z, slab] == ALL_ZONES))
            share = mean[held, slab] / level[held]
            values = mean[held, slab] if source[z, slab] == OWN_ZONE else share * typical[z]
            if slab == 0 and source[z, slab] == ALL_ZONES:
                values = typical[z] + level - np.array([level[zone == other].mean() for other in zone])
            thickness[:, z, slab], relative[:, z, slab] = _moments(values), _moments(share)
    names = ("mean_bins", "mean_bins_standard_error", "variance_bins2", "variance_bins2_standard_error")
    result = {f"thickness_{name}": values for name, values in zip(names, thickness, strict=True)}
    names = ("mean", "mean_standard_error", "variance", "variance_standard_error")
    result |= {f"relative_thickness_{name}": values for name, values in zip(names, relative, strict=True)}
    return result | {"n_samples": n, "source": source}


def _spectra_by_zone(thickness, served, level, zone, typical):
    """Spectra of thickness about the block mean, (zone, slab, wavenumber)."""
    n, source = _sources(served, zone, len(typical))
    density = np.zeros((*n.shape, thickness.shape[2] // 2 + 1))
    error = np.zeros(density.shape)
    for slab in range(thickness.shape[1]):
        spectra = periodogram(thickness[served[:, slab], slab])
        where, first = zone[served[:, slab]], level[served[:, slab]]
        for z in range(len(typical)):
            if source[z, slab] == OTHER_SLABS and slab > 0:
                density[z, slab], error[z, slab] = density[z, slab - 1], error[z, slab - 1]
                continue
            if source[z, slab] == OWN_ZONE:
                part = spectra[where == z]
            elif source[z, slab] == ALL_ZONES:
                part = spectra * (typical[z] / first[:, None]) ** 2
            else:
                of_series = np.repeat(level, served.sum(axis=1))
                part = periodogram(thickness[served]) * (typical[z] / of_series[:, None]) ** 2
            density[z, slab] = part.mean(axis=0)
            # A periodogram scatters as its mean: with too few blocks to see that, it is taken as known.
            scatter = part.std(axis=0, ddof=1) if len(part) >= MINIMUM_BLOCKS else density[z, slab]
            error[z, slab] = scatter / np.sqrt(len(part))
    result = {"thickness_psd": density, "thickness_psd_standard_error": error}
    return result | {"n_psd_samples": n, "psd_source": source}


def _moments(values):
    """Mean and variance of independent Gaussian values, each with its standard error after it; one has variance 0."""
    n = values.size
    variance = values.var(ddof=1) if n > 1 else 0.0
    return values.mean(), np.sqrt(variance / n), variance, variance * np.sqrt(2 / max(n - 1, 1))
