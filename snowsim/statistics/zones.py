"""Accumulation zones of a flight: moments and spectra of every slab in each, and how well a number of zones fits."""

import numpy as np
import xarray as xr

from snowsim.statistics.blocks import (
    BAND_EDGES,
    BLOCK_LINES,
    block_levels,
    block_means,
    correlation_by_separation,
    mean_correlation,
    on_wavenumbers,
    periodogram,
    pick_noise,
    rises,
    stretches,
    thickness_blocks,
    undulation_correlation,
    without_noise,
)

N_ZONES = 4
MINIMUM_BLOCKS = 4  # with fewer a variance has a standard error of its own size: the zone is pooled with the others
N_QUANTILES = 33  # of slab 0's block means: the inner edges of 1, 2, 4 or 8 zones among them
OWN_ZONE, ALL_ZONES, OTHER_SLABS = 0, 1, 2  # where values of a zone and slab come from
DIMENSIONS = {
    "zone_edge_bins": ("edge",),
    "thickness_psd": ("zone", "slab", "wavenumber"),
    "thickness_correlation": ("band", "separation"),
    **dict.fromkeys(("relative_thickness_correlation", "trend_correlation"), ("separation",)),
    **{
        "n_gap_blocks": ("slab",),
        "pick_noise_bins2": ("layer",),
        "n_blocks_by_layers": ("zone", "n_layers"),
    },
    "first_thickness_quantile_bins": ("quantile",),
}  # all others: zone and slab


def zone_statistics(thickness, zone_edge_bins=None, *, n_zones=N_ZONES, tapered=True):
    """Statistics of thickness (block, slab, range_line) [bins], NaN in gaps, by accumulation zone: dict of arrays.

    Zones hold equal numbers of blocks by mean thickness of slab 0 (quartiles in Yari et al. 2021),
    or lie between `zone_edge_bins (edge,)`. Returned are `zone_edge_bins (edge)`;
    `thickness_mean_bins`, `thickness_variance_bins2`, `relative_thickness_mean`,
    `relative_thickness_variance (zone, slab)`, `thickness_psd (zone, slab, wavenumber)`, each with
    `<name>_standard_error`; `n_samples`, `n_psd_samples`, `source`, `psd_source (zone, slab)`;
    `thickness_correlation (band, separation)`, `relative_thickness_correlation (separation)`;
    `n_gap_blocks (slab)`; `first_thickness_quantile_bins (quantile)`, evenly from 0 to 1,
    `n_blocks_by_layers (zone, n_layers)` by layers below the surface, from 0; `n_blocks`,
    `n_blocks_placed_by_other_slabs`, `n_blocks_not_placed`, `n_blocks_without_layers`,
    `n_spectral_lines`. ValueError if no block has slab 0 picked in half of its lines.

    A block counts for the mean of a slab if half of its lines have both layers, for its spectrum if
    all have; if hardly a block is without gaps, spectra are those of shorter stretches,
    `n_spectral_lines` long (`stretches`). `tapered` spectra are about the block's trend, which has
    its own `thickness_trend_variance_bins2 (zone, slab)` of the rise from first line to last and
    `trend_correlation (separation)`; the noise of picks, `pick_noise_bins2 (layer)`, is subtracted.
    Otherwise they are plain periodograms, with noise and trend. A block in which slab 0 is not
    picked is placed by its other slabs (`block_levels`); its layers are those down to the deepest
    slab known. A zone with fewer than `MINIMUM_BLOCKS` of a slab takes that slab in all zones,
    relative to slab 0 (source 1); a slab with too few everywhere takes the one above, slab 0 all
    slabs together (source 2). Standard errors take blocks as independent, those of variances take
    thickness as Gaussian.
    """
    mean = block_means(thickness)
    level, own = (
        block_levels(mean)
        if mean.shape[1]
        else (np.zeros(len(mean)), np.zeros(len(mean), dtype=bool))
    )
    if not own.any():
        msg = f"zones need slab 0 picked in half of a block of {BLOCK_LINES} lines, of {len(mean)} blocks none is so"
        raise ValueError(msg)
    placed = np.isfinite(level)
    deepest = np.where(np.isfinite(mean), np.arange(1, mean.shape[1] + 1), 0).max(axis=1)
    series = stretches(thickness, MINIMUM_BLOCKS)
    n_parts = len(series) // len(thickness)
    counts = {
        "n_gap_blocks": (~np.isfinite(thickness).all(axis=2)).sum(axis=0),
        "n_blocks": len(mean),
        "n_blocks_placed_by_other_slabs": int((placed & ~own).sum()),
        "n_blocks_not_placed": int((~placed).sum()),
        "n_blocks_without_layers": int((deepest == 0).sum()),
        "n_spectral_lines": series.shape[2],
    }
    series, mean, level, deepest = (
        series[np.repeat(placed, n_parts)],
        mean[placed],
        level[placed],
        deepest[placed],
    )
    served = np.isfinite(series).all(axis=2)
    edges, edges_error = _edges(level, zone_edge_bins, n_zones)
    zone = zone_of(level, edges)
    held = [level[zone == z] for z in range(edges.size - 1)]
    typical = np.array(
        [part.mean() if part.size else edges[z : z + 2].mean() for z, part in enumerate(held)]
    )
    result = _moments_by_zone(mean, level, zone, typical)
    result |= _spectra_by_zone(
        series, served, np.repeat(level, n_parts), np.repeat(zone, n_parts), typical, tapered
    )
    result |= {"zone_edge_bins": edges, "zone_edge_bins_standard_error": edges_error}
    result["relative_thickness_correlation"] = mean_correlation(
        mean / level[:, None], zone, MINIMUM_BLOCKS
    )
    result["first_thickness_quantile_bins"] = np.quantile(level, np.linspace(0, 1, N_QUANTILES))
    by_layers = np.zeros((edges.size - 1, mean.shape[1] + 1), dtype=int)
    np.add.at(by_layers, (zone, deepest), 1)
    return result | {"n_blocks_by_layers": by_layers} | counts


