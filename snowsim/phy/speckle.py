"""Speckle, eqs (3)-(4): power of complex Gaussian signal and noise, averaged over M looks."""

from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import gammainccinv, gammaincinv, ndtr, ndtri

from snowsim.compiling import compiled
from snowsim.echogram import check_choice
from snowsim.limits import check_values

METHODS = ("looks", "gamma", "quantile")
MOST_LOOKS_QUANTILE = 1e6  # with more looks the quantiles are equal in float32
MOST_LAGS = 16  # of a correlation, beside lag 0
LARGEST_ERROR = 0.05  # largest error of the correlation at any lag; else it is refused
# Least density of a spectrum of mean 1. Estimated spectra may be negative, those of processes not.
LEAST_DENSITY = 1e-3
N_FREQUENCIES = 1024
LEAST_TAP = 1e-3  # smaller taps at the end of a filter are left out
CELLS = 65536  # values that a normal is drawn from, one for each value of 16 random bits
QUANTILE_REACH = 8  # half the width of the table of quantiles, in deviations of the normal
PER_UNIT = 256  # values of that table in a deviation


def draw_speckle(
    mean_power: ArrayLike,
    n_looks: float,
    *,
    method: str = "gamma",
    correlation: ArrayLike | None = None,
    rng: int | np.random.Generator,
) -> NDArray[np.floating]:
    """Power after averaging M looks.

    Parameters
    ----------
    mean_power : array_like, (range_bin, range_line)
        Mean power of signal and noise together, not negative.
    n_looks : float
        Independent looks averaged, at least 1; whole for `looks`.
    method : {"looks", "gamma", "quantile"}
        See Notes.
    correlation : array_like, (lag,), optional
        Autocorrelation of power down range where its mean is constant, 1 at lag 0 and zero beyond
        the last; only for `quantile`. None: range bins are independent. Range lines always are.
    rng : numpy.random.Generator

    Returns
    -------
    ndarray, (range_bin, range_line)
        float32 for float32 means, else float64.

    Raises
    ------
    ValueError
        If a mean is negative or not finite, if the method is unknown or cannot draw the looks or
        correlation, or if no short filter gives the correlation: the nearest one differs by more
        than 0.05.

    Notes
    -----
    A look of a pixel is exponential about its mean, being the squared modulus of a circular
    Gaussian; signal plus noise is circular Gaussian too, so one draw replaces both.

    - ``looks``: eqs (3)-(4) as printed, M pairs of normals.
    - ``gamma``: the mean of M such looks is Gamma(M) / M. Exact.
    - ``quantile``: one normal for each pixel, chosen by 16 random bits and filtered down range if
      there is a correlation, goes through a table of quantiles of Gamma(M) / M. The distribution
      function is within 1e-5 of exact up to 1000 looks and within 4e-5 up to 1e6, the most it
      takes.

    Examples
    --------
    >>> power = draw_speckle(np.full((200, 200), 3.0), 16, rng=np.random.default_rng(1))
    >>> float(power.mean().round(1))
    3.0
    >>> float((power.mean() ** 2 / power.var()).round())  # looks
    16.0
    """
    mean_power = np.asarray(mean_power)
    if mean_power.dtype != np.float32:
        mean_power = mean_power.astype(float)
    check_values("mean_power", mean_power, 0)
    check_looks(method, n_looks, correlation)
    return draw_unchecked(mean_power, n_looks, method=method, correlation=correlation, rng=rng)


def draw_unchecked(mean_power, n_looks, *, method, correlation, rng):
    """Power after M looks, as from `draw_speckle`, of arguments that are checked already."""
    n_looks = float(n_looks)
    if method == "looks":
        return _draw_looks(mean_power, int(n_looks), rng)
    if method == "quantile":
        return _draw_quantiles(mean_power, n_looks, correlation, rng)
    power = rng.standard_gamma(n_looks, size=mean_power.shape, dtype=mean_power.dtype)
    power *= mean_power
    power /= n_looks
    return power


def check_looks(method, n_looks, correlation=None):
    """Raise ValueError unless `method` exists and can draw these looks with this correlation."""
    check_choice("speckle method", method, METHODS)
    most = MOST_LOOKS_QUANTILE if method == "quantile" else np.inf
    check_values(f"n_looks of speckle method {method}", n_looks, 1, most, number=True)
    if method == "looks" and n_looks != np.floor(n_looks):
        msg = f"speckle method looks needs a whole number of looks, got {n_looks:g}"
        raise ValueError(msg)
    if correlation is None:
        return
    if method != "quantile":
        msg = f"speckle method {method} draws independent range bins, a correlation needs quantile"
        raise ValueError(msg)
    correlating_taps(correlation, n_looks)


def _draw_looks(mean_power, n_looks, rng):
    """Mean of M looks, drawn one after the other."""
    total = np.zeros(mean_power.shape)
    for _ in range(n_looks):
        in_phase, quadrature = rng.standard_normal((2, *mean_power.shape))
        total += mean_power * (in_phase**2 + quadrature**2)
    return (total / (2 * n_looks)).astype(mean_power.dtype, copy=False)


def _draw_quantiles(mean_power, n_looks, correlation, rng):
    """Quantiles of speckle at normals that are filtered down range.

    The filter starts above the first range bin, so that speckle there is the same as elsewhere.
    """
    taps = np.ones(1) if correlation is None else correlating_taps(correlation, n_looks)
    n_range_bins, n_range_lines = mean_power.shape
    shape = (n_range_bins + taps.size - 1, n_range_lines)
    cells = rng.integers(0, CELLS, shape, dtype=np.uint16)
    power = np.empty(mean_power.shape, mean_power.dtype)
    filter_to_power(
        cells,
        normal_cells(),
        taps.astype(np.float32),
        normal_quantiles(n_looks),
        np.ascontiguousarray(mean_power),
        power,
    )
    return power


