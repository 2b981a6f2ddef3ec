"""Sweep of the number of looks: quantiles that were drawn against those of the exact law."""

import numpy as np
from scipy.special import gammaincinv
from scipy.stats import gamma

from snowsim.phy.speckle import draw_speckle
from snowsim.phy.stress.judge import outcome, row

LEVELS = np.array([0.01, 0.1, 0.5, 0.9, 0.99])
SHAPE = (512, 512)
MOST_LOOKS_SUMMED = 20  # more take seconds
LAW_LIMIT_DB = 0.05
VALUES = (0.5, 1, 1.5, 2, 4, 9, 10, 16, 20, 100, 1e3, 1e4, 1e5, 1e6, 1e7, 1e9)


def sweep_looks(*, rng):
    """Number of looks: from one, where laws are most skewed, to where float32 no longer tells values apart.

    A quantile is within when it is off by at most 0.05 dB and five standard errors of its 262,144 draws. `cube_open` is
    the cube without the floor of 10 looks that `draw_speckle` holds it to.
    """
    rows = []
    for n_looks in VALUES:
        for method in ("looks", "gamma", "cube", "quantile", "cube_open"):
            if method == "looks" and n_looks > MOST_LOOKS_SUMMED:
                continue
            rows.append(row("looks M", n_looks, method, _verdict(method, n_looks, rng)))
    return rows


def _verdict(method, n_looks, rng):
    exact = gammaincinv(n_looks, LEVELS) / n_looks
    density = gamma.pdf(exact, n_looks, scale=1 / n_looks)
    standard_error = np.sqrt(LEVELS * (1 - LEVELS) / np.prod(SHAPE)) / (density * exact)
    limit_db = LAW_LIMIT_DB + 10 * np.log10(1 + 5 * standard_error)
    try:
        drawn = _cube_open(n_looks, rng) if method == "cube_open" else _public(method, n_looks, rng)
    except ValueError:
        return np.nan, float(limit_db.max()), "refused"
    quantiles = np.quantile(drawn, LEVELS)
    if np.any(quantiles <= 0):
        return np.inf, float(limit_db.max()), "wrong"
    error_db = np.abs(10 * np.log10(quantiles / exact))
    worst = np.argmax(error_db / limit_db)
    return error_db[worst], float(limit_db[worst]), outcome(error_db[worst], limit_db[worst])


def _public(method, n_looks, rng):
    return draw_speckle(np.ones(SHAPE, dtype=np.float32), n_looks, method=method, rng=rng)


def _cube_open(n_looks, rng):
    return (1 - 1 / (9 * n_looks) + rng.standard_normal(SHAPE) / (3 * np.sqrt(n_looks))) ** 3