def zone_of(first_thickness_bins, zone_edge_bins):
    """Zone of a mean first-slab thickness, 0 the shallowest; beyond the outer edges the outer zones."""
    return np.searchsorted(zone_edge_bins[1:-1], first_thickness_bins, side="right")


def place_blocks(thickness, zone_edge_bins):
    """Block means (block, slab), mean thickness of slab 0 (block,), NaN where unknown, and zone (block,), -1 there."""
    mean = block_means(thickness)
    level, _ = block_levels(mean)
    placed = np.isfinite(level)
    return mean, level, np.where(placed, zone_of(np.where(placed, level, 0), zone_edge_bins), -1)


def as_variables(zones):
    """Arrays of `zone_statistics` as variables of a dataset, name to (dimensions, values)."""
    names = [name for name, value in zones.items() if np.ndim(value)]
    return {
        name: (DIMENSIONS.get(name.removesuffix("_standard_error"), ("zone", "slab")), zones[name])
        for name in names
    }


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
    # The thickness of slab 0 defines a zone: the placed blocks give it even where its own picks are
    # few.
    source[:, 0] = np.minimum(source[:, 0], ALL_ZONES)
    thickness, relative = (
        np.zeros((4, *n.shape)) for _ in range(2)
    )  # value and error of two moments
    for z in range(len(typical)):
        for slab in range(mean.shape[1]):
            if source[z, slab] == OTHER_SLABS:
                thickness[:, z, slab], relative[:, z, slab] = (
                    thickness[:, z, slab - 1],
                    relative[:, z, slab - 1],
                )
                continue
            held = known[:, slab] & ((zone == z) | (source[z, slab] == ALL_ZONES))
            share = mean[held, slab] / level[held]
            values = mean[held, slab] if source[z, slab] == OWN_ZONE else share * typical[z]
            if slab == 0 and source[z, slab] == ALL_ZONES:
                values = (
                    typical[z] + level - np.array([level[zone == other].mean() for other in zone])
                )
            thickness[:, z, slab], relative[:, z, slab] = _moments(values), _moments(share)
    names = (
        "mean_bins",
        "mean_bins_standard_error",
        "variance_bins2",
        "variance_bins2_standard_error",
    )
    result = {f"thickness_{name}": values for name, values in zip(names, thickness, strict=True)}
    names = ("mean", "mean_standard_error", "variance", "variance_standard_error")
    result |= {
        f"relative_thickness_{name}": values for name, values in zip(names, relative, strict=True)
    }
    return result | {"n_samples": n, "source": source}


