"""Speckle correlated down range: a filtered field of normals through quantiles of Gamma(M) / M."""

from functools import lru_cache

import numba
import numpy as np
from numpy.polynomial import hermite_e, polynomial
from scipy.special import factorial, gammainccinv, gammaincinv, ndtr, ndtri

from snowsim.limits import check_values

HALF_TAPS = 16  # range bins to either side that the filter reaches, and the most lags taken
LARGEST_ERROR = 0.05  # of the correlation at any lag; above, the correlation is refused
SMALLEST_TAP = 1e-6  # of the one in the middle; smaller ones at the ends are left out
N_FREQUENCIES = 513  # of the spectrum whose root is the filter
N_HERMITE = 40  # terms of the quantile function: the last are below 1e-15 of its variance
CELLS = 65536  # of normals that are drawn, one for each value of 16 random bits
# Of the table of quantiles, in deviations of the normal.
REACH = 8
PER_UNIT = 256


def draw_correlated(mean_power, n_looks, correlation, rng):
    """Power of Gamma(M) about `mean_power`, autocorrelated down range by `correlation (lag,)`.

    Where the mean is constant. One normal per pixel, see `draw_normals`, and one for each bin that
    the filter reaches beyond either end, so that speckle at the edges is like elsewhere. The
    distribution function is within 1e-5 of Gamma(M) / M up to 1000 looks.
    """
    taps, _ = correlating_taps(correlation, n_looks)
    n_range_bins, n_range_lines = mean_power.shape
    normals = draw_normals((n_range_bins + taps.size - 1, n_range_lines), rng)
    mean_power = np.ascontiguousarray(mean_power)
    power = np.empty_like(mean_power)
    filter_to_power(normals, taps.astype(np.float32), normal_quantiles(n_looks), mean_power, power)
    return power


def draw_normals(shape, rng):
    """Normals to be filtered, float32.

    16 random bits choose one of `CELLS` equally likely cells, each its own mean.
    """
    normals = np.empty(shape, dtype=np.float32)
    cells = rng.integers(0, CELLS, shape, dtype=np.uint16)
    no_factors = np.empty((0, 0), np.float32)
    look_up(_normal_cells(), cells, no_factors, normals)
    return normals


@lru_cache(maxsize=1)
def _normal_cells():
    """Mean of the normal law in each of its cells, scaled to unit variance, float32."""
    edges = ndtri(np.arange(1, CELLS) / CELLS)
    means = -np.diff(np.exp(-(edges**2) / 2), prepend=0, append=0)
    return (means / means.std()).astype(np.float32)


def correlating_taps(correlation, n_looks):
    """Filter for a correlation (lag,), see `_correlating_taps`: made once for all scenes."""
    asked = np.asarray(correlation, dtype=float)
    check_values("speckle correlation", asked, -1, 1)
    if asked.ndim != 1 or not 1 <= asked.size <= HALF_TAPS + 1 or asked[0] != 1:
        msg = f"speckle correlation must be 1 at lag 0 and known at {HALF_TAPS} or fewer lags "
        msg += f"more, got {asked.ravel()[:1]} and shape {asked.shape}"
        raise ValueError(msg)
    return _correlating_taps(tuple(asked), n_looks)


