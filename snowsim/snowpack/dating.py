"""Ages of picked layers: the exact posterior of a hidden sequence of horizons and crusts.

Each pick is an autumn horizon or a crust. One or more years lie between two horizons. Above the
first horizon lie the snow since the last autumn and perhaps horizons without a pick. The
probability of every age of every pick is a sum over all such sequences, by a forward and a backward
recursion over picks (Rabiner 1989, Proc. IEEE 77, 257-286) with ages as second index. Four
properties of the place are unknown: the mass of a typical year, the scatter of years about it, the
share of horizons without a pick, and the rate of crusts. The sum includes a grid of values of each.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.special import ndtr

N_MASSES = 48  # grid points of the mass of a typical year, in steps of some 5 %
# Limits of the typical mass over the median span. Below them most horizons have no pick, above them
# most picks are crusts.
TYPICAL_OVER_SPAN = (0.3, 2.5)
MOST_CRUSTS_IN_A_ROW = 6  # unless layers are named, which may ask for more
# Grid points less probable than this, relative to the most probable one, are left out.
NEGLIGIBLE_POINT = 1e-4
NEGLIGIBLE_LOG_STEP = -45.0  # logarithm of a step's probability, below which it is left out


@dataclass(frozen=True)
class Rates:
    """Grids of the unknown rates of a place; the values of a grid are equally likely beforehand.

    Years of cores scatter by .13 to .31. The grid of scatter was chosen on the tuning seeds of
    `benchmarks/bench_years.py` and every other core. It is a compromise between a low Brier score
    and .4 of dates surer than .8; other grids were about as good.

    Attributes
    ----------
    scatter : tuple of float
        Standard deviation of the logarithm of a year's mass.
    missed : tuple of float
        Share of horizons without a pick.
    crusts : tuple of float
        Number of picked crusts in a year.
    hidden : float
        Odds of one more horizon above the first pick, in the tail of the surface's echo.
    """

    scatter: tuple = (0.2, 0.25)
    missed: tuple = (0.03, 0.1, 0.3)
    crusts: tuple = (0.01, 0.05, 0.2)
    hidden: float = 0.9


TRACKED = Rates()
# A person says that every layer is a year. With these rates less than .1 of the years of 23 cores
# get a flag.
ANNUAL = Rates(scatter=(0.25,), missed=(0.002,), crusts=(0.002,), hidden=0.01)
# Share of spans over which the echo is lost. It is assumed, large enough to date a gap of twenty
# years. Such a span has n > 1 years with the probability 1 / (n (n - 1)), so that no number is
# typical.
LOST_ECHO_SHARE = 0.02
# Scatter of the mass between two named layers; names are refused only from a factor of 4 on.
NAMED_SCATTER = 0.5
AUTUMN_SCATTER_YEARS = 0.1  # standard deviation of a horizon's date: some five weeks, assumed
# Standard deviation of the distance between layers that no range line shares, in typical years:
# that of a year's mass.
DISJOINT_SCATTER_YEARS = 0.2
# Probability that two such layers, one after the other, are one horizon: unknown beforehand.
SAME_HORIZON_PROBABILITY = 0.5


@dataclass(frozen=True, eq=False)
class Series:
    """Picks of a track as one series, from the uppermost down.

    Attributes
    ----------
    above_m : ndarray, (pick,)
        Mass of the snow above the pick [m w.e.].
    span_m : ndarray, (pick, pick)
        Mass from one pick down to another [m w.e.].
    error_m : ndarray, (pick,)
        Standard deviation of the mass above the pick [m w.e.].
    disjoint : ndarray of bool, (pick, pick)
        Whether no range line has both picks.
    confidence : ndarray, (pick,)
        Probability that a layer lies at the pick.
    elapsed : float
        Share of the snow year that has elapsed at the time of the flight.
    known : dict of int to int
        Known ages, by pick, in years before the last autumn.
    separable_m : float
        Least mass between two layers that the tracker separates [m w.e.].
    """

    above_m: np.ndarray
    span_m: np.ndarray
    error_m: np.ndarray
    disjoint: np.ndarray
    confidence: np.ndarray
    elapsed: float
    known: dict
    separable_m: float = 0.0


@dataclass(frozen=True, eq=False)
class Posterior:
    """Probabilities of the ages of picks, and of the mass of a typical year.

    Attributes
    ----------
    age : ndarray, (pick, age)
        Probability that the pick is the horizon of that age, in years before the last autumn.
    spans : list of tuple
        (upper, lower, years, probability): the probability that two picks are horizons, so many
        years apart, without a picked horizon between them. At the surface `upper` is -1, and
        `years` include the part of a year since the last autumn.
    mass_m, weight : ndarray, (point,)
        Mass of a typical year [m w.e.], and its probability.
    scatter : float
        Posterior mean of the standard deviation of the logarithm of a year's mass.
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
        """Standard deviation of the logarithm of the mass of a typical year."""
        log = np.log(self.mass_m)
        mean = self.weight @ log / self.weight.sum()
        return float(np.sqrt(self.weight @ (log - mean) ** 2 / self.weight.sum()))

    def below(self, mass_m):
        """Probability that a typical year has less than this mass [m w.e.]."""
        return float(self.weight[self.mass_m < mass_m].sum())


