"""Row of the surface along track: a slow error, and what levelling in whole bins leaves."""

import numpy as np

from snowsim.constants import BLOCK_LINES
from snowsim.statistics.blocks import (
    for_trends,
    on_wavenumbers,
    periodogram,
    rises,
    taper_of,
    without_noise,
)

# Of the steps that whole-bin levelling makes, above which a product is taken to do so.
ROUNDED_SHARE = 0.5
# Of the fraction; the next adds less than 1 / 300 of its variance.
HARMONICS = np.arange(1, 9)[:, None]


def surface_statistics(summary, minimum):
    """Statistics of the surface's row in stretches without gaps.

    By name (dimensions, values), with standard errors. A product levels the aircraft's movement m
    in whole bins, which leaves ``m - round(m)``; a slow error comes on top. As increments of m
    change by less than half a bin per line, they are those of the row less whole bins:
    `surface_movement_psd (wavenumber)` is their spectrum. `surface_fraction` is the number of
    whole-bin steps over the number that rounding such a movement makes: 1 if a product does so,
    else 0. `surface_psd (wavenumber)` is that of the slow error about its trend, less the
    fraction's, `surface_trend_variance_bins2` the variance of the trend.
    """
    whole = []
    for frame in summary:
        n_blocks = frame.surface_bins.size // BLOCK_LINES
        whole.append(frame.surface_bins[: n_blocks * BLOCK_LINES])
    blocks = np.concatenate(whole).astype(float).reshape(-1, 1, BLOCK_LINES)
    rows = for_trends(blocks, minimum)[:, 0]
    rows = rows[np.isfinite(rows).all(axis=1)]
    step = np.diff(rows, axis=1)
    movement = _movement(step)
    jumps = np.abs(np.rint(step - movement)).sum(axis=1)
    expected = np.sqrt(2 / np.pi * (movement**2).mean()) * movement.shape[1]
    rise2 = rises(rows) ** 2 * (BLOCK_LINES / rows.shape[1])
    values = {
        "surface_fraction": jumps / expected if expected > 0 else 0 * jumps,
        "surface_movement_psd": _density(movement[:, 1:]),
        "surface_psd": _density(rows),
        "surface_trend_variance_bins2": rise2,
    }
    result = {}
    for name, part in values.items():
        dims = ("wavenumber",) if part.ndim == 2 else ()
        error = part.std(axis=0) / np.sqrt(max(len(part) - 1, 1))
        result[name] = dims, part.mean(axis=0)
        result[f"{name}_standard_error"] = dims, error
    if result["surface_fraction"][1] > ROUNDED_SHARE:
        dims, density = result["surface_psd"]
        result["surface_psd"] = dims, without_noise(density, fraction_density(movement))
    return result


def _movement(step):
    """Increments of the aircraft's movement (stretch, line), from those of the row.

    Those of the row less whole bins, see `surface_statistics`.
    """
    first = step[:, :1] - np.rint(step[:, :1])
    bend = np.diff(step, axis=1)
    change = np.cumsum(bend - np.rint(bend), axis=1)
    movement = np.concatenate([first, first + change], axis=1)
    # Moving every line by whole bins does not change the fraction.
    return movement - np.rint(movement.mean(axis=1, keepdims=True))


def _density(series):
    return on_wavenumbers(periodogram(series, tapered=True), BLOCK_LINES)


def fraction_density(movement):
    """Expected tapered density of ``m - round(m)`` at a block's wavenumbers.

    From increments of m (stretch, line). The fraction is ``sum_n (-1)^(n+1) sin(2 pi n m) / (pi
    n)``; where m wanders over bins its covariance is ``sum_n exp(-2 pi^2 n^2 D) / (2 pi^2 n^2)``
    with D the structure function of m, taken as Gaussian.
    """
    row = np.cumsum(np.pad(movement, [(0, 0), (1, 0)]), axis=1)
    n_lines = row.shape[1]
    structure = np.zeros(n_lines)
    for lag in range(1, n_lines):
        structure[lag] = ((row[:, lag:] - row[:, :-lag]) ** 2).mean()
    rate = 2 * np.pi**2 * HARMONICS**2
    taper, _ = taper_of(n_lines)
    overlap = np.correlate(taper, taper, "full")[n_lines - 1 :] / (taper @ taper)
    covariance = (np.exp(-rate * structure) / rate).sum(axis=0) * overlap
    wavenumber = np.arange(n_lines // 2 + 1) / n_lines
    turns = np.cos(2 * np.pi * np.outer(wavenumber, np.arange(1, n_lines)))
    density = 2 * (covariance[0] + 2 * turns @ covariance[1:])
    density[0] = 0
    density[-1] /= 2
    return on_wavenumbers(density, BLOCK_LINES)