@lru_cache(maxsize=8)
def _correlating_taps(correlation, n_looks):
    """Filter of white normals, (tap,), for this autocorrelation of power, and its largest error.

    `correlation (lag,)` is that of Gamma(M) power of constant mean, from lag 0 on, and zero beyond
    its end. Normals of correlation r give power of correlation ``sum_n a_n^2 r^n / sum_n a_n^2``,
    ``a_n`` the Hermite coefficients of the quantile function (Mehler 1866, J. reine angew. Math.
    66, 161-176); this grows with r and is inverted. The filter is symmetric and its transform the
    root of the spectrum. An estimated correlation may have a partly negative spectrum, which no
    process has: that part is set to zero. ValueError if the correlation changes by over
    `LARGEST_ERROR`.
    """
    asked = np.array(correlation)
    shares = _hermite_shares(n_looks)
    grid = np.linspace(-1, 1, 4001)
    of_normals = np.interp(asked, polynomial.polyval(grid, shares), grid)
    frequency = np.pi * np.arange(N_FREQUENCIES) / (N_FREQUENCIES - 1)
    phase = frequency[:, None] * np.arange(1, asked.size)
    spectrum = 1 + 2 * np.cos(phase) @ of_normals[1:]
    half = np.fft.irfft(np.sqrt(np.maximum(spectrum, 0)))[: HALF_TAPS + 1]
    last = np.flatnonzero(np.abs(half) > SMALLEST_TAP * half[0])[-1]
    half = half[: last + 1]
    taps = np.concatenate([half[:0:-1], half])
    taps /= np.sqrt((taps**2).sum())
    given_to_normals = np.correlate(taps, taps, "full")[taps.size - 1 :]
    given = polynomial.polyval(given_to_normals, shares)
    n_lags = max(asked.size, given.size)
    asked = np.pad(asked, (0, n_lags - asked.size))
    given = np.pad(given, (0, n_lags - given.size))
    error = np.abs(given - asked)
    lag = int(error.argmax())
    if error[lag] > LARGEST_ERROR:
        msg = f"speckle correlation {asked[lag]:.3g} at lag {lag} is not possible: "
        msg += f"the nearest is {given[lag]:.3g}"
        raise ValueError(msg)
    taps.flags.writeable = False
    return taps, float(error[lag])


@lru_cache(maxsize=8)
def _hermite_shares(n_looks):
    """Share of Gamma(M)'s variance in each Hermite polynomial of the normal behind it, (term,)."""
    node, weight = hermite_e.hermegauss(100)
    norm = np.sqrt(factorial(np.arange(N_HERMITE + 1)))
    scaled = hermite_e.hermevander(node, N_HERMITE) / norm
    squares = ((weight * _quantile(node, n_looks)) @ scaled) ** 2
    squares[0] = 0
    return squares / squares.sum()


@lru_cache(maxsize=8)
def normal_quantiles(n_looks):
    """Quantile of Gamma(M) / M at evenly spaced normals from -`REACH` to `REACH`, float32.

    Linear between them: with steps h the distribution function is off by less than 0.04 h^2 = 6e-7.
    """
    n_steps = REACH * PER_UNIT
    normal = np.arange(-n_steps, n_steps + 1) / PER_UNIT
    table = _quantile(normal, n_looks).astype(np.float32)
    table.flags.writeable = False
    return table


def _quantile(normal, n_looks):
    """Quantile of Gamma(M) / M at the probability of a normal, exact in both tails."""
    below = gammaincinv(n_looks, ndtr(np.minimum(normal, 0)))
    above = gammainccinv(n_looks, ndtr(-np.maximum(normal, 0)))
    return np.where(normal < 0, below, above) / n_looks


@numba.njit(cache=True, nogil=True)
def look_up(table, cells, factors, values):
    """Fill `values`, (row, line), with those in a table that `cells` number, times any factors."""
    n_rows, n_lines = cells.shape
    for row in range(n_rows):
        if factors.size == 0:
            for line in range(n_lines):
                values[row, line] = table[cells[row, line]]
        else:
            for line in range(n_lines):
                values[row, line] = table[cells[row, line]] * factors[row, line]


@numba.njit(cache=True, nogil=True)
def filter_to_power(normals, taps, table, mean_power, power):
    """Filter normals down range, look each up in the table of quantiles, scale by the mean."""
    n_range_bins, n_range_lines = mean_power.shape
    first = np.float32(table.size // 2)
    per_unit = np.float32(PER_UNIT)
    zero = np.float32(0)
    last = np.float32(table.size - 2)
    field = np.empty(n_range_lines, dtype=np.float32)
    for row in range(n_range_bins):
        field[:] = zero
        for tap in range(taps.size):
            for line in range(n_range_lines):
                field[line] += taps[tap] * normals[row + tap, line]
        for line in range(n_range_lines):
            at = min(max(field[line] * per_unit + first, zero), last)
            cell = np.int32(at)
            quantile = table[cell] + (at - np.float32(cell)) * (table[cell + 1] - table[cell])
            power[row, line] = mean_power[row, line] * quantile