def _spectra_by_zone(series, served, level, zone, typical, tapered):
    """Spectra of thickness, (zone, slab, wavenumber), of its trend and the noise of picks, and their correlations."""
    n_zones, n_slabs, n_lines = len(typical), series.shape[1], series.shape[2]
    n, source = _sources(served, zone, n_zones)
    density = np.zeros((n_zones, n_slabs, BLOCK_LINES // 2 + 2))  # and the variance of trends
    error = np.zeros(density.shape)
    for slab in range(n_slabs):
        for z in range(n_zones):
            if source[z, slab] == OTHER_SLABS and slab > 0:
                density[z, slab], error[z, slab] = density[z, slab - 1], error[z, slab - 1]
                continue
            held = served & (np.arange(n_slabs) == slab)
            if source[z, slab] == OWN_ZONE:
                part = _squares(series[held & (zone == z)[:, None]], tapered)
            else:
                held = held if source[z, slab] == ALL_ZONES else served
                part = (
                    _squares(series[held], tapered)
                    * (typical[z] / level[held.nonzero()[0], None]) ** 2
                )
            density[z, slab] = part.mean(axis=0)
            # A periodogram's standard deviation is its mean: used where blocks are too few to
            # measure it.
            scatter = part.std(axis=0, ddof=1) if len(part) >= MINIMUM_BLOCKS else density[z, slab]
            error[z, slab] = scatter / np.sqrt(len(part))
    (density, trend), (error, trend_error) = (
        (part[..., :-1], part[..., -1]) for part in (density, error)
    )
    result = {"n_psd_samples": n, "psd_source": source}
    noise_density = 0.0
    if tapered:
        noise, noise_error = pick_noise(series, served, MINIMUM_BLOCKS)
        noise_density = (noise[:-1] + noise[1:])[:, None] * [0, *[2] * (BLOCK_LINES // 2 - 1), 1]
        density = without_noise(density, noise_density)
        rise = np.where(served, rises(np.where(served[..., None], series, 0)), 0)
        unit = np.sqrt(BLOCK_LINES / n_lines / np.where(trend > 0, trend, np.inf))[zone]
        result["trend_correlation"] = correlation_by_separation((rise * unit)[..., None])
        for name, *values in (
            ("thickness_trend_variance", trend, trend_error),
            ("pick_noise", noise, noise_error),
        ):
            result[f"{name}_bins2"], result[f"{name}_bins2_standard_error"] = values
    at = np.rint(np.arange(n_lines // 2 + 1) * BLOCK_LINES / n_lines).astype(int)
    # Pick noise of a tenth of a density or more distorts the correlation between slabs.
    usable = np.where(density > 10 * noise_density, density, 0)[zone][..., at]
    result["thickness_correlation"] = undulation_correlation(
        series, served, usable, tapered=tapered
    )
    return result | {"thickness_psd": density, "thickness_psd_standard_error": error}


def _squares(series, tapered):
    """Periodograms at a block's wavenumbers, and squared rise, scaled to a block as a random walk's, (series, both)."""
    density = on_wavenumbers(periodogram(series, tapered=tapered), BLOCK_LINES)
    return np.column_stack([density, rises(series) ** 2 * (BLOCK_LINES / series.shape[-1])])


def _moments(values):
    """Mean and variance of independent Gaussian values, each followed by its standard error; 0 for one value."""
    n = values.size
    variance = values.var(ddof=1) if n > 1 else 0.0
    return values.mean(), np.sqrt(variance / n), variance, variance * np.sqrt(2 / max(n - 1, 1))


def zone_models(summary, n_layers, counts, *, tapered=True):
    """Thickness statistics of a flight divided into other numbers of zones: a dataset for each of `counts`, from 1.

    Each holds what `snowsim.labels.prepare` needs, of the `n_layers` layers that `estimate`
    reports; `block_psd (zone, slab, wavenumber)`, mean periodogram of the zone's own blocks, 0
    where it has none; and attributes `means_log_likelihood`, `means_aic_penalty`,
    `means_bic_penalty`, `means_n_parameters` of block means relative to slab 0, `dispersion`, and
    `independent_share` of a spectrum's wavenumbers.

    Relative thickness is taken as Gaussian in each zone and slab, blocks and slabs as independent;
    slabs with too few blocks for values of their own add nothing. `means_aic_penalty` is that of
    Hurvich & Tsai (1989), Biometrika 76, 297-307, by cell, because cells hold few blocks: ``2 k n /
    (n - k - 1)``. Dispersion: variance of periodograms over their squared mean, averaged: 1 for a
    Gaussian process, more where blocks of one cell differ in level.
    """
    counts = list(counts)
    if min(counts) < 1:
        msg = f"a flight has at least one zone, got {min(counts)}"
        raise ValueError(msg)
    thickness = thickness_blocks(summary, n_layers)
    return [_zone_model(thickness, n_zones, tapered) for n_zones in counts]


def _zone_model(thickness, n_zones, tapered):
    values = zone_statistics(thickness, n_zones=n_zones, tapered=tapered)
    mean, level, zone = place_blocks(thickness, values["zone_edge_bins"])
    own = _own_density(thickness, zone, n_zones, tapered)
    dataset = xr.Dataset(
        as_variables(values) | {"block_psd": (DIMENSIONS["thickness_psd"], own)},
        coords={
            "wavenumber": np.fft.rfftfreq(BLOCK_LINES),
            "band_edge_wavenumber": ("band_edge", BAND_EDGES / BLOCK_LINES),
        },
    )
    likelihood = _means_likelihood(mean / level[:, None], zone, values)
    # Squares of Hann's ordinates correlate by (2/3)^2 and (1/6)^2 with their neighbours on either
    # side.
    share = 1 / (1 + 2 * (4 / 9 + 1 / 36)) if tapered else 1.0
    return dataset.assign_attrs(likelihood, dispersion=_dispersion(values), independent_share=share)


def _own_density(thickness, zone, n_zones, tapered):
    """Mean periodogram of each zone's own stretches, (zone, slab, wavenumber); 0 where there is none."""
    series = stretches(thickness, MINIMUM_BLOCKS)
    zone = np.repeat(zone, len(series) // len(thickness))
    served = np.isfinite(series).all(axis=2)
    density = np.zeros((n_zones, thickness.shape[1], BLOCK_LINES // 2 + 1))
    for z, slab in np.ndindex(density.shape[:2]):
        held = served[:, slab] & (zone == z)
        if held.any():
            density[z, slab] = _squares(series[held, slab], tapered)[:, :-1].mean(axis=0)
    return density


def _means_likelihood(relative, zone, values):
    """Log likelihood of relative block means and the penalties of their Gaussians."""
    total = {
        "means_log_likelihood": 0.0,
        "means_aic_penalty": 0.0,
        "means_bic_penalty": 0.0,
        "means_n_parameters": 0,
    }
    names = ("relative_thickness_mean", "relative_thickness_variance", "source")
    for slab in range(1, relative.shape[1]):
        known = np.isfinite(relative[:, slab]) & (zone >= 0)
        for z, (mean, variance, source) in enumerate(
            zip(*(values[name][:, slab] for name in names), strict=True)
        ):
            held = relative[known & (zone == z), slab]
            if held.size and variance > 0 and source != OTHER_SLABS:
                squares = (held - mean) ** 2 / variance
                total["means_log_likelihood"] -= (
                    0.5 * (np.log(2 * np.pi * variance) + squares).sum()
                )
            _add_penalty(total, held.size if source == OWN_ZONE else 0)
        # Zones with too few blocks of a slab share one Gaussian of all.
        _add_penalty(total, known.sum() if (values["source"][:, slab] == ALL_ZONES).any() else 0)
    return total


def _add_penalty(total, n, k=2):
    """Penalties of the mean and variance of `n` values; if these are too few, as for one more than needed."""
    if n:
        total["means_aic_penalty"] += float(2 * k * n / max(n - k - 1, 1))
        total["means_bic_penalty"] += float(k * np.log(n))
        total["means_n_parameters"] += k


def _dispersion(values):
    """Variance of periodograms over their squared mean, mean of the cells with spectra of their own; at least 1."""
    own = values["psd_source"] == OWN_ZONE
    if not own.any():
        return 1.0
    n = values["n_psd_samples"][own][:, None]
    density, error = (
        values[name][own] for name in ("thickness_psd", "thickness_psd_standard_error")
    )
    share = np.divide(error, density, out=np.zeros_like(error), where=density > 0)
    # The error is s / sqrt(n); (s / m)^2 of n exponential values has the mean n / (n + 1).
    return max(float(((n + 1) * share**2)[:, 1:-1].mean()), 1.0)
