"""Slow changes of brightness along track that all snow of a scene shares, as where aircraft roll.

Picks and powers of layers do not tell of them: layers fade each by itself there.
"""

from itertools import combinations

import numpy as np
from scipy.linalg import toeplitz

from snowsim.cgan.grain import correlated

# Correlation falls to 1/e over so many range lines: scenes of a few hundred cannot tell longer.
LENGTH_LINES = 200.0
# They fall to 1/e over so many range bins: deep snow fades less. A flight of 120 scenes tells no
# more than that it is above 100.
FALL_BINS = 300.0
LAGS = np.arange(1, 65)  # [range lines]; at 0, lines share the gain from line to line
# Slabs of snow below the uppermost layer: closer, its own strength dominates.
FIRST_BIN, SLAB_BINS, N_SLABS = 30, 40, 5


def fade_spread(scenes):
    """Standard deviation of fades at the surface [grey levels], 0 where observed scenes show none.

    Of slabs of snow at fixed depths: speckle and layers differ between two of them that are not
    neighbours, fades do not. The mean product of their grey levels' deviations from the scene's
    mean, at `LAGS`, over scenes, is fitted by ``exp(-lag / LENGTH_LINES)`` and the falls of both
    slabs.
    """
    products = {}
    for scene in scenes:
        if scene.n_range_lines > LAGS[-1]:
            _add_products(products, scene)
    if not products:
        return 0.0
    seen = {pair: np.mean(of_scenes) for pair, of_scenes in products.items()}
    falls = {pair: np.prod(_fall(_middles(np.array(pair)))) for pair in seen}
    variance = sum(falls[pair] * seen[pair] for pair in seen)
    variance /= sum(fall**2 for fall in falls.values())
    return float(np.sqrt(max(variance, 0.0)))


def draw_fades(surface, n_range_bins, spread, *, rng):
    """Fades of a scene about their mean along track [grey levels], (range_bin, range_line).

    `surface` is the row of the uppermost layer, (range_line,), NaN where it is not known and
    nothing fades.
    """
    unit = correlated(rng.standard_normal((1, surface.size)), LENGTH_LINES, axis=1)[0]
    depth = np.arange(n_range_bins)[:, None] - np.rint(surface)
    return np.where(depth >= 0, spread * (unit - unit.mean()) * _fall(depth), 0.0)


def _fall(depth):
    return np.exp(-depth / FALL_BINS)


def _middles(number):
    """Depth of the middle of slabs [range bins]."""
    return FIRST_BIN + SLAB_BINS * (number + 0.5)


def _add_products(products, scene):
    """Add a scene's variance of fades by every two slabs, lists by pair of numbers."""
    layers = scene.layer_bins[np.isfinite(scene.layer_bins).any(axis=1)]
    if len(layers) == 0:
        return
    first = round(float(np.nanmedian(layers[0]))) + FIRST_BIN
    n_slabs = min((scene.n_range_bins - first) // SLAB_BINS, N_SLABS)
    law = _expected_products(scene.n_range_lines)
    deviations = []
    for number in range(n_slabs):
        top = first + number * SLAB_BINS
        mean = scene.image[top : top + SLAB_BINS].mean(axis=0)
        deviations.append(mean - mean.mean())
    for upper, lower in combinations(range(n_slabs), 2):
        if lower - upper > 1:
            found = _products(deviations[upper], deviations[lower])
            products.setdefault((upper, lower), []).append((law @ found) / (law @ law))


def _products(upper, lower):
    """Mean product at `LAGS`, of either with the other further on."""
    both = [upper[:-lag] @ lower[lag:] + lower[:-lag] @ upper[lag:] for lag in LAGS]
    return np.array(both) / (2 * (len(upper) - LAGS))


def _expected_products(n_lines):
    """The same of fades of unit variance, less their mean."""
    covariance = toeplitz(np.exp(-np.arange(n_lines) / LENGTH_LINES))
    of_mean = covariance.mean(axis=0)
    about_mean = covariance - of_mean - of_mean[:, None] + of_mean.mean()
    return np.array([np.diagonal(about_mean, lag).mean() for lag in LAGS])