@lru_cache(maxsize=1)
def normal_cells():
    """Mean of a standard normal in each of `CELLS` equally likely cells, scaled to variance 1."""
    edges = ndtri(np.arange(1, CELLS) / CELLS)
    means = -np.diff(np.exp(-(edges**2) / 2), prepend=0, append=0)
    return (means / means.std()).astype(np.float32)


@lru_cache(maxsize=8)
def normal_quantiles(n_looks):
    """Quantiles of Gamma(M) / M at evenly spaced normals up to +-`QUANTILE_REACH`, float32.

    Interpolated linearly between steps h, the distribution function errs by less than 0.04 h^2,
    which is 6e-7.
    """
    normal = np.arange(-QUANTILE_REACH * PER_UNIT, QUANTILE_REACH * PER_UNIT + 1) / PER_UNIT
    below = gammaincinv(n_looks, ndtr(np.minimum(normal, 0)))
    above = gammainccinv(n_looks, ndtr(-np.maximum(normal, 0)))
    return (np.where(normal < 0, below, above) / n_looks).astype(np.float32)


def correlating_taps(correlation, n_looks):
    """Filter of white normals, (tap,), that gives power of this autocorrelation down range.

    The power is what `normal_quantiles` makes of the filtered normals. ValueError if its
    autocorrelation differs from the one asked for by more than `LARGEST_ERROR`.
    """
    asked = np.asarray(correlation, dtype=float)
    is_row = asked.ndim == 1 and 1 <= asked.size <= MOST_LAGS + 1
    if not is_row or asked[0] != 1 or not (np.abs(asked) <= 1).all():
        msg = f"speckle correlation must be 1 at lag 0 and within 1 at {MOST_LAGS} lags or fewer, "
        msg += f"got {asked.tolist()}"
        raise ValueError(msg)
    asked = np.pad(asked, (0, MOST_LAGS + 1 - asked.size))
    taps, given = _correlating_taps(tuple(asked), float(n_looks))
    lag = int(np.abs(given - asked).argmax())
    if abs(given[lag] - asked[lag]) > LARGEST_ERROR:
        msg = f"speckle correlation {asked[lag]:.3g} at lag {lag} is not possible: "
        msg += f"the nearest is {given[lag]:.3g}"
        raise ValueError(msg)
    return taps


@lru_cache(maxsize=8)
def _correlating_taps(correlation, n_looks):
    """The filter, (tap,), and the autocorrelation of power that it gives, (lag,).

    Normals of correlation r give power of correlation ``(r + c r^2) / (1 + c)``, c = 2 / 9M: the
    first two terms of Mehler (1866), J. reine angew. Math. 66, 161-176, for the quantile function
    of Wilson & Hilferty (1931), PNAS 17, 684-688; others are below 0.005 even of one look. The
    filter is the causal one of minimum phase, by the cepstrum (Oppenheim & Schafer, Discrete-Time
    Signal Processing). It has as many taps as there are lags, and more only where the correlation
    asked for has a negative spectrum.
    """
    second = 2 / (9 * n_looks)
    asked = np.array(correlation)
    root = np.sqrt(np.maximum(1 + 4 * second * (1 + second) * asked, 0))
    of_normals = (root - 1) / (2 * second)
    density = np.fft.hfft(of_normals, N_FREQUENCIES)
    cepstrum = np.fft.ifft(np.log(np.maximum(density, LEAST_DENSITY))).real / 2
    cepstrum[1 : N_FREQUENCIES // 2] *= 2
    cepstrum[N_FREQUENCIES // 2 + 1 :] = 0
    taps = np.fft.ifft(np.exp(np.fft.fft(cepstrum))).real[: asked.size]
    taps = taps[: np.flatnonzero(np.abs(taps) > LEAST_TAP)[-1] + 1]
    taps /= np.sqrt((taps**2).sum())
    given = np.correlate(taps, taps, "full")[taps.size - 1 :]
    given = np.pad(given, (0, asked.size - taps.size))
    return taps, (given + second * given**2) / (1 + second)


@compiled(nogil=True)
def filter_to_power(cells, normals, taps, quantiles, mean_power, power):
    """Filter the normals of `cells` down range, look each up in `quantiles`, scale by the mean."""
    n_range_bins, n_range_lines = mean_power.shape
    first = np.float32(quantiles.size // 2)
    per_unit = np.float32(PER_UNIT)
    last = np.float32(quantiles.size - 2)
    n_taps = taps.size
    # A ring of the last rows, as many as the filter has taps.
    rows = np.empty((n_taps, n_range_lines), dtype=np.float32)
    field = np.empty(n_range_lines, dtype=np.float32)
    for row in range(cells.shape[0]):
        newest = rows[row % n_taps]
        for line in range(n_range_lines):
            newest[line] = normals[cells[row, line]]
        out = row - n_taps + 1
        if out < 0:
            continue
        field[:] = np.float32(0)
        for tap in range(n_taps):
            reached = rows[(row - tap) % n_taps]
            for line in range(n_range_lines):
                field[line] += taps[tap] * reached[line]
        for line in range(n_range_lines):
            at = min(max(field[line] * per_unit + first, np.float32(0)), last)
            cell = np.int32(at)
            step = quantiles[cell + 1] - quantiles[cell]
            quantile = quantiles[cell] + (at - np.float32(cell)) * step
            power[out, line] = mean_power[out, line] * quantile
