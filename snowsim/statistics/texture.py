"""Gain from line to line, and the texture of unpicked snow: covariance of neighbouring lines."""

import numpy as np
from scipy.optimize import least_squares

DB = 10 / np.log(10)
LINE_LAGS = np.array(
    [1, 2, 9]
)  # [range lines]; at the last, lines share only the error of the group's mean
BIN_LAGS = np.array([0, 4, 8, 16])  # [range bins]
MARGIN_BINS, MOST_BINS, FEWEST_BINS = (
    30,
    150,
    80,
)  # below the deepest pick of a group, where its texture is measured
CLEAR = 3.0  # times the noise, or the noise hides the texture
OVERLOADED = 6.0  # robust standard deviations above which a line is overloaded
N_TERMS = 2 + (LINE_LAGS.size + 1) * BIN_LAGS.size
FEWEST_GROUPS = 20  # needed to estimate either
NAMES = ("line_gain_spread_db", "texture_variance", "texture_length_bins", "texture_length_lines")


def texture_terms(power, air_end, deepest_row):
    """Sums of one flight frame for `texture`, float64 (group, N_TERMS), zeros where a group is of no use.

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
        halves = np.array(
            [half.mean(axis=1) for half in (air[:, : n_air // 2], air[:, n_air // 2 :])]
        )
        if not (halves > 0).all():  # padding, or a missing line
            continue
        terms[group, :2] = _covariance(np.log(halves))
        first = int(deepest_row[group].max()) + MARGIN_BINS
        below = lines[:, first : first + MOST_BINS].astype(float)
        mean = below.mean(axis=0)
        snow = mean - air.mean()
        if (
            below.shape[1] < FEWEST_BINS
            or not (below > 0).all()
            or snow.mean() < CLEAR * air.mean()
        ):
            continue
        deviation = below - mean
        pairs = [(deviation[:-h], deviation[h:]) for h in LINE_LAGS] + [(snow[None], snow[None])]
        products = [
            [(a[:, : a.shape[1] - k] * b[:, k:]).sum() / len(a) for k in BIN_LAGS] for a, b in pairs
        ]
        terms[group, 2:] = np.ravel(products)
    return terms


def _covariance(halves):
    """Covariance of two rows (2, line) without the lines far from their median, and 1; two zeros if few are left."""
    both = halves.mean(axis=0) - np.median(halves)
    near = np.abs(both) <= OVERLOADED * 1.4826 * np.median(np.abs(both))
    return (np.cov(halves[:, near])[0, 1], 1.0) if 2 * near.sum() > near.size else (0.0, 0.0)


def texture(terms):
    """Values of `NAMES` from sums (group, N_TERMS); NaN where the flight is too short.

    Texture is a factor on power of mean 1 and covariance ``v exp(-k / a) exp(-(h / b)^2)`` at k
    range bins and h lines. Speckle is independent from line to line; subtracting the group's mean
    changes products equally at all lags along track, so the last lag is subtracted from the others.
    """
    n = terms[:, 1].sum()
    gain_db = DB * np.sqrt(max(terms[:, 0].sum() / n, 0)) if n >= FEWEST_GROUPS else np.nan
    products = terms[:, 2:].sum(axis=0).reshape(LINE_LAGS.size + 1, BIN_LAGS.size)
    if (terms[:, -1] != 0).sum() < FEWEST_GROUPS:
        return np.array([gain_db, np.nan, np.nan, np.nan])
    ratio = products[:-1] / products[-1]
    seen = ratio[:-1] - ratio[-1]
    if seen[0, 0] <= 0:
        return np.array([gain_db, 0.0, 1.0, 1.0])

    def misfit(logarithms):
        variance, bins, lines = np.exp(logarithms)
        along = np.exp(-((LINE_LAGS / lines) ** 2))
        return (
            (along[:-1] - along[-1])[:, None] * variance * np.exp(-BIN_LAGS / bins) - seen
        ).ravel() / seen[0, 0]

    bounds = np.log([[1e-5, 1.0, 0.5], [1.0, 200.0, 5.0]])
    first = np.clip(np.log([1.3 * seen[0, 0], 10.0, 2.0]), *bounds)
    return np.append(gain_db, np.exp(least_squares(misfit, first, bounds=bounds).x))
