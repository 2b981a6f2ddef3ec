"""Accumulation zones of a flight: moments and spectra of every slab, and how well they fit."""

from dataclasses import astuple, dataclass

import numpy as np

from snowsim.echogram import zone_of
from snowsim.limits import check_count
from snowsim.statistics.blocks import (
    BLOCK_LINES,
    block_levels,
    block_means,
    correlation_by_separation,
    for_spectra,
    for_trends,
    mean_correlation,
    on_wavenumbers,
    periodogram,
    pick_noise,
    rises,
    undulation_correlation,
    without_noise,
)

N_ZONES = 4
# With fewer a variance has a standard error of its own size: the zone is pooled with the others.
MINIMUM_BLOCKS = 4
N_QUANTILES = 33  # of slab 0's block means: the inner edges of 1, 2, 4 or 8 zones among them
QUANTILE_WINDOW = (
    0.1  # of probability to either side, for the density of thickness at a zone's edge
)
# Where values of a zone and slab come from.
OWN_ZONE = 0
ALL_ZONES = 1
OTHER_SLABS = 2
# Pick noise of a tenth of a density or more distorts the correlation between slabs.
CLEAR_OF_NOISE = 10
DIMENSIONS = {
    "zone_edge_bins": ("edge",),
    "thickness_psd": ("zone", "slab", "wavenumber"),
    "thickness_correlation": ("band", "separation"),
    "relative_thickness_correlation": ("separation",),
    "trend_correlation": ("separation",),
    "n_gap_blocks": ("slab",),
    "pick_noise_bins2": ("layer",),
    "n_blocks_by_layers": ("zone", "n_layers"),
    "first_thickness_quantile_bins": ("quantile",),
}  # all others: zone and slab


@dataclass(frozen=True)
class Blocks:
    """Blocks that lie in a zone."""

    mean: np.ndarray  # thickness, (block, slab), NaN where unknown
    level: np.ndarray  # mean thickness of slab 0, (block,)
    zone: np.ndarray  # (block,)
    typical: np.ndarray  # thickness of slab 0, (zone,)


@dataclass(frozen=True)
class Stretches:
    """Stretches of blocks that lie in a zone."""

    series: np.ndarray  # thickness, (stretch, slab, range_line)
    served: np.ndarray  # those without gaps, bool (stretch, slab)
    level: np.ndarray  # mean thickness of slab 0, (stretch,)
    zone: np.ndarray  # (stretch,)

    @classmethod
    def of(cls, series, placed, blocks):
        """Those of `placed` (block,) blocks among `series` of all."""
        n_parts = len(series) // len(placed)
        series = series[np.repeat(placed, n_parts)]
        return cls(
            series=series,
            served=np.isfinite(series).all(axis=2),
            level=np.repeat(blocks.level, n_parts),
            zone=np.repeat(blocks.zone, n_parts),
        )


