"""Row of the surface along track: a slow error, and the fraction of a bin that levelling in whole bins leaves."""

import numpy as np

from snowsim.constants import BLOCK_LINES
from snowsim.statistics.blocks import (
    on_wavenumbers,
    periodogram,
    rises,
    stretches,
    taper_of,
    without_noise,
)

ROUNDED_SHARE = (
    0.5  # of the steps that whole-bin levelling makes, above which a product is taken to do so
)
HARMONICS = np.arange(1, 9)[
    :, None
]  # of the fraction; the next adds less than 1 / 300 of its variance


def surface_statistics(summary, minimum):
    """Statistics of the surface's row in stretches without gaps: (dimensions, values) by name, standard errors too.

    A product levels the aircraft's movement m in whole bins, which leaves ``m - round(m)``; a slow
    error comes on top. As increments of m change by less than half a bin per line, they are those
    of the row less whole bins: `surface_movement_psd (wavenumber)` is their spectrum.
    `surface_fraction` is the number of whole-bin steps over the number that rounding such a
    movement makes: 1 if a product does so, else 0. `surface_psd (wavenumber)` is that of the slow
    error about its trend, less the fraction's, `surface_trend_variance_bins2` the variance of the
    trend.
    """
    whole = [
        frame.surface_bins[: frame.surface_bins.size // BLOCK_LINES * BLOCK_LINES]
        for frame in summary
    ]
    rows = stretches(np.concatenate(whole).astype(float).reshape(-1, 1, BLOCK_LINES), minimum)[:, 0]
    rows = rows[np.isfinite(rows).all(axis=1)]
    step = np.diff(rows, axis=1)
    bend = np.diff(step, axis=1)
    start = step[:, :1] - np.rint(step[:, :1])
    movement = np.concatenate([start, start + np.cumsum(bend - np.rint(bend), axis=1)], axis=1)
    # Moving every line by whole bins does not change the fraction.
    movement -= np.rint(movement.mean(axis=1, keepdims=True))
    jumps = np.abs(np.rint(step - movement)).sum(axis=1)
    expected = np.sqrt(2 / np.pi * (movement**2).mean()) * movement.shape[1]
    share = jumps / expected if expected > 0 else 0 * jumps
    density, moving = (
        (("wavenumber",), on_wavenumbers(periodogram(series, tapered=True), BLOCK_LINES))
        for series in (rows, movement[:, 1:])
    )
    values = {
        "surface_fraction": ((), share),
        "surface_movement_psd": moving,
        "surface_psd": density,
        "surface_trend_variance_bins2": ((), rises(rows) ** 2 * (BLOCK_LINES / rows.shape[1])),
    }
    result = {}
    for name, (dims, part) in values.items():
        result[name] = dims, part.mean(axis=0)
        result[f"{name}_standard_error"] = dims, part.std(axis=0) / np.sqrt(max(len(part) - 1, 1))
    if result["surface_fraction"][1] > ROUNDED_SHARE:
        left = without_noise(result["surface_psd"][1], fraction_density(movement))
        result["surface_psd"] = ("wavenumber",), left
    return result


def fraction_density(movement):
    """Expected tapered density of ``m - round(m)`` at a block's wavenumbers, from increments of m (stretch, line).

    The fraction is ``sum_n (-1)^(n+1) sin(2 pi n m) / (pi n)``; where m wanders over bins its
    covariance is ``sum_n exp(-2 pi^2 n^2 D) / (2 pi^2 n^2)`` with D the structure function of m,
    taken as Gaussian.
    """
    row = np.cumsum(np.pad(movement, [(0, 0), (1, 0)]), axis=1)
    n_lines = row.shape[1]
    structure = np.array(
        [0, *(((row[:, lag:] - row[:, :-lag]) ** 2).mean() for lag in range(1, n_lines))]
    )
    rate = 2 * np.pi**2 * HARMONICS**2
    taper, _ = taper_of(n_lines)
    overlap = np.correlate(taper, taper, "full")[n_lines - 1 :] / (taper @ taper)
    covariance = (np.exp(-rate * structure) / rate).sum(axis=0) * overlap
    turns = np.cos(
        2 * np.pi * np.outer(np.arange(n_lines // 2 + 1) / n_lines, np.arange(1, n_lines))
    )
    density = 2 * (covariance[0] + 2 * turns @ covariance[1:])
    density[0], density[-1] = 0, density[-1] / 2
    return on_wavenumbers(density, BLOCK_LINES)
