"""Speckle, eqs (3)-(4): power of complex Gaussian signal and noise, averaged over M looks."""

from functools import lru_cache

import numpy as np
from scipy.special import gammainc, gammaincinv

from snowsim.echogram import check_choice
from snowsim.limits import check_values
from snowsim.phy.correlated import draw_correlated, look_up

METHODS = ("looks", "gamma", "quantile")
MOST_LOOKS_QUANTILE = 1e6  # above, float32 no longer tells the cells apart
QUANTILES = 65536  # one for each value of 16 random bits


def draw_speckle(mean_power, n_looks, *, method="gamma", correlation=None, rng):
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
        correlation, or if no process of Gamma(M) has the correlation: the nearest one differs by
        more than 0.05.

    Notes
    -----
    A look of a pixel is exponential about its mean, being the squared modulus of a circular
    Gaussian; signal plus noise is circular Gaussian too, so one draw replaces both.

    - ``looks``: eqs (3)-(4) as printed, M pairs of normals.
    - ``gamma``: the mean of M such looks is Gamma(M) / M. Exact.
    - ``quantile``: 16 random bits choose one of 65536 equally likely cells of the exact
      distribution; each gives its own mean. The distribution function is within 1e-5 of exact up to
      1000 looks and within 4e-5 up to 1e6, the most it takes; the mean is exact; the largest value
      is that of the last cell. With a correlation, normals filtered down range go through a table
      of quantiles: as close.

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
    check_values("n_looks", n_looks, 1, number=True)
    check_method(method, n_looks, correlation)
    if mean_power.ndim != 2:
        msg = f"mean_power: expected (range_bin, range_line), got {mean_power.shape}"
        raise ValueError(msg)
    n_looks = float(n_looks)
    if method == "looks":
        return _draw_looks(mean_power, int(n_looks), rng)
    if correlation is not None:
        return draw_correlated(mean_power, n_looks, correlation, rng)
    if method == "quantile":
        cell = rng.integers(0, QUANTILES, size=mean_power.shape, dtype=np.uint16)
        mean_power = np.ascontiguousarray(mean_power)
        power = np.empty_like(mean_power)
        look_up(quantile_table(n_looks), cell, mean_power, power)
        return power
    return _draw_gamma(mean_power, n_looks, rng)


def check_method(method, n_looks, correlation=None):
    """ValueError unless `method` exists and can draw this number of looks, correlated if asked."""
    check_choice("speckle method", method, METHODS)
    if method == "looks" and n_looks != np.floor(n_looks):
        msg = f"speckle method looks needs a whole number of looks, got {n_looks:g}"
        raise ValueError(msg)
    if method == "quantile":
        check_values("n_looks of speckle method quantile", n_looks, 1, MOST_LOOKS_QUANTILE)
    if correlation is not None and method != "quantile":
        msg = f"speckle method {method} draws independent range bins, a correlation needs quantile"
        raise ValueError(msg)


@lru_cache(maxsize=8)
def quantile_table(n_looks):
    """Mean of each of 65536 equally likely cells of Gamma(M) / M, increasing, float32."""
    edges = gammaincinv(n_looks, np.arange(1, QUANTILES) / QUANTILES)
    # The mean over a cell is QUANTILES / M times the integral of x p(x; M) = M p(x; M + 1).
    below = np.concatenate([[0], gammainc(n_looks + 1, edges), [1]])
    table = (QUANTILES * np.diff(below)).astype(np.float32)
    table.flags.writeable = False
    return table


def _draw_looks(mean_power, n_looks, rng):
    """Mean of looks, one at a time."""
    total = np.zeros(mean_power.shape)
    for _ in range(n_looks):
        in_phase, quadrature = rng.standard_normal((2, *mean_power.shape))
        total += mean_power * (in_phase**2 + quadrature**2)
    return (total / (2 * n_looks)).astype(mean_power.dtype, copy=False)


def _draw_gamma(mean_power, n_looks, rng):
    """Gamma of shape M about the mean."""
    power = rng.standard_gamma(n_looks, size=mean_power.shape, dtype=mean_power.dtype)
    power *= mean_power
    power /= n_looks
    return power