def zone_statistics(
    thickness, zone_edge_bins=None, *, n_zones=N_ZONES, tapered=True, finest_lines=None
):
    """Statistics of thickness (block, slab, range_line) [bins], NaN in gaps, by accumulation zone.

    A dict of arrays. Zones hold equal numbers of blocks by mean thickness of slab 0 (Yari et al.
    2021 have four and give no bounds), or lie between `zone_edge_bins (edge,)`. Returned are
    `zone_edge_bins (edge)`; `thickness_mean_bins`, `thickness_variance_bins2`,
    `relative_thickness_mean`, `relative_thickness_variance (zone, slab)`, `thickness_psd (zone,
    slab, wavenumber)`, each with
    `<name>_standard_error`; `n_samples`, `n_psd_samples`, `source`, `psd_source (zone, slab)`;
    `thickness_correlation (band, separation)`, `relative_thickness_correlation (separation)`;
    `n_gap_blocks (slab)`; `first_thickness_quantile_bins (quantile)`, evenly from 0 to 1,
    `n_blocks_by_layers (zone, n_layers)` by layers below the surface, from 0; `n_blocks`,
    `n_blocks_placed_by_other_slabs`, `n_blocks_not_placed`, `n_blocks_without_layers`,
    `n_spectral_lines`. ValueError if no block has slab 0 picked in half of its lines, or none that
    is placed has a stretch without gaps.

    A block counts for the mean of a slab if half of its lines have both layers, for its spectrum if
    all have; where too few blocks are without gaps, spectra are those of shorter stretches,
    `n_spectral_lines` long (`for_spectra`). `tapered` spectra are about the trend, which has its
    own `thickness_trend_variance_bins2 (zone, slab)` of the rise from a block's first line to its
    last and `trend_correlation (separation)`, of stretches as long as can be had (`for_trends`);
    the noise of picks, `pick_noise_bins2 (layer)`, is subtracted. Otherwise they are plain
    periodograms, with noise and trend, of these long stretches. Undulations shorter than
    `finest_lines`, where given, are left out of both. A block in which slab 0 is not picked is
    placed by its other slabs (`block_levels`); its layers are those down to the deepest slab known.
    A zone with fewer than `MINIMUM_BLOCKS` of a slab takes that slab in all zones,
    relative to slab 0 (source 1); a slab with too few everywhere takes the one above, slab 0 all
    slabs together (source 2). Standard errors take blocks as independent, those of variances take
    thickness as Gaussian.
    """
    mean = block_means(thickness)
    n_known = np.isfinite(mean[:, :1]).sum()
    check_count(
        f"zones need slab 0 picked in half of a block of {BLOCK_LINES} lines: blocks", n_known
    )
    level, own = block_levels(mean)
    placed = np.isfinite(level)
    n_slabs = mean.shape[1]
    # Below the surface, down to the deepest slab known.
    n_layers = np.where(np.isfinite(mean), np.arange(1, n_slabs + 1), 0).max(axis=1)
    edges, edges_error = _edges(level[placed], zone_edge_bins, n_zones)
    zone = zone_of(level[placed], edges)
    typical = _typical(level[placed], zone, edges)
    blocks = Blocks(mean=mean[placed], level=level[placed], zone=zone, typical=typical)
    result = _moments_by_zone(blocks)
    result |= _along_track(thickness, placed, blocks, tapered, finest_lines)
    relative = blocks.mean / blocks.level[:, None]
    by_layers = np.zeros((blocks.typical.size, n_slabs + 1), dtype=int)
    np.add.at(by_layers, (zone, n_layers[placed]), 1)
    quantiles = np.linspace(0, 1, N_QUANTILES)
    return result | {
        "zone_edge_bins": edges,
        "zone_edge_bins_standard_error": edges_error,
        "relative_thickness_correlation": mean_correlation(relative, zone, MINIMUM_BLOCKS),
        "first_thickness_quantile_bins": np.quantile(blocks.level, quantiles),
        "n_blocks_by_layers": by_layers,
        "n_gap_blocks": (~np.isfinite(thickness).all(axis=2)).sum(axis=0),
        "n_blocks": len(mean),
        "n_blocks_placed_by_other_slabs": int((placed & ~own).sum()),
        "n_blocks_not_placed": int((~placed).sum()),
        "n_blocks_without_layers": int((n_layers == 0).sum()),
    }


def as_variables(zones):
    """Arrays of `zone_statistics` as variables of a dataset, name to (dimensions, values)."""
    variables = {}
    for name, values in zones.items():
        if np.ndim(values):
            dims = DIMENSIONS.get(name.removesuffix("_standard_error"), ("zone", "slab"))
            variables[name] = dims, values
    return variables


def _edges(level, given, n_zones):
    """Zone edges and their standard errors from the density of order statistics.

    Given ones have none.
    """
    if given is not None:
        return np.asarray(given, dtype=float), np.zeros(len(given))
    n = level.size
    at = np.linspace(0, 1, n_zones + 1)
    inner = np.clip(at, 1 / (n + 1), n / (n + 1))
    low = np.clip(inner - QUANTILE_WINDOW, 0, 1)
    high = np.clip(inner + QUANTILE_WINDOW, 0, 1)
    per_probability = (np.quantile(level, high) - np.quantile(level, low)) / (high - low)
    return np.quantile(level, at), np.sqrt(inner * (1 - inner) / n) * per_probability


def _typical(level, zone, edges):
    """Mean thickness of slab 0 in each zone, (zone,); the middle of one without blocks."""
    typical = (edges[:-1] + edges[1:]) / 2
    for z in np.unique(zone):
        typical[z] = level[zone == z].mean()
    return typical