@dataclass(frozen=True, eq=False)
class _Grid:
    """All combinations of the unknown properties of a place and their prior weights, (point,).

    Masses are in units of `unit_m`, the median span, so that densities are near 1.
    """

    unit_m: float
    mass: np.ndarray
    scatter: np.ndarray
    missed: np.ndarray
    crusts: np.ndarray
    weight: np.ndarray

    def subset(self, kept):
        """The grid of some of the points."""
        arrays = ("mass", "scatter", "missed", "crusts", "weight")
        return replace(self, **{name: getattr(self, name)[kept] for name in arrays})


def posterior(series, rates=TRACKED, expected_m=None, expected_error=0.3):
    """`Posterior` of a `Series`; ValueError if no sequence has the known ages.

    With n years and the mass w between two horizons, the mass m of a typical year and its scatter
    s, the probability P of a sequence is::

        log P = sum over horizons of [lognormal(w | n m, s / sqrt(n)) + (n - 1) log(missed)
                + log(1 - missed) + log(confidence)]
                + sum over crusts of log(crusts / m) - crusts * years

    A small share of spans, over which the echo is lost, may have any number of years. The snow
    above the first horizon has the mean mass (elapsed + hidden) m; it does not count if the age of
    a layer is known. `expected_m` is the median of a lognormal prior of m, with the scatter
    `expected_error`; without it the prior is flat in the logarithm of m.
    """
    grid = _grid(series, rates, expected_m, expected_error)
    # Ages count from that of the first pick, if it is known, so that the arrays stay small.
    offset = series.known.get(0, 0)
    known = {pick: age - offset for pick, age in series.known.items()}
    starts = _starts(series, grid, rates, known)
    steps = _steps(series, grid, known, starts.shape[1])
    ends = _ends(series, grid, known)
    if not known:  # most points are improbable, which sums over ages find at less cost
        kept = _is_probable(starts, steps, ends)
        grid = grid.subset(kept)
        n_ages = _n_ages(series, grid, known)
        starts, ends = starts[:, :n_ages, kept], ends[:, kept]
        steps = _restrict_steps(steps, n_ages, kept)
    forward, log_forward = _forward(starts, steps, known)
    backward, log_backward = _backward(ends, steps, known, forward.shape[1])
    last = np.einsum("kag,kg->k", forward, ends)
    with np.errstate(divide="ignore"):
        total = np.logaddexp.reduce(log_forward + np.log(last))
    if not np.isfinite(total):
        msg = "year: no number of years between the named layers fits the layers between them"
        raise ValueError(msg)
    scale = np.exp(log_forward + log_backward - total)
    age = scale[:, None] * np.einsum("kag,kag->ka", forward, backward)
    weight = np.einsum("k,kag,kg->g", np.exp(log_forward - total), forward, ends)
    first = np.einsum("kag,kag->ka", starts, backward) * np.exp(log_backward - total)[:, None]
    spans = [
        (-1, pick, series.elapsed + offset + years, probability)
        for (pick, years), probability in np.ndenumerate(first)
        if probability > 0
    ]
    for (upper, lower), (years, probabilities) in steps.items():
        both = np.exp(log_forward[upper] + log_backward[lower] - total)
        for n, own in zip(years, probabilities, strict=True):
            sums = np.einsum("ag,ag->g", forward[upper, : age.shape[1] - n], backward[lower, n:])
            spans.append((upper, lower, int(n), both * (sums @ own)))
    age = np.pad(age, [(0, 0), (offset, 0)])
    return Posterior(age, spans, grid.mass * grid.unit_m, weight, float(weight @ grid.scatter))


