"""Gain from line to line, and the texture of unpicked snow: covariance of neighbouring lines."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from snowsim.statistics.moments import DB, TO_THE_LAST_DIGITS

# [range lines]; at the last, lines share only the error of the group's mean.
LINE_LAGS = np.array([1, 2, 9])
BIN_LAGS = np.array([0, 4, 8, 16])  # [range bins]
MARGIN_BINS = 30  # below the deepest pick of a group, where its texture is measured
MOST_BINS = 150
FEWEST_BINS = 80
CLEAR = 3.0  # times the noise, or the noise hides the texture
OVERLOADED = 6.0  # robust standard deviations above which a line is overloaded
NORMAL_MAD = 1.4826  # standard deviation of a normal law over its median absolute deviation
N_TERMS = 2 + (LINE_LAGS.size + 1) * BIN_LAGS.size
FEWEST_GROUPS = 20  # needed to estimate either


@dataclass(frozen=True)
class Texture:
    """Gain from line to line and texture of unpicked snow; by default there is neither."""

    line_gain_spread_db: float = 0.0
    texture_variance: float = 0.0
    texture_length_bins: float = 1.0
    texture_length_lines: float = 1.0


def texture_terms(power, air_end, deepest_row):
    """Sums of one flight frame for `texture`, (group, N_TERMS), zeros where a group is of no use.

    From power (group, range_line, range_bin) and, for each line (group, range_line), the row where
    its air ends and the row of its deepest pick. For gain: covariance along track of the logarithm
    of mean air power in two halves of the air, and a count. For texture, below the deepest pick:
    products of deviations from the row's mean in the group, by lag along track and down range, then
    products of that mean less noise, by lag down range.
    """
    terms = np.zeros((len(power), N_TERMS))
    for group, lines in enumerate(power):
        n_air = int(air_end[group].min())
        if n_air < 2:
            continue
        air = lines[:, :n_air].astype(float)
        upper = air[:, : n_air // 2].mean(axis=1)
        lower = air[:, n_air // 2 :].mean(axis=1)
        halves = np.array([upper, lower])
        if not (halves > 0).all():  # padding, or a missing line
            continue
        terms[group, :2] = _covariance(np.log(halves))
        first = int(deepest_row[group].max()) + MARGIN_BINS
        below = lines[:, first : first + MOST_BINS].astype(float)
        terms[group, 2:] = _products(below, air.mean())
    return terms


def _covariance(halves):
    """Covariance of two rows (2, line) without the lines far from their median, and 1.

    They are two zeros if few lines are left.
    """
    both = halves.mean(axis=0) - np.median(halves)
    near = np.abs(both) <= OVERLOADED * NORMAL_MAD * np.median(np.abs(both))
    if 2 * near.sum() <= near.size:
        return 0.0, 0.0
    return np.cov(halves[:, near])[0, 1], 1.0


def _products(below, noise):
    """Products of the snow's texture and of its mean power, see `texture_terms`.

    They are 0 where noise hides it.
    """
    n_bins = below.shape[1]
    if n_bins < FEWEST_BINS or not (below > 0).all():
        return 0.0
    mean = below.mean(axis=0)
    snow = mean - noise
    if snow.mean() < CLEAR * noise:
        return 0.0
    deviation = below - mean
    pairs = [(deviation[:-lag], deviation[lag:]) for lag in LINE_LAGS]
    pairs.append((snow[None], snow[None]))
    products = []
    for here, there in pairs:
        for lag in BIN_LAGS:
            product = here[:, : n_bins - lag] * there[:, lag:]
            products.append(product.sum() / len(here))
    return products


def texture(terms):
    """`Texture` from sums (group, N_TERMS); NaN where the flight is too short.

    Texture is a factor on power of mean 1 and covariance ``v exp(-k / a) exp(-(h / b)^2)`` at k
    range bins and h lines. Speckle is independent from line to line; subtracting the group's mean
    changes products equally at all lags along track, so the last lag is subtracted from the others.
    """
    gain_db = np.nan
    n_gains = terms[:, 1].sum()
    if n_gains >= FEWEST_GROUPS:
        covariance = terms[:, 0].sum() / n_gains
        gain_db = DB * np.sqrt(max(covariance, 0))
    if (terms[:, -1] != 0).sum() < FEWEST_GROUPS:
        return Texture(gain_db, np.nan, np.nan, np.nan)
    products = terms[:, 2:].sum(axis=0).reshape(LINE_LAGS.size + 1, BIN_LAGS.size)
    ratio = products[:-1] / products[-1]
    seen = ratio[:-1] - ratio[-1]
    if seen[0, 0] <= 0:
        return Texture(gain_db)

    def misfit(logarithms):
        variance, bins, lines = np.exp(logarithms)
        along = np.exp(-((LINE_LAGS / lines) ** 2))
        beyond_last = along[:-1] - along[-1]
        expected = beyond_last[:, None] * variance * np.exp(-BIN_LAGS / bins)
        return (expected - seen).ravel() / seen[0, 0]

    bounds = np.log([[1e-5, 1.0, 0.5], [1.0, 200.0, 5.0]])
    first = np.clip(np.log([1.3 * seen[0, 0], 10.0, 2.0]), *bounds)
    fit = least_squares(misfit, first, bounds=bounds, **TO_THE_LAST_DIGITS)
    return Texture(gain_db, *np.exp(fit.x))