def _sources(known, zone, n_zones):
    """Number of blocks `known (block, slab)` and where values come from, two (zone, slab)."""
    n = np.array([known[zone == z].sum(axis=0) for z in range(n_zones)])
    enough_in_all = np.where(n.sum(axis=0) >= MINIMUM_BLOCKS, ALL_ZONES, OTHER_SLABS)
    return n, np.where(n >= MINIMUM_BLOCKS, OWN_ZONE, enough_in_all)


@dataclass(frozen=True)
class Gaussian:
    """Mean and variance of independent Gaussian values, and their standard errors."""

    mean: np.ndarray
    mean_error: np.ndarray
    variance: np.ndarray
    variance_error: np.ndarray


def _gaussian(values):
    """`Gaussian` of values; a single one has no variance."""
    n = values.size
    variance = values.var(ddof=1) if n > 1 else 0.0
    variance_error = variance * np.sqrt(2 / max(n - 1, 1))
    return Gaussian(values.mean(), np.sqrt(variance / n), variance, variance_error)


def _table(cells, shape):
    """`Gaussian` of arrays, from one of each cell, row by row."""
    values = np.transpose([astuple(cell) for cell in cells])
    return Gaussian(*values.reshape(-1, *shape))


def _moments_by_zone(blocks):
    """Moments of block-mean thickness, absolute and relative, (zone, slab)."""
    known = np.isfinite(blocks.mean)
    n, source = _sources(known, blocks.zone, blocks.typical.size)
    # The thickness of slab 0 defines a zone: the placed blocks give it even where its own picks are
    # few.
    source[:, 0] = np.minimum(source[:, 0], ALL_ZONES)
    absolute, relative = [], []
    for z, slab in np.ndindex(n.shape):
        if source[z, slab] == OTHER_SLABS:
            absolute.append(absolute[-1])
            relative.append(relative[-1])
            continue
        own = source[z, slab] == OWN_ZONE
        held = known[:, slab] & (blocks.zone == z) if own else known[:, slab]
        mean = blocks.mean[held, slab]
        share = mean / blocks.level[held]
        if own:
            values = mean
        elif slab == 0:
            values = blocks.typical[z] + blocks.level - blocks.typical[blocks.zone]
        else:
            values = share * blocks.typical[z]
        absolute.append(_gaussian(values))
        relative.append(_gaussian(share))
    absolute = _table(absolute, n.shape)
    relative = _table(relative, n.shape)
    return {
        "thickness_mean_bins": absolute.mean,
        "thickness_mean_bins_standard_error": absolute.mean_error,
        "thickness_variance_bins2": absolute.variance,
        "thickness_variance_bins2_standard_error": absolute.variance_error,
        "relative_thickness_mean": relative.mean,
        "relative_thickness_mean_standard_error": relative.mean_error,
        "relative_thickness_variance": relative.variance,
        "relative_thickness_variance_standard_error": relative.variance_error,
        "n_samples": n,
        "source": source,
    }


def _mean_squares(stretches, typical, squares_of):
    """Means of `squares_of` series (series, quantity), standard errors, numbers and sources.

    Four of (zone, slab, quantity) and (zone, slab).
    """
    served = stretches.served
    slabs = np.arange(served.shape[1])
    n, source = _sources(served, stretches.zone, typical.size)
    n_quantities = squares_of(np.zeros((1, stretches.series.shape[2]))).shape[1]
    mean = np.zeros((*n.shape, n_quantities))
    error = np.zeros(mean.shape)
    for z, slab in np.ndindex(n.shape):
        if source[z, slab] == OTHER_SLABS and slab > 0:
            mean[z, slab] = mean[z, slab - 1]
            error[z, slab] = error[z, slab - 1]
            continue
        held = served if source[z, slab] == OTHER_SLABS else served & (slabs == slab)
        if source[z, slab] == OWN_ZONE:
            squares = squares_of(stretches.series[held & (stretches.zone == z)[:, None]])
        else:
            squares = squares_of(stretches.series[held])
            squares *= (typical[z] / stretches.level[held.nonzero()[0], None]) ** 2
        mean[z, slab] = squares.mean(axis=0)
        # A periodogram's standard deviation is its mean: used where blocks are too few to measure
        # it.
        enough = len(squares) >= MINIMUM_BLOCKS
        scatter = squares.std(axis=0, ddof=1) if enough else mean[z, slab]
        error[z, slab] = scatter / np.sqrt(len(squares))
    return mean, error, n, source