def _grid(series, rates, expected_m, expected_error):
    """`_Grid` of masses of a typical year and of rates."""
    spans_m = np.where(np.triu(~series.disjoint, 1), series.span_m, np.inf).min(axis=1)
    near = np.isfinite(spans_m)
    unit_m = float(np.median(spans_m[near] if near.any() else series.above_m))
    low, high = TYPICAL_OVER_SPAN
    if expected_m is not None:
        low = min(low, expected_m / unit_m * np.exp(-2 * expected_error))
        high = max(high, expected_m / unit_m * np.exp(2 * expected_error))
    masses = np.geomspace(low, high, N_MASSES)
    values = np.meshgrid(masses, rates.scatter, rates.missed, rates.crusts, indexing="ij")
    mass, scatter, missed, crusts = (value.ravel() for value in values)
    # A horizon is missed, too, if its year is thinner than the tracker separates.
    deviation = np.log(mass * unit_m / max(series.separable_m, 1e-9)) / scatter
    missed = 1 - (1 - missed) * np.clip(ndtr(deviation), 0.01, 1)
    weight = np.ones(mass.size)
    if expected_m is not None:
        weight = np.exp(-(np.log(mass * unit_m / expected_m) ** 2) / (2 * expected_error**2))
    return _Grid(unit_m, mass, scatter, missed, crusts, weight / weight.sum())


def _restrict_steps(steps, n_ages, kept):
    """Steps of fewer than `n_ages` years, at some points of the grid, as `_steps` has them."""
    return {
        pair: (years[years < n_ages], probabilities[years < n_ages][:, kept])
        for pair, (years, probabilities) in steps.items()
    }


def _is_probable(starts, steps, ends):
    """Points of the grid that are not negligible, bool (point,), by sums over all ages."""
    with np.errstate(divide="ignore"):
        log = np.log(starts.sum(axis=1))
        log_sum = log[0] + np.log(ends[0])
        for lower in range(1, len(log)):
            for upper in range(lower):
                if (upper, lower) in steps:
                    step = np.log(steps[upper, lower][1].sum(axis=0))
                    log[lower] = np.logaddexp(log[lower], log[upper] + step)
            log_sum = np.logaddexp(log_sum, log[lower] + np.log(ends[lower]))
    return log_sum > log_sum.max() + np.log(NEGLIGIBLE_POINT)


def _n_ages(series, grid, known):
    """Number of ages that are considered: the deepest pick's largest, and a tenth more."""
    deepest = series.above_m[-1] / grid.unit_m / grid.mass.min()
    return 2 + int(1.1 * max([deepest, *known.values()]))


def _log_lognormal(ratio, variance):
    """Logarithm of the density of a lognormal mass over its median, by its logarithm."""
    return -(np.log(ratio) ** 2 / variance + np.log(2 * np.pi * variance)) / 2


def _log_crusts(grid, n_crusts, years):
    """Log-probability that so many picks are crusts of so many years."""
    return n_crusts * np.log(grid.crusts / grid.mass) - grid.crusts * years


