"""Years between picked layers: the exact posterior of a hidden sequence of horizons and crusts.

Each pick is an autumn horizon or none. Between two horizons lie one or more years, above the first
one an open part of a year and perhaps horizons that nobody picked. Sums over all such sequences, by
a forward and a backward recursion over picks (Rabiner 1989, Proc. IEEE 77, 257-286) with ages as
second index, give the probability of every age of every pick. What is unknown of the place, the
mass of a typical year, its scatter, the share of horizons missed and the rate of crusts, is
integrated over grids.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.special import ndtr

N_MASSES = 48  # of a typical year, in steps of some 5 %
# Least and largest typical mass over the median span: below, most horizons are missing, above, most
# picks are none.
SPAN_SHARES = (0.3, 2.5)
MOST_SKIPPED = 6  # picks of no horizon one after another, unless named layers ask for more
IMPROBABLE = 1e-4  # of the most probable point of a grid: others are left out
FAINT = -45.0  # logarithm of the probability of a step, below which it is not followed


@dataclass(frozen=True)
class Rates:
    """What is unknown of picks: grids, whose values are equally likely beforehand.

    Cores scatter by .13 to .31 from year to year. The grid of scatter is a compromise, on the
    tuning seeds of `benchmarks/bench_years.py` and every other core, between a low Brier score and
    .4 of dates surer than .8; other grids were about as good.

    Attributes
    ----------
    scatter : tuple of float
        Standard deviation of the logarithm of a year's mass.
    missed : tuple of float
        Share of horizons without a pick.
    crusts : tuple of float
        Picks a year that are no horizon.
    hidden : float
        Odds of one more horizon above the first pick, in the tail of the surface's echo.
    """

    scatter: tuple = (0.2, 0.25)
    missed: tuple = (0.03, 0.1, 0.3)
    crusts: tuple = (0.01, 0.05, 0.2)
    hidden: float = 0.9


TRACKED = Rates()
# Of a person who says that every layer is a year: below .1 of years of 23 cores get a flag.
ANNUAL = Rates(scatter=(0.25,), missed=(0.002,), crusts=(0.002,), hidden=0.01)
# Share of spans over which the echo is lost, assumed: it dates a gap of twenty years. Of n > 1
# years, of no typical number, as often as 1 /
# (n (n - 1)).
LOST = 0.02
NAMED = 0.5  # scatter of a mass between two named layers: names are refused from a factor of 4 on
OPEN_YEARS = 0.1  # by which the date of an autumn horizon scatters: some five weeks, assumed
# Standard deviation of distances between layers that no range line shares, in typical years: that
# of
# a year's mass; and the probability that such two, one after the other, are one horizon, for which
# nothing speaks beforehand.
APART_YEARS = 0.2
ONE_HORIZON = 0.5


@dataclass(frozen=True, eq=False)
class Series:
    """Picks of a track as one series, downwards.

    Attributes
    ----------
    above_m : ndarray, (pick,)
        Mass of the snow above [m w.e.].
    span_m : ndarray, (pick, pick)
        Mass from one pick down to another.
    error_m : ndarray, (pick,)
        Standard deviation of the mass above.
    apart : ndarray of bool, (pick, pick)
        Whether no range line has both.
    confidence : ndarray, (pick,)
        Probability that a layer lies at the pick.
    elapsed : float
        Share of the snow year that has elapsed.
    known : dict of int to int
        Ages of picks, in years before the last autumn.
    apart_m : float
        Mass between the nearest layers that the tracker separates.
    """

    above_m: np.ndarray
    span_m: np.ndarray
    error_m: np.ndarray
    apart: np.ndarray
    confidence: np.ndarray
    elapsed: float
    known: dict
    apart_m: float = 0.0


@dataclass(frozen=True, eq=False)
class Posterior:
    """What picks tell of ages.

    Attributes
    ----------
    age : ndarray, (pick, age)
        Probability that a pick is the horizon of so many years before the last autumn.
    spans : list of tuple
        (upper, lower, years, probability) of two horizons without another between them; upper is -1
        for the surface, and years then hold the open one.
    mass_m, weight : ndarray, (point,)
        Mass of a typical year [m w.e.], and its probability.
    scatter : float
        Mean standard deviation of the logarithm of a year's mass.
    """

    age: np.ndarray
    spans: list
    mass_m: np.ndarray
    weight: np.ndarray
    scatter: float

    @property
    def typical_m(self):
        """Median mass of a typical year [m w.e.]."""
        return quantile(self.mass_m, self.weight, 0.5)

    @property
    def mass_error(self):
        """Standard deviation of the logarithm of that mass."""
        log = np.log(self.mass_m)
        mean = self.weight @ log / self.weight.sum()
        return float(np.sqrt(self.weight @ (log - mean) ** 2 / self.weight.sum()))

    def below(self, mass_m):
        """Probability that a typical year has less mass [m w.e.]."""
        return float(self.weight[self.mass_m < mass_m].sum())

    @property
    def flat_m(self):
        """The same by picks alone, without what was expected."""
        return quantile(self.mass_m, self.weight / self.prior, 0.5)


@dataclass(frozen=True, eq=False)
class _Grid:
    """One value of each for every combination of what is unknown, and its weight, (point,).

    Masses are in units of `unit_m`, the median span, so that densities are near 1.
    """

    unit_m: float
    mass: np.ndarray
    scatter: np.ndarray
    missed: np.ndarray
    crusts: np.ndarray
    weight: np.ndarray

    def at(self, kept):
        """Some of its points."""
        arrays = ("mass", "scatter", "missed", "crusts", "weight")
        return replace(self, **{name: getattr(self, name)[kept] for name in arrays})


def posterior(series, rates=TRACKED, expected_m=None, expected_error=0.3):
    """`Posterior` of a `Series`; ValueError where no sequence has the known ages.

    With n years and mass w between two horizons, m the mass of a typical year and s its scatter::

        log P = sum over horizons of [lognormal(w | n m, s / sqrt(n)) + (n - 1) log(missed)
                + log(1 - missed) + log(confidence)]
                + sum over picks that are none of log(crusts / m) - crusts * years

    A small share of spans lacks picks over any number of years. The first span has the mean mass
    (elapsed + hidden) m, unless a layer is of known age. `expected_m` is the median of a lognormal
    prior of m, of scatter `expected_error`; without it m is flat in its logarithm.
    """
    grid = _grid(series, rates, expected_m, expected_error)
    # Ages that the first pick may have are few where it is known.
    offset = series.known.get(0, 0)
    known = {pick: age - offset for pick, age in series.known.items()}
    opened = _opened(series, grid, rates, known)
    steps = _steps(series, grid, known, opened.shape[1])
    ends = _ends(series, grid, known)
    if not known:  # most of the grid is improbable, which sums over ages show at less cost
        kept = _probable(opened, steps, ends)
        grid = grid.at(kept)
        n_ages = _n_ages(series, grid, known)
        opened, ends = opened[:, :n_ages, kept], ends[:, kept]
        steps = _at(steps, n_ages, kept)
    forward, of_forward = _forward(opened, steps, known)
    backward, of_backward = _backward(ends, steps, known, forward.shape[1])
    last = np.einsum("kag,kg->k", forward, ends)
    with np.errstate(divide="ignore"):
        total = np.logaddexp.reduce(of_forward + np.log(last))
    if not np.isfinite(total):
        msg = "year: no number of years between the named layers fits the layers between them"
        raise ValueError(msg)
    scale = np.exp(of_forward + of_backward - total)
    age = scale[:, None] * np.einsum("kag,kag->ka", forward, backward)
    weight = np.einsum("k,kag,kg->g", np.exp(of_forward - total), forward, ends)
    # By pick and age, of the first horizon.
    begun = np.einsum("kag,kag->ka", opened, backward) * np.exp(of_backward - total)[:, None]
    spans = [
        (-1, pick, series.elapsed + offset + years, probability)
        for (pick, years), probability in np.ndenumerate(begun)
        if probability > 0
    ]
    for (upper, lower), (years, of_years) in steps.items():
        both = np.exp(of_forward[upper] + of_backward[lower] - total)
        for n, own in zip(years, of_years, strict=True):
            sums = np.einsum("ag,ag->g", forward[upper, : age.shape[1] - n], backward[lower, n:])
            spans.append((upper, lower, int(n), both * (sums @ own)))
    age = np.pad(age, [(0, 0), (offset, 0)])
    return Posterior(age, spans, grid.mass * grid.unit_m, weight, float(weight @ grid.scatter))


def _grid(series, rates, expected_m, expected_error):
    """`_Grid` over masses of a typical year and over rates."""
    spans_m = np.where(np.triu(~series.apart, 1), series.span_m, np.inf).min(axis=1)
    near = np.isfinite(spans_m)
    unit_m = float(np.median(spans_m[near] if near.any() else series.above_m))
    low, high = SPAN_SHARES
    if expected_m is not None:
        low = min(low, expected_m / unit_m * np.exp(-2 * expected_error))
        high = max(high, expected_m / unit_m * np.exp(2 * expected_error))
    masses = np.geomspace(low, high, N_MASSES)
    values = np.meshgrid(masses, rates.scatter, rates.missed, rates.crusts, indexing="ij")
    mass, scatter, missed, crusts = (value.ravel() for value in values)
    # Of years that are thinner than what the tracker separates, one of two is missed.
    off = np.log(mass * unit_m / max(series.apart_m, 1e-9)) / scatter
    missed = 1 - (1 - missed) * np.clip(ndtr(off), 0.01, 1)
    weight = np.ones(mass.size)
    if expected_m is not None:
        weight = np.exp(-(np.log(mass * unit_m / expected_m) ** 2) / (2 * expected_error**2))
    return _Grid(unit_m, mass, scatter, missed, crusts, weight / weight.sum())


def _at(steps, n_ages, kept):
    """Steps of fewer than `n_ages` years, at some points of the grid."""
    return {
        pair: (years[years < n_ages], of_years[years < n_ages][:, kept])
        for pair, (years, of_years) in steps.items()
    }


def _probable(opened, steps, ends):
    """Whether points of the grid are not `IMPROBABLE`, bool (point,), by sums over all ages."""
    with np.errstate(divide="ignore"):
        log = np.log(opened.sum(axis=1))
        log_sum = log[0] + np.log(ends[0])
        for lower in range(1, len(log)):
            for upper in range(lower):
                if (upper, lower) in steps:
                    step = np.log(steps[upper, lower][1].sum(axis=0))
                    log[lower] = np.logaddexp(log[lower], log[upper] + step)
            log_sum = np.logaddexp(log_sum, log[lower] + np.log(ends[lower]))
    return log_sum > log_sum.max() + np.log(IMPROBABLE)


def _n_ages(series, grid, known):
    """Number of ages that the deepest pick may have."""
    deepest = series.above_m[-1] / grid.unit_m / grid.mass.min()
    return 2 + int(1.1 * max([deepest, *known.values()]))


def _lognormal(ratio, variance):
    """Log-density of the logarithm of a mass over its median."""
    return -(np.log(ratio) ** 2 / variance + np.log(2 * np.pi * variance)) / 2


def _crusts(grid, n_picks, years):
    """Log-probability of so many picks that are no horizon, in so many years."""
    return n_picks * np.log(grid.crusts / grid.mass) - grid.crusts * years


def _opened(series, grid, rates, known):
    """Probability that each pick is the first horizon, by its age, (pick, age, point)."""
    n_picks = series.above_m.size
    n_ages = _n_ages(series, grid, known)
    opened = np.zeros((n_picks, n_ages, grid.mass.size))
    if 0 in known:
        opened[0, 0] = grid.weight
        return opened
    ages = np.arange(n_ages)[:, None]
    years = np.maximum(series.elapsed + ages, OPEN_YEARS)
    if known:  # a layer that is named is surer than the snow above the first
        for pick in range(1 + min(known)):
            log = np.log(series.confidence[pick]) + _crusts(grid, pick, 0)
            opened[pick] = grid.weight * np.exp(log)
        return opened
    for pick in range(min(n_picks, MOST_SKIPPED + 1)):
        mass = series.above_m[pick] / grid.unit_m
        error = series.error_m[pick] / series.above_m[pick]
        variance = grid.scatter**2 / years + (OPEN_YEARS / years) ** 2 + error**2
        log = _lognormal(mass / (years * grid.mass), variance) - np.log(mass)
        log = log + np.log(series.confidence[pick]) + ages * np.log(rates.hidden)
        log = log + _crusts(grid, pick, years)
        opened[pick] = grid.weight * np.exp(log)
    return opened


def _steps(series, grid, known, n_ages):
    """Years from a horizon to the next one, fewer than `n_ages`, by pair of picks.

    Values are numbers of years (n,) and their probabilities (n, point).
    """
    n_picks = series.above_m.size
    skipped = n_picks if known else MOST_SKIPPED
    steps = {}
    for upper in range(n_picks):
        for lower in range(upper + 1, min(n_picks, upper + skipped + 2)):
            if {*range(upper + 1, lower)} & {*known}:
                break
            mass = series.span_m[upper, lower] / grid.unit_m
            most = 3 + int(2 * max(mass, 0) / grid.mass.min())
            years = np.arange(0 if series.apart[upper, lower] else 1, min(most, n_ages))
            if upper in known and lower in known:
                years = np.array([known[lower] - known[upper]])
            log = _log_step(series, grid, upper, lower, years[:, None])
            log = log + _crusts(grid, lower - upper - 1, years[:, None])
            log = log + np.log(series.confidence[lower])
            kept = (log.max(axis=1) > FAINT) | bool(known)
            if kept.any():
                steps[upper, lower] = years[kept], np.exp(log[kept])
    return steps


def _log_step(series, grid, upper, lower, years):
    """Log-probability of years (n, 1) between two horizons, (n, point)."""
    mass = series.span_m[upper, lower] / grid.unit_m
    one_by_one = (1 - grid.missed) * grid.missed ** (np.maximum(years, 1) - 1)
    at_once = np.where(years > 1, 1 / np.maximum(years * (years - 1), 1), 0)
    gap = np.log((1 - LOST) * one_by_one + LOST * at_once)
    if series.apart[upper, lower]:
        variance = years * grid.scatter**2 + APART_YEARS**2
        off = mass / grid.mass - years
        log = -(off**2 / variance + np.log(2 * np.pi * variance)) / 2 - np.log(grid.mass)
        return log + np.where(years == 0, np.log(ONE_HORIZON), np.log1p(-ONE_HORIZON) + gap)
    error = np.hypot(*series.error_m[[upper, lower]]) / series.span_m[upper, lower]
    # Names may be those of other layers.
    scatter = NAMED if {upper, lower} <= {*series.known} else grid.scatter
    variance = scatter**2 / years + error**2
    return _lognormal(mass / (years * grid.mass), variance) - np.log(mass) + gap


def _ends(series, grid, known):
    """Probability that no horizon is picked below each pick, down to the deepest, (pick, point)."""
    n_picks = series.above_m.size
    ends = np.zeros((n_picks, grid.mass.size))
    for pick in range(max(0, *known) if known else 0, n_picks):
        mass = max(series.span_m[pick, -1], 0) / grid.unit_m if pick < n_picks - 1 else 0
        years = 1 + np.arange(1 + int(2 * mass / grid.mass.min()))[:, None]
        missed = (1 - grid.missed) * grid.missed ** (years - 1)
        with np.errstate(divide="ignore"):
            off = np.log(years * grid.mass / mass) * np.sqrt(years) / grid.scatter
        longer = (missed * ndtr(off)).sum(axis=0) + grid.missed ** years[-1]
        ends[pick] = longer * np.exp(_crusts(grid, n_picks - 1 - pick, mass / grid.mass))
    return ends


def _conditioned(values, pick, known):
    """The same (age, point), 0 at ages that the pick has not, and its logarithmic scale."""
    if pick in known:
        held = values[known[pick]].copy()
        values[:] = 0
        values[known[pick]] = held
    largest = values.max()
    if largest > 0:
        values /= largest
        return np.log(largest)
    return 0.0


def _forward(opened, steps, known):
    """Probability of picks above each horizon, (pick, age, point), and its logarithmic scale."""
    forward = opened.copy()
    n_ages = forward.shape[1]
    scale = np.zeros(len(forward))
    for lower in range(len(forward)):
        before = scale[lower - 1] if lower else 0.0
        forward[lower] *= np.exp(-before)
        for upper in range(lower):
            years, of_years = steps.get((upper, lower), ((), ()))
            for n, own in zip(years, of_years, strict=True):
                own = own * np.exp(scale[upper] - before)
                forward[lower, n:] += forward[upper, : n_ages - n] * own
        scale[lower] = before + _conditioned(forward[lower], lower, known)
    return forward, scale


def _backward(ends, steps, known, n_ages):
    """Probability of picks below each horizon, (pick, age, point), and its logarithmic scale."""
    backward = np.repeat(ends[:, None], n_ages, axis=1)
    n_picks = len(ends)
    scale = np.zeros(n_picks)
    for upper in range(n_picks - 1, -1, -1):
        before = scale[upper + 1] if upper < n_picks - 1 else 0.0
        backward[upper] *= np.exp(-before)
        for lower in range(upper + 1, n_picks):
            years, of_years = steps.get((upper, lower), ((), ()))
            for n, own in zip(years, of_years, strict=True):
                own = own * np.exp(scale[lower] - before)
                backward[upper, : n_ages - n] += backward[lower, n:] * own
        scale[upper] = before + _conditioned(backward[upper], upper, known)
    return backward, scale


def quantile(values, weights, share):
    """Quantile of values of these weights."""
    order = np.argsort(values)
    below = np.cumsum(weights[order])
    return float(values[order][np.searchsorted(below, share * below[-1])])


def stated_ages(found, apart):
    """The age of every pick, -1 for no horizon: as many right ones as can be expected.

    Ages increase downwards, but at layers that no range line shares.
    """
    n_picks, n_ages = found.age.shape
    none = 1 - found.age.sum(axis=1)
    best = np.full((n_picks, n_ages), -np.inf)
    came = np.full((n_picks, n_ages), -1)
    for lower in range(n_picks):
        so_far = np.full(n_ages, none[:lower].sum())
        for upper in range(lower):
            reached = np.maximum.accumulate(best[upper])
            if not apart[upper, lower]:
                reached = np.append(-np.inf, reached[:-1])
            reached = reached + none[upper + 1 : lower].sum()
            came[lower][reached > so_far] = upper
            so_far = np.maximum(so_far, reached)
        best[lower] = so_far + found.age[lower]
    after = np.append(np.cumsum(none[::-1])[::-1], 0)[1:]
    ages = np.full(n_picks, -1)
    pick = int((best.max(axis=1) + after).argmax())
    age = int(best[pick].argmax())
    while True:
        ages[pick] = age
        upper = came[pick, age]
        if upper < 0:
            return ages
        stop = age + 1 if apart[upper, pick] else age
        pick, age = upper, int(best[upper, :stop].argmax())