def _along_track(thickness, placed, blocks, tapered, finest_lines):
    """Spectra, trends and correlations along track of the `placed` blocks (block,)."""
    long = Stretches.of(for_trends(thickness, MINIMUM_BLOCKS), placed, blocks)
    what = f"spectra: stretches of {long.series.shape[2]} lines of a slab without gaps in blocks "
    check_count(f"{what}that slab 0 places", long.served.sum())
    if not tapered:
        spectra = _plain_spectra(long, blocks.typical, finest_lines)
        return spectra | {"n_spectral_lines": long.series.shape[2]}
    series = for_spectra(thickness, MINIMUM_BLOCKS, finest_lines)
    short = Stretches.of(series, placed, blocks)
    spectra = _spectra_and_noise(short, blocks.typical, finest_lines)
    trends = _trends(long, blocks.typical)
    return spectra | trends | {"n_spectral_lines": series.shape[2]}


def _spectra_and_noise(stretches, typical, finest_lines):
    """Tapered spectra of thickness without the noise of picks, that noise, and correlations."""
    measured = _mean_squares(stretches, typical, _tapered_density)
    noise, error = pick_noise(stretches.series, stretches.served, MINIMUM_BLOCKS)
    result = _spectra(stretches, measured, _difference_density(noise), finest_lines, tapered=True)
    return result | {"pick_noise_bins2": noise, "pick_noise_bins2_standard_error": error}


def _plain_spectra(stretches, typical, finest_lines):
    """Plain periodograms of thickness, and correlations."""
    measured = _mean_squares(stretches, typical, _plain_density)
    return _spectra(stretches, measured, 0.0, finest_lines, tapered=False)


def _spectra(stretches, measured, noise_density, finest_lines, *, tapered):
    """Spectra by what `_mean_squares` measured, and correlations of undulations between slabs."""
    density, error, n, source = measured
    density = without_noise(density, noise_density)
    if finest_lines is not None:
        density[..., np.arange(density.shape[-1]) * finest_lines > BLOCK_LINES] = 0
    seen = np.where(density > CLEAR_OF_NOISE * noise_density, density, 0)
    series, served = stretches.series, stretches.served
    n_lines = series.shape[2]
    cycles = np.arange(n_lines // 2 + 1) * BLOCK_LINES / n_lines
    expected = seen[stretches.zone][..., np.rint(cycles).astype(int)]
    return {
        "n_psd_samples": n,
        "psd_source": source,
        "thickness_psd": density,
        "thickness_psd_standard_error": error,
        "thickness_correlation": undulation_correlation(series, served, expected, tapered=tapered),
    }


def _trends(stretches, typical):
    """Variance of the rise over a block, and its correlation between slabs."""
    variance, error, _, _ = _mean_squares(stretches, typical, _squared_rise)
    variance = variance[..., 0]
    return {
        "thickness_trend_variance_bins2": variance,
        "thickness_trend_variance_bins2_standard_error": error[..., 0],
        "trend_correlation": _trend_correlation(stretches, variance[stretches.zone]),
    }


def _tapered_density(series):
    """Periodograms at a block's wavenumbers, about the trend, (series, wavenumber)."""
    return on_wavenumbers(periodogram(series, tapered=True), BLOCK_LINES)


def _plain_density(series):
    """Periodograms at a block's wavenumbers, about the mean, (series, wavenumber)."""
    return on_wavenumbers(periodogram(series), BLOCK_LINES)


def _squared_rise(series):
    """Squared rise over a block, (series, 1): as a random walk's, it grows with length."""
    return (rises(series) ** 2 * (BLOCK_LINES / series.shape[-1]))[:, None]


def _difference_density(noise):
    """Density of slab thickness from the noise of the picks above and below, (slab, wavenumber)."""
    one_sided = np.full(BLOCK_LINES // 2 + 1, 2)
    one_sided[0] = 0
    one_sided[-1] = 1
    return (noise[:-1] + noise[1:])[:, None] * one_sided


def _trend_correlation(stretches, variance):
    """Correlation of trends between slabs, (separation,), by expected variance (stretch, slab)."""
    series = np.where(stretches.served[..., None], stretches.series, 0)
    rise = np.where(stretches.served, rises(series), 0)
    n_parts = BLOCK_LINES / series.shape[2]
    unit = np.sqrt(n_parts / np.where(variance > 0, variance, np.inf))
    return correlation_by_separation((rise * unit)[..., None])