def _starts(series, grid, rates, known):
    """Probability that a pick is the first horizon and has an age, (pick, age, point)."""
    n_picks = series.above_m.size
    n_ages = _n_ages(series, grid, known)
    starts = np.zeros((n_picks, n_ages, grid.mass.size))
    if 0 in known:
        starts[0, 0] = grid.weight
        return starts
    ages = np.arange(n_ages)[:, None]
    years = np.maximum(series.elapsed + ages, AUTUMN_SCATTER_YEARS)
    if known:  # a named layer is surer than the snow above the first horizon
        for pick in range(1 + min(known)):
            log = np.log(series.confidence[pick]) + _log_crusts(grid, pick, 0)
            starts[pick] = grid.weight * np.exp(log)
        return starts
    for pick in range(min(n_picks, MOST_CRUSTS_IN_A_ROW + 1)):
        mass = series.above_m[pick] / grid.unit_m
        error = series.error_m[pick] / series.above_m[pick]
        variance = grid.scatter**2 / years + (AUTUMN_SCATTER_YEARS / years) ** 2 + error**2
        log = _log_lognormal(mass / (years * grid.mass), variance) - np.log(mass)
        log = log + np.log(series.confidence[pick]) + ages * np.log(rates.hidden)
        log = log + _log_crusts(grid, pick, years)
        starts[pick] = grid.weight * np.exp(log)
    return starts


def _steps(series, grid, known, n_ages):
    """Numbers of years from one horizon to the next, and their probabilities, by pair of picks.

    Each value has the numbers (n,), below `n_ages`, and the probabilities (n, point).
    """
    n_picks = series.above_m.size
    skipped = n_picks if known else MOST_CRUSTS_IN_A_ROW
    steps = {}
    for upper in range(n_picks):
        for lower in range(upper + 1, min(n_picks, upper + skipped + 2)):
            if {*range(upper + 1, lower)} & {*known}:
                break
            mass = series.span_m[upper, lower] / grid.unit_m
            most = 3 + int(2 * max(mass, 0) / grid.mass.min())
            years = np.arange(0 if series.disjoint[upper, lower] else 1, min(most, n_ages))
            if upper in known and lower in known:
                years = np.array([known[lower] - known[upper]])
            log = _log_years(series, grid, upper, lower, years[:, None])
            log = log + _log_crusts(grid, lower - upper - 1, years[:, None])
            log = log + np.log(series.confidence[lower])
            kept = (log.max(axis=1) > NEGLIGIBLE_LOG_STEP) | bool(known)
            if kept.any():
                steps[upper, lower] = years[kept], np.exp(log[kept])
    return steps


def _log_years(series, grid, upper, lower, years):
    """Log-probability of numbers of years (n, 1) between two horizons, (n, point)."""
    mass = series.span_m[upper, lower] / grid.unit_m
    one_by_one = (1 - grid.missed) * grid.missed ** (np.maximum(years, 1) - 1)
    at_once = np.where(years > 1, 1 / np.maximum(years * (years - 1), 1), 0)
    gap = np.log((1 - LOST_ECHO_SHARE) * one_by_one + LOST_ECHO_SHARE * at_once)
    if series.disjoint[upper, lower]:
        variance = years * grid.scatter**2 + DISJOINT_SCATTER_YEARS**2
        deviation = mass / grid.mass - years
        log = -(deviation**2 / variance + np.log(2 * np.pi * variance)) / 2 - np.log(grid.mass)
        same, other = np.log(SAME_HORIZON_PROBABILITY), np.log1p(-SAME_HORIZON_PROBABILITY)
        return log + np.where(years == 0, same, other + gap)
    error = np.hypot(*series.error_m[[upper, lower]]) / series.span_m[upper, lower]
    # A person may have named the wrong layer, so that masses between names scatter more.
    scatter = NAMED_SCATTER if {upper, lower} <= {*series.known} else grid.scatter
    variance = scatter**2 / years + error**2
    return _log_lognormal(mass / (years * grid.mass), variance) - np.log(mass) + gap


def _ends(series, grid, known):
    """Probability that all picks below a horizon are crusts, (pick, point).

    The next horizon, without a pick, may lie at any depth below the deepest pick. As between
    horizons, no more than `MOST_CRUSTS_IN_A_ROW` picks are crusts, unless layers are named.
    """
    n_picks = series.above_m.size
    ends = np.zeros((n_picks, grid.mass.size))
    first = max(0, *known) if known else max(0, n_picks - 1 - MOST_CRUSTS_IN_A_ROW)
    for pick in range(first, n_picks):
        mass = max(series.span_m[pick, -1], 0) / grid.unit_m if pick < n_picks - 1 else 0
        years = 1 + np.arange(1 + int(2 * mass / grid.mass.min()))[:, None]
        missed = (1 - grid.missed) * grid.missed ** (years - 1)
        with np.errstate(divide="ignore"):
            deviation = np.log(years * grid.mass / mass) * np.sqrt(years) / grid.scatter
        longer = (missed * ndtr(deviation)).sum(axis=0) + grid.missed ** years[-1]
        ends[pick] = longer * np.exp(_log_crusts(grid, n_picks - 1 - pick, mass / grid.mass))
    return ends


