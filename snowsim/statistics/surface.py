"""The surface's way along track: slow movement, and the fraction of a bin that compensation in whole bins leaves."""

import numpy as np

from snowsim.constants import BLOCK_LINES
from snowsim.statistics.blocks import on_wavenumbers, periodogram, rises, stretches, taper_overlap, without_noise

HARMONICS = np.arange(1, 9)[:, None]  # of the fraction; the next adds less than 1 / 300 of its variance


def surface_statistics(summary, minimum):
    """Statistics of the surface's row, name to (dimensions, values), each with a standard error.

    A product levels the aircraft's movement m in whole bins, which leaves ``m - round(m)``; a slow error comes on top.
    Where lines move by less than half a bin from one increment to the next, increments of m are those of the row less
    whole bins: `surface_movement_psd (wavenumber)` is their spectrum. `surface_fraction` is the number of whole-bin
    steps over that which rounding such a movement makes, 1 where a product does so, 0 where it does not.
    `surface_psd (wavenumber)` is the spectrum of the slow error about its trend, the fraction's taken off where there
    is one, and `surface_trend_variance_bins2` the variance of its rise over a block. From stretches without gaps.
    """
    blocks = []
    for frame in summary:
        n_blocks = frame.surface_bins.size // BLOCK_LINES
        blocks.append(frame.surface_bins[: n_blocks * BLOCK_LINES].astype(float).reshape(n_blocks, 1, BLOCK_LINES))
    rows = stretches(np.concatenate(blocks), minimum)[:, 0]
    rows = rows[np.isfinite(rows).all(axis=1)]
    step = np.diff(rows, axis=1)
    bend = np.diff(step, axis=1)
    start = step[:, :1] - np.rint(step[:, :1])
    movement = np.concatenate([start, start + np.cumsum(bend - np.rint(bend), axis=1)], axis=1)
    # Whole bins that every line moves by change nothing in the fraction.
    movement -= np.rint(movement.mean(axis=1, keepdims=True))
    jumps = np.abs(np.rint(step - movement)).sum(axis=1)
    expected = np.sqrt(2 / np.pi * (movement**2).mean()) * movement.shape[1]
    share = jumps / expected if expected > 0 else 0 * jumps
    values = {
        "surface_fraction": ((), share),
        "surface_movement_psd": (
            ("wavenumber",),
            on_wavenumbers(periodogram(movement[:, 1:], tapered=True), BLOCK_LINES),
        ),
        "surface_psd": (("wavenumber",), on_wavenumbers(periodogram(rows, tapered=True), BLOCK_LINES)),
        "surface_trend_variance_bins2": ((), rises(rows) ** 2 * (BLOCK_LINES / rows.shape[1])),
    }
    result = {}
    for name, (dims, part) in values.items():
        result[name] = dims, part.mean(axis=0)
        result[f"{name}_standard_error"] = dims, part.std(axis=0) / np.sqrt(max(len(part) - 1, 1))
    if has_fraction(result["surface_fraction"][1]):
        left = without_noise(result["surface_psd"][1], fraction_density(movement))
        result["surface_psd"] = ("wavenumber",), left
    return result


def has_fraction(share):
    """Whether a `surface_fraction` is that of a product which levels in whole bins."""
    return float(share) > 0.5


def fraction_density(movement):
    """Expected tapered density of ``m - round(m)`` at a block's wavenumbers, from increments of m (stretch, line).

    The fraction is ``sum_n (-1)^(n+1) sin(2 pi n m) / (pi n)``; where m wanders over bins its covariance is
    ``sum_n exp(-2 pi^2 n^2 D) / (2 pi^2 n^2)`` with D the structure function of m, taken as Gaussian.
    """
    row = np.cumsum(np.pad(movement, [(0, 0), (1, 0)]), axis=1)
    n_lines = row.shape[1]
    structure = np.array([0, *(((row[:, lag:] - row[:, :-lag]) ** 2).mean() for lag in range(1, n_lines))])
    rate = 2 * np.pi**2 * HARMONICS**2
    covariance = (np.exp(-rate * structure) / rate).sum(axis=0) * taper_overlap(n_lines)
    turns = np.cos(2 * np.pi * np.outer(np.arange(n_lines // 2 + 1) / n_lines, np.arange(1, n_lines)))
    density = 2 * (covariance[0] + 2 * turns @ covariance[1:])
    density[0], density[-1] = 0, density[-1] / 2
    return on_wavenumbers(density, BLOCK_LINES)
