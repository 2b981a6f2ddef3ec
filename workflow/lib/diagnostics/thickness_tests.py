"""Whether thickness is Gaussian: the test of Lilliefors, with as many values as correlation leaves independent."""

from functools import lru_cache

import numpy as np
from scipy.special import ndtr

from snowsim.statistics.blocks import periodogram
from snowsim.statistics.zones import MINIMUM_BLOCKS, place_blocks

NULL_VALUES, NULL_DRAWS = 50, 20_000  # of the law under the null hypothesis; the seed is its own, the result a constant
NULL_SEED = 1967


def lilliefors(values, n_effective=None):
    """Distance of values from a Gaussian of their own mean and variance, and the probability of a larger one.

    There must be at least 4 values that differ; they may be worth only `n_effective` independent ones. Lilliefors
    (1967), J. Am. Stat. Assoc. 62, 399-402: Kolmogorov's distance with estimated parameters. Its law for any n follows
    from that of ``D (sqrt n - 0.01 + 0.85 / sqrt n)`` (Stephens 1974, J. Am. Stat. Assoc. 69, 730-737), which is taken
    from 20,000 draws: p-values to 0.003.
    """
    values = np.sort(np.asarray(values, dtype=float))
    if values.size < 4 or values[0] == values[-1]:
        msg = f"a test of normality needs 4 values that differ, got {values.size} from {values[0]:g} to {values[-1]:g}"
        raise ValueError(msg)
    distance = _distance(values[None])[0]
    n = values.size if n_effective is None else float(n_effective)
    null = _null()
    larger = null.size - np.searchsorted(null, _modified(distance, n))
    return float(distance), float((larger + 1) / (null.size + 1))


def _distance(values):
    """Kolmogorov's distance of sorted rows (row, value) from Gaussians of their own mean and variance, (row,)."""
    n = values.shape[1]
    expected = ndtr((values - values.mean(axis=1, keepdims=True)) / values.std(axis=1, ddof=1, keepdims=True))
    step = np.arange(n + 1) / n
    return np.maximum((step[1:] - expected).max(axis=1), (expected - step[:-1]).max(axis=1))


def _modified(distance, n):
    return distance * (np.sqrt(n) - 0.01 + 0.85 / np.sqrt(n))


@lru_cache(maxsize=1)
def _null():
    """Sorted draws of the modified distance of Gaussian values."""
    rng = np.random.Generator(np.random.PCG64(NULL_SEED))
    drawn = np.sort(rng.standard_normal((NULL_DRAWS, NULL_VALUES)), axis=1)
    return np.sort(_modified(_distance(drawn), NULL_VALUES))


def thickness_tests(thickness, zone_edge_bins, *, rng, n_draws=199):
    """Tests of the two Gaussian laws labels are drawn from, by zone and slab: a dict each.

    `thickness (block, slab, range_line)` [bins] has NaN in gaps; blocks of a frame stand together, in order. `of` is
    ``relative block mean`` (of slabs below the first) or ``undulation``, thickness of lines about the mean of their
    block over its s.d.; `p_value` holds if all `n` values were independent, `p_value_correlated` as they are.

    Neighbouring blocks share kilometre undulations: block means are worth ``n (1 - r) / (1 + r)`` values, not fewer
    than 4, r their correlation from block to block, not below 0. Lines are worth ``2 (sum P)^2 / sum P^2`` values a
    block for the mean periodogram P; their probability comes from `n_draws` Gaussian flights of that spectrum, as many,
    treated alike.
    """
    mean, level, zone = place_blocks(thickness, zone_edge_bins)
    whole = np.isfinite(thickness).all(axis=2)
    rows = []
    for z, slab in np.ndindex(len(zone_edge_bins) - 1, mean.shape[1]):
        held = np.isfinite(mean[:, slab]) & (zone == z)
        if slab > 0 and held.sum() >= MINIMUM_BLOCKS:
            share = np.where(held, mean[:, slab] / level, np.nan)
            rows += _means_row(share, z, slab)
        held = whole[:, slab] & (zone == z)
        if held.sum() >= MINIMUM_BLOCKS:
            rows += _undulations_row(thickness[held, slab], z, slab, n_draws, rng)
    return rows


def _means_row(share, zone, slab):
    """The row of relative block means with NaN between; none where they do not differ."""
    values = share[np.isfinite(share)]
    if values.min() == values.max():
        return []
    n_effective = max(values.size * _independent_share(share), 4.0)
    _, p_value = lilliefors(values, n_effective)
    return [_row("relative block mean", zone, slab, values, n_effective, p_value)]


def _undulations_row(thickness, zone, slab, n_draws, rng):
    """The row of the lines of whole blocks (block, range_line); none where a block is level."""
    if not (thickness.std(axis=1) > 0).all():
        return []
    density = periodogram(thickness).mean(axis=0)
    n_effective = len(thickness) * 2 * density.sum() ** 2 / (density**2).sum()
    distance = _distance(np.sort(_standardised(thickness).ravel())[None])[0]
    n_larger = 0
    for _ in range(n_draws):
        normal = rng.standard_normal((2, len(thickness), density.size))
        gaussian = np.fft.irfft((normal[0] + 1j * normal[1]) * np.sqrt(density), thickness.shape[1])
        n_larger += _distance(np.sort(_standardised(gaussian).ravel())[None])[0] >= distance
    p_value = (n_larger + 1) / (n_draws + 1)
    return [_row("undulation", zone, slab, _standardised(thickness).ravel(), n_effective, p_value)]


def _standardised(thickness):
    """Thickness about the mean of its block over its s.d."""
    return (thickness - thickness.mean(axis=1, keepdims=True)) / thickness.std(axis=1, keepdims=True)


def _row(of, zone, slab, values, n_effective, p_value_correlated):
    distance, p_value = lilliefors(values)
    return {
        "of": of,
        "zone": zone,
        "slab": slab,
        "n": values.size,
        "n_effective": float(n_effective),
        "mean": values.mean(),
        "deviation": values.std(ddof=1),
        "distance": distance,
        "p_value": p_value,
        "p_value_correlated": float(p_value_correlated),
    }


def _independent_share(values):
    """Share of values, in the order of blocks with NaN between, that are worth an independent one."""
    anomaly = values - np.nanmean(values)
    pairs = anomaly[1:] * anomaly[:-1]
    held = np.isfinite(pairs)
    if held.sum() < MINIMUM_BLOCKS or not np.nanmax(np.abs(anomaly)) > 0:
        return 1.0
    correlation = np.clip(pairs[held].mean() / np.nanmean(anomaly**2), 0, 0.95)
    return (1 - correlation) / (1 + correlation)