def _condition_and_normalise(values, pick, known):
    """Divide by the largest value (age, point), in place; the logarithm of that value is returned.

    If the pick's age is known, values at all other ages become 0.
    """
    if pick in known:
        held = values[known[pick]].copy()
        values[:] = 0
        values[known[pick]] = held
    largest = values.max()
    if largest > 0:
        values /= largest
        return np.log(largest)
    return 0.0


def _forward(starts, steps, known):
    """Probability of a horizon and all picks above it, (pick, age, point), over its largest value.

    The logarithm of that largest value is returned, too, (pick,).
    """
    forward = starts.copy()
    n_ages = forward.shape[1]
    scale = np.zeros(len(forward))
    for lower in range(len(forward)):
        before = scale[lower - 1] if lower else 0.0
        forward[lower] *= np.exp(-before)
        for upper in range(lower):
            years, probabilities = steps.get((upper, lower), ((), ()))
            for n, own in zip(years, probabilities, strict=True):
                own = own * np.exp(scale[upper] - before)
                forward[lower, n:] += forward[upper, : n_ages - n] * own
        scale[lower] = before + _condition_and_normalise(forward[lower], lower, known)
    return forward, scale


def _backward(ends, steps, known, n_ages):
    """Probability of all picks below a horizon, (pick, age, point), over its largest value.

    The logarithm of that largest value is returned, too, (pick,).
    """
    backward = np.repeat(ends[:, None], n_ages, axis=1)
    n_picks = len(ends)
    scale = np.zeros(n_picks)
    for upper in range(n_picks - 1, -1, -1):
        before = scale[upper + 1] if upper < n_picks - 1 else 0.0
        backward[upper] *= np.exp(-before)
        for lower in range(upper + 1, n_picks):
            years, probabilities = steps.get((upper, lower), ((), ()))
            for n, own in zip(years, probabilities, strict=True):
                own = own * np.exp(scale[lower] - before)
                backward[upper, : n_ages - n] += backward[lower, n:] * own
        scale[upper] = before + _condition_and_normalise(backward[upper], upper, known)
    return backward, scale


def quantile(values, weights, share):
    """The value below which a share of the weights lies."""
    order = np.argsort(values)
    below = np.cumsum(weights[order])
    return float(values[order][np.searchsorted(below, share * below[-1])])


def stated_ages(posterior, disjoint):
    """Age of every pick, -1 for a crust, (pick,): of all sequences the one with most right ages.

    The expected number of right ages and right crusts is largest. Ages increase downwards; layers
    that no range line shares may have the same age.
    """
    n_picks, n_ages = posterior.age.shape
    crust = 1 - posterior.age.sum(axis=1)
    best = np.full((n_picks, n_ages), -np.inf)
    came = np.full((n_picks, n_ages), -1)
    for lower in range(n_picks):
        so_far = np.full(n_ages, crust[:lower].sum())
        for upper in range(lower):
            reached = np.maximum.accumulate(best[upper])
            if not disjoint[upper, lower]:
                reached = np.append(-np.inf, reached[:-1])
            reached = reached + crust[upper + 1 : lower].sum()
            came[lower][reached > so_far] = upper
            so_far = np.maximum(so_far, reached)
        best[lower] = so_far + posterior.age[lower]
    after = np.append(np.cumsum(crust[::-1])[::-1], 0)[1:]
    ages = np.full(n_picks, -1)
    pick = int((best.max(axis=1) + after).argmax())
    age = int(best[pick].argmax())
    while True:
        ages[pick] = age
        upper = came[pick, age]
        if upper < 0:
            return ages
        stop = age + 1 if disjoint[upper, pick] else age
        pick, age = upper, int(best[upper, :stop].argmax())
