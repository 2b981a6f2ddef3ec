"""What labels are drawn from with other numbers of zones, and how well each number explains the flight."""

import numpy as np
import xarray as xr

from snowsim.statistics.blocks import (
    BAND_EDGES,
    BLOCK_LINES,
    block_levels,
    block_means,
    periodogram,
    spectral_blocks,
    thickness_blocks,
)
from snowsim.statistics.estimate import label_dimensions
from snowsim.statistics.zones import ALL_ZONES, MINIMUM_BLOCKS, OTHER_SLABS, OWN_ZONE, zone_of, zone_statistics


def zone_models(summary, n_layers, counts):
    """Thickness statistics of a flight divided into other numbers of zones.

    Parameters
    ----------
    summary : list of FrameSummary
    n_layers : int
        Layers to use, those `estimate` reports.
    counts : iterable of int
        Numbers of zones.

    Returns
    -------
    list of xarray.Dataset
        For each number what `snowsim.labels.prepare` needs, as `estimate` gives it, and beside it `block_psd (zone,
        slab, wavenumber)`, mean periodogram of the zone's own blocks, 0 where it has none; attributes
        `means_log_likelihood`, `means_aic_penalty`, `means_bic_penalty`, `means_n_parameters` of block-mean thickness
        relative to slab 0, and `dispersion` of periodograms.

    Raises
    ------
    ValueError
        What `zone_statistics` refuses, or a number of zones below 1.

    Notes
    -----
    Relative thickness is taken as Gaussian in each zone and slab, blocks and slabs as independent; slabs with too few
    blocks for values of their own add nothing. `means_aic_penalty`
    is that of Hurvich & Tsai (1989), Biometrika 76, 297-307, cell by cell, for cells hold few blocks:
    ``2 k n / (n - k - 1)``. Dispersion is the mean over cells and wavenumbers of the variance of periodograms over
    their squared mean: 1 for a Gaussian process, more where blocks of one cell differ in level.
    """
    counts = list(counts)
    if min(counts) < 1:
        msg = f"a flight has at least one zone, got {min(counts)}"
        raise ValueError(msg)
    thickness = thickness_blocks(summary, n_layers)
    return [_zone_model(thickness, n_zones) for n_zones in counts]


def _zone_model(thickness, n_zones):
    values = zone_statistics(thickness, n_zones=n_zones)
    mean = block_means(thickness)
    level, _ = block_levels(mean)
    placed = np.isfinite(level)
    zone = np.where(placed, zone_of(np.where(placed, level, 0), values["zone_edge_bins"]), -1)
    dataset = xr.Dataset(
        {name: (label_dimensions(name), value) for name, value in values.items() if np.ndim(value)}
        | {"block_psd": (("zone", "slab", "wavenumber"), _own_density(thickness, zone, n_zones))},
        coords={
            "wavenumber": np.fft.rfftfreq(BLOCK_LINES),
            "band_edge_wavenumber": ("band_edge", BAND_EDGES / BLOCK_LINES),
        },
    )
    relative = mean / np.where(placed, level, np.nan)[:, None]
    return dataset.assign_attrs(_means_likelihood(relative, zone, values), dispersion=_dispersion(values))


def _own_density(thickness, zone, n_zones):
    """Mean periodogram of each zone's own blocks, (zone, slab, wavenumber); 0 where there is none."""
    thickness, _ = spectral_blocks(thickness, MINIMUM_BLOCKS)
    served = np.isfinite(thickness).all(axis=2)
    density = np.zeros((n_zones, thickness.shape[1], thickness.shape[2] // 2 + 1))
    for z, slab in np.ndindex(density.shape[:2]):
        held = served[:, slab] & (zone == z)
        if held.any():
            density[z, slab] = periodogram(thickness[held, slab]).mean(axis=0)
    return density


def _means_likelihood(relative, zone, values):
    """Log likelihood of relative block means and the penalties of their Gaussians."""
    total = {"means_log_likelihood": 0.0, "means_aic_penalty": 0.0, "means_bic_penalty": 0.0, "means_n_parameters": 0}
    names = ("relative_thickness_mean", "relative_thickness_variance", "source")
    for slab in range(1, relative.shape[1]):
        known = np.isfinite(relative[:, slab]) & (zone >= 0)
        for z, (mean, variance, source) in enumerate(zip(*(values[name][:, slab] for name in names), strict=True)):
            held = relative[known & (zone == z), slab]
            if held.size and variance > 0 and source != OTHER_SLABS:
                squares = (held - mean) ** 2 / variance
                total["means_log_likelihood"] -= 0.5 * (np.log(2 * np.pi * variance) + squares).sum()
            _add_penalty(total, held.size if source == OWN_ZONE else 0)
        # Zones with too few blocks of a slab share one Gaussian of all.
        _add_penalty(total, known.sum() if (values["source"][:, slab] == ALL_ZONES).any() else 0)
    return total


def _add_penalty(total, n, k=2):
    """Penalties of the mean and variance of `n` values; too few to tell, as of one more than they need."""
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
    density, error = (values[name][own] for name in ("thickness_psd", "thickness_psd_standard_error"))
    share = np.divide(error, density, out=np.zeros_like(error), where=density > 0)
    # The error is s / sqrt(n); (s / m)^2 of n exponential values has the mean n / (n + 1).
    return max(float(((n + 1) * share**2)[:, 1:-1].mean()), 1.0)
