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
NEGLIGIBLE_NAMED_POINT = 1e-15  # the same, if the age of a layer is known
NEGLIGIBLE_STEP = 1e-16  # numbers of years between two picks that are less probable are left out
NEGLIGIBLE_AGE = 1e-20  # the same of ages, relative to a pick's most probable one
MOST_LOST = 1e-6  # largest probability of sequences with more ages than are considered


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
        Probability that the surface's echo hides a horizon close below it.
    """

    scatter: tuple = (0.2, 0.25)
    missed: tuple = (0.03, 0.1, 0.3)
    crusts: tuple = (0.01, 0.05, 0.2)
    hidden: float = 1.0


TRACKED = Rates()
# A person says that every layer is a year. With these rates less than .1 of the years of 23 cores
# get a flag.
ANNUAL = Rates(scatter=(0.25,), missed=(0.002,), crusts=(0.002,), hidden=0.01)
# Share of spans over which the echo is lost. It is assumed, large enough to date a gap of twenty
# years. Such a span has n > 1 years with the probability 1 / (n (n - 1)), so that no number is
# typical.
LOST_ECHO_SHARE = 0.02
# Of years with this many times the mass that the tracker separates, half of the horizons have no
# pick; the share falls with the logarithm of the mass as a normal distribution of this standard
# deviation. Chosen on the tuning seeds of `benchmarks/bench_years.py` with .1 to .2 m w.e. a year.
HALF_SEPARATED, SEPARATED_SCATTER = 2.5, 0.4
LEAST_SEPARATED = 0.01  # share that has a pick however thin the years are
# Under this mass of snow [m w.e.] the tail of the surface's echo hides half of the horizons; the
# share falls with the logarithm of the mass as a normal distribution of this standard deviation.
# Measured on tuning seeds: clean firn of .1 to .6 m w.e. a year, seen by two radars. There the
# deviation is .5; with 1 dates are as good, and other radars may have other tails.
HALF_HIDDEN_M, HIDDEN_SCATTER = 0.34, 1.0
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
class Spans:
    """Years between horizons that have no picked horizon between them, (span,).

    Attributes
    ----------
    upper, lower : ndarray of int
        Picks at both ends; -1 is the surface.
    years : ndarray
        Number of years; below the surface it includes the part of a year since the last autumn.
    probability : ndarray
        Probability that both picks are horizons, so many years apart, and none between them is one.
    """

    upper: np.ndarray
    lower: np.ndarray
    years: np.ndarray
    probability: np.ndarray


@dataclass(frozen=True, eq=False)
class Posterior:
    """Probabilities of the ages of picks, and of the mass of a typical year.

    Attributes
    ----------
    age : ndarray, (pick, age)
        Probability that the pick is the horizon of that age, in years before the last autumn.
    spans : Spans
        Probabilities of the years between horizons.
    mass_m, weight : ndarray, (point,)
        Mass of a typical year [m w.e.], and its probability.
    scatter : float
        Posterior mean of the standard deviation of the logarithm of a year's mass.
    """

    age: np.ndarray
    spans: Spans
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
        return log_scatter(self.mass_m, self.weight)

    def below(self, mass_m):
        """Probability that a typical year has less than this mass [m w.e.]."""
        return float(self.weight[self.mass_m < mass_m].sum())


@dataclass(frozen=True, eq=False)
class _Grid:
    """All combinations of the unknown properties of a place and their prior weights, (point,).

    Masses are in units of `unit_m`, the median span, so that densities are near 1. The density of a
    year's mass is computed for every pair of mass and scatter, `pair_mass` and `pair_scatter`
    (pair,), and `pair` has the number of each point's.
    """

    unit_m: float
    pair_mass: np.ndarray
    pair_scatter: np.ndarray
    pair: np.ndarray
    missed: np.ndarray
    crusts: np.ndarray
    weight: np.ndarray

    @property
    def mass(self):
        """Mass of a typical year, (point,)."""
        return self.pair_mass[self.pair]

    @property
    def scatter(self):
        """Standard deviation of the logarithm of a year's mass, (point,)."""
        return self.pair_scatter[self.pair]

    def subset(self, kept):
        """The grid of some of the points."""
        arrays = ("pair", "missed", "crusts", "weight")
        return replace(self, **{name: getattr(self, name)[kept] for name in arrays})


@dataclass(frozen=True, eq=False)
class _Sums:
    """Sums over all ages, as logarithms: known ages only bound the years between two picks.

    Without a known age, or with that of the first pick alone, sums are exact; else they are too
    large.

    Attributes
    ----------
    years : dict of (int, int) to ndarray
        Possible numbers of years from one horizon to the next, by pair of picks.
    gaps : ndarray, (n, point)
        Probability of so many years without a pick between two horizons.
    ends : ndarray, (pick, point)
        Probability that all picks below a horizon are crusts.
    log_steps : dict of (int, int) to ndarray, (point,)
        Probability of any of these numbers of years.
    log_above : ndarray, (pick, point)
        Probability of a horizon and all picks above it.
    log_weight : ndarray, (point,)
        Probability of all picks.
    """

    years: dict
    gaps: np.ndarray
    ends: np.ndarray
    log_steps: dict
    log_above: np.ndarray
    log_weight: np.ndarray


@dataclass(frozen=True, eq=False)
class _Parts:
    """What a recursion over ages needs: probabilities at the points of a `grid`.

    They are `starts` (pick, age, point), the numbers of years and their probabilities (n, point)
    `steps` by pair of picks, and `ends` (pick, point). `log_total` is the logarithm of the
    probability of all sequences at these points, by the sums over all ages.
    """

    grid: _Grid
    log_total: float
    starts: np.ndarray
    steps: dict
    ends: np.ndarray

    @property
    def n_ages(self):
        """Number of ages that are considered."""
        return self.starts.shape[1]


def posterior(series, rates=TRACKED, expected_m=None, expected_error=0.3):
    """`Posterior` of a `Series`; ValueError if no sequence has the known ages.

    With n years and the mass w between two horizons, the mass m of a typical year and its scatter
    s, the probability P of a sequence is::

        log P = sum over horizons of [lognormal(w | n m, s / sqrt(n)) + (n - 1) log(missed)
                + log(1 - missed) + log(confidence)]
                + sum over crusts of log(crusts / m) - crusts * years

    A small share of spans, over which the echo is lost, may have any number of years. The snow
    above the first horizon has the mean mass (elapsed + hidden) m. Each of these hidden horizons,
    of age a, is missed or lies in the tail of the surface's echo, whose share is that of
    `HALF_HIDDEN_M` at the mass (elapsed + a) m. All this does not count if the age of a layer is
    known. `expected_m` is the median of a lognormal prior of m, with the scatter
    `expected_error`; without it the prior is flat in the logarithm of m.
    """
    # Ages count from that of the first pick, if it is known, so that the arrays stay small.
    offset = series.known.get(0, 0)
    known = {pick: age - offset for pick, age in series.known.items()}
    grid = _grid(series, rates, expected_m, expected_error)
    sums = _sums(series, grid, rates, known)
    log_total = sums.log_weight.max()
    if max(known, default=0) > 0 and np.isfinite(log_total):
        # Sums over all ages are too large: those of the known ages, at the likeliest points alone,
        # are a limit from below.
        parts = _parts(series, grid, rates, known, sums, log_total, NEGLIGIBLE_POINT)
        log_total = _log_total(*_forward(parts, known)[:2], parts.ends)
    negligible = NEGLIGIBLE_NAMED_POINT if known else NEGLIGIBLE_POINT
    parts = _parts(series, grid, rates, known, sums, log_total, negligible)
    forward, log_forward, n_ages = _forward(parts, known)
    found = _log_total(forward, log_forward, parts.ends)
    # Layers with far less snow than a sharply expected mass have more ages than that mass has.
    while parts.n_ages < len(sums.gaps) and np.exp(found - parts.log_total) < 1 - MOST_LOST:
        most = 2 * parts.n_ages
        parts = _parts(series, grid, rates, known, sums, log_total, negligible, most)
        forward, log_forward, n_ages = _forward(parts, known)
        found = _log_total(forward, log_forward, parts.ends)
    log_total = found
    if not np.isfinite(log_total):
        msg = "year: no number of years between the named layers fits the layers between them"
        raise ValueError(msg)
    backward, log_backward = _backward(parts, known, n_ages)
    log_backward -= log_total
    age = np.einsum("k,kag,kag->ka", np.exp(log_forward + log_backward), forward, backward)
    age = np.pad(age, [(0, 0), (offset, len(sums.gaps) - age.shape[1])])
    weight = np.einsum("k,kag,kg->g", np.exp(log_forward - log_total), forward, parts.ends)
    begun = series.elapsed + offset
    spans = _spans(parts, forward, backward, log_forward, log_backward, n_ages, begun)
    grid = parts.grid
    return Posterior(age, spans, grid.mass * grid.unit_m, weight, float(weight @ grid.scatter))


def typical_mass(series, rates=TRACKED, expected_m=None, expected_error=0.3):
    """`Posterior.typical_m` [m w.e.], at less cost if no layer below the first has a known age."""
    if max(series.known, default=0) > 0:
        return posterior(series, rates, expected_m, expected_error).typical_m
    return quantile(*weighted_masses(series, rates, expected_m, expected_error), 0.5)


def weighted_masses(series, rates=TRACKED, expected_m=None, expected_error=0.3):
    """Masses of a typical year [m w.e.] and their weights, without the ages of picks.

    Only the first layer may have a known age.
    """
    grid = _grid(series, rates, expected_m, expected_error)
    log_weight = _sums(series, grid, rates, {pick: 0 for pick in series.known}).log_weight
    weight = np.exp(log_weight - log_weight.max())
    negligible = NEGLIGIBLE_NAMED_POINT if series.known else NEGLIGIBLE_POINT
    return grid.mass * grid.unit_m, np.where(weight > negligible, weight, 0)


def log_scatter(values, weights):
    """Standard deviation of the logarithm of values with weights."""
    log = np.log(values)
    mean = weights @ log / weights.sum()
    return float(np.sqrt(weights @ (log - mean) ** 2 / weights.sum()))


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
    pairs = np.meshgrid(masses, rates.scatter, indexing="ij")
    pair_mass, pair_scatter = (value.ravel() for value in pairs)
    numbers = np.arange(pair_mass.size)
    values = np.meshgrid(numbers, rates.missed, rates.crusts, indexing="ij")
    pair, missed, crusts = (value.ravel() for value in values)
    mass = pair_mass[pair]
    # Horizons are missed, too, where years are thin.
    half_m = HALF_SEPARATED * max(series.separable_m, 1e-9)
    separated = ndtr(np.log(mass * unit_m / half_m) / SEPARATED_SCATTER)
    missed = 1 - (1 - missed) * np.maximum(separated, LEAST_SEPARATED)
    weight = np.ones(mass.size)
    if expected_m is not None:
        weight = np.exp(-(np.log(mass * unit_m / expected_m) ** 2) / (2 * expected_error**2))
    return _Grid(unit_m, pair_mass, pair_scatter, pair, missed, crusts, weight / weight.sum())


def _n_ages(series, grid, known):
    """Number of ages that are considered: the deepest pick's largest, and a tenth more."""
    deepest = series.above_m[-1] / grid.unit_m / grid.mass.min()
    return 2 + int(1.1 * max([deepest, *known.values()]))


def _sums(series, grid, rates, known):
    """`_Sums` at all points of the grid."""
    n_ages = _n_ages(series, grid, known)
    years = _years(series, grid, known, n_ages)
    gaps = _gaps(grid, n_ages)
    with np.errstate(divide="ignore"):
        log_steps = {}
        for pair, numbers in years.items():
            # All points of a pair of mass and scatter lie side by side.
            of_pair = gaps[numbers].reshape(numbers.size, grid.pair_mass.size, -1)
            density = _densities(series, grid, pair, numbers[:, None])
            summed = np.einsum("np,npr->pr", density, of_pair).ravel()
            log_steps[pair] = np.log(summed * _share_of_crusts(series, grid, pair))
        ends = _ends(series, grid, known)
        log_above = np.full(ends.shape, -np.inf)
        starts = _starts(series, grid, rates, known, n_ages)
        log_above[: len(starts)] = np.log(starts.sum(axis=1))
    # Pairs are in the order of their upper pick, to which all sums from above are complete by then.
    for (upper, lower), log_step in log_steps.items():
        log_above[lower] = np.logaddexp(log_above[lower], log_above[upper] + log_step)
    with np.errstate(divide="ignore"):
        log_weight = np.logaddexp.reduce(log_above + np.log(ends))
    return _Sums(years, gaps, ends, log_steps, log_above, log_weight)


def _parts(series, grid, rates, known, sums, log_total, negligible, n_ages=0):
    """`_Parts` without points and steps that are negligible beside `log_total`.

    `negligible` is the probability of a point that is left out. At least `n_ages` ages are
    considered, if the sums have as many.
    """
    # If all are impossible, none is negligible.
    kept = (sums.log_weight > log_total + np.log(negligible)) | ~np.isfinite(log_total)
    grid = grid.subset(kept)
    n_ages = len(sums.gaps) if known else max(n_ages, _n_ages(series, grid, known))
    n_ages = min(n_ages, len(sums.gaps))
    gaps = sums.gaps[:n_ages, kept]
    ends = sums.ends[:, kept]
    with np.errstate(divide="ignore"):
        log_below = np.log(ends)
    for (upper, lower), log_step in reversed(sums.log_steps.items()):
        log_below[upper] = np.logaddexp(log_below[upper], log_step[kept] + log_below[lower])
    steps = {}
    with np.errstate(over="ignore", invalid="ignore"):  # steps whose probability overflows are kept
        for pair, numbers in sums.years.items():
            upper, lower = pair
            log_rest = sums.log_above[upper, kept] + log_below[lower] - log_total
            if np.exp(log_rest + sums.log_steps[pair][kept]).sum() < NEGLIGIBLE_STEP:
                continue
            numbers = numbers[numbers < n_ages]
            density = _densities(series, grid, pair, numbers[:, None])[:, grid.pair]
            own = density * gaps[numbers] * _share_of_crusts(series, grid, pair)
            few = own @ np.exp(log_rest) < NEGLIGIBLE_STEP
            if not few.all():
                steps[pair] = numbers[~few], own[~few]
    starts = _starts(series, grid, rates, known, n_ages)
    log_kept = np.logaddexp.reduce(sums.log_weight[kept])
    return _Parts(grid, log_kept, starts, steps, ends)


def _lognormal(log_ratio, variance):
    """Density of a lognormal mass over its median, by its logarithm, times that mass."""
    return np.exp(-(log_ratio**2) / (2 * variance)) / np.sqrt(2 * np.pi * variance)


def _gaps(grid, n_ages):
    """Probability of 0 to `n_ages` - 1 years without a pick between two horizons, (n, point).

    No year lies between two picks of one horizon.
    """
    years = np.arange(n_ages)[:, None]
    one_by_one = (1 - grid.missed) * grid.missed ** np.maximum(years - 1, 0)
    at_once = np.where(years > 1, 1 / np.maximum(years * (years - 1), 1), 0)
    gaps = (1 - LOST_ECHO_SHARE) * one_by_one + LOST_ECHO_SHARE * at_once
    gaps[0] = SAME_HORIZON_PROBABILITY / (1 - SAME_HORIZON_PROBABILITY)
    return gaps * np.exp(-grid.crusts * years)


def _starts(series, grid, rates, known, n_ages):
    """Probability that a pick is the first horizon and has an age, (pick, age, point).

    Picks end at the last one that may be the first horizon.
    """
    crusts = grid.crusts / grid.mass
    if known:  # a named layer is surer than the snow above the first horizon
        starts = np.zeros((1 + min(known), n_ages, grid.missed.size))
        if 0 in known:
            starts[0, 0] = grid.weight
        else:
            picks = np.arange(len(starts))[:, None, None]
            starts[:] = grid.weight * series.confidence[picks] * crusts**picks
        return starts
    n_starts = min(series.above_m.size, MOST_CRUSTS_IN_A_ROW + 1)
    starts = np.empty((n_starts, n_ages, grid.missed.size))
    years = np.maximum(series.elapsed + np.arange(n_ages)[:, None], AUTUMN_SCATTER_YEARS)
    above_m = years * grid.pair_mass * grid.unit_m
    in_tail = rates.hidden * ndtr(np.log(HALF_HIDDEN_M / above_m) / HIDDEN_SCATTER)[:, grid.pair]
    # A horizon has no pick if it is hidden or missed; all above the first one have none.
    without_pick = np.cumprod(1 - (1 - grid.missed) * (1 - in_tail), axis=0)
    by_age = grid.weight * np.exp(-grid.crusts * years)
    by_age[1:] *= without_pick[:-1]
    for pick in range(n_starts):
        mass = series.above_m[pick] / grid.unit_m
        error = series.error_m[pick] / series.above_m[pick]
        variance = grid.pair_scatter**2 / years + (AUTUMN_SCATTER_YEARS / years) ** 2 + error**2
        density = _lognormal(np.log(mass / years) - np.log(grid.pair_mass), variance) / mass
        starts[pick] = density[:, grid.pair] * by_age * (series.confidence[pick] * crusts**pick)
    return starts


def _years(series, grid, known, n_ages):
    """Possible numbers of years, below `n_ages`, from one horizon to the next, by pair of picks."""
    n_picks = series.above_m.size
    skipped = n_picks if known else MOST_CRUSTS_IN_A_ROW
    years = {}
    for upper in range(n_picks):
        for lower in range(upper + 1, min(n_picks, upper + skipped + 2)):
            if {*range(upper + 1, lower)} & {*known}:
                break
            mass = series.span_m[upper, lower] / grid.unit_m
            most = 3 + int(2 * max(mass, 0) / grid.mass.min())
            numbers = np.arange(0 if series.disjoint[upper, lower] else 1, min(most, n_ages))
            if upper in known and lower in known:
                numbers = np.array([known[lower] - known[upper]])
            years[upper, lower] = numbers
    return years


def _share_of_crusts(series, grid, pair):
    """Probability of the crusts between two horizons and of a layer at the lower one, (point,)."""
    upper, lower = pair
    share = series.confidence[lower] * (grid.crusts / grid.mass) ** (lower - upper - 1)
    return share * (1 - SAME_HORIZON_PROBABILITY) if series.disjoint[pair] else share


def _densities(series, grid, pair, years):
    """Density of the mass between two horizons with numbers of years (n, 1), (n, pair)."""
    mass = series.span_m[pair] / grid.unit_m
    if series.disjoint[pair]:
        variance = years * grid.pair_scatter**2 + DISJOINT_SCATTER_YEARS**2
        deviation = mass / grid.pair_mass - years
        return _lognormal(deviation, variance) / grid.pair_mass
    error = np.hypot(*series.error_m[[*pair]]) / series.span_m[pair]
    # A person may have named the wrong layer, so that masses between names scatter more.
    scatter = NAMED_SCATTER if {*pair} <= {*series.known} else grid.pair_scatter
    variance = scatter**2 / years + error**2
    return _lognormal(np.log(mass / years) - np.log(grid.pair_mass), variance) / mass


def _ends(series, grid, known):
    """Probability that all picks below a horizon are crusts, (pick, point).

    The next horizon, without a pick, may lie at any depth below the deepest pick. As between
    horizons, no more than `MOST_CRUSTS_IN_A_ROW` picks are crusts, unless layers are named.
    """
    n_picks = series.above_m.size
    ends = np.zeros((n_picks, grid.missed.size))
    first = max(0, *known) if known else max(0, n_picks - 1 - MOST_CRUSTS_IN_A_ROW)
    masses = np.maximum(series.span_m[:, -1], 0) / grid.unit_m
    masses[-1] = 0
    n_years = 1 + (2 * masses / grid.mass.min()).astype(int)
    years = 1 + np.arange(n_years[first:].max())[:, None]
    missed = grid.missed ** np.append([[0]], years, axis=0)
    for pick in range(first, n_picks):
        mass, n = masses[pick], n_years[pick]
        with np.errstate(divide="ignore"):
            deviation = (np.log(years[:n] / mass) + np.log(grid.pair_mass)) * np.sqrt(years[:n])
        longer = ndtr(deviation / grid.pair_scatter)[:, grid.pair]
        longer = (1 - grid.missed) * (missed[:n] * longer).sum(axis=0) + missed[n]
        crusts = (grid.crusts / grid.mass) ** (n_picks - 1 - pick)
        ends[pick] = longer * crusts * np.exp(-grid.crusts * mass / grid.mass)
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


def _forward(parts, known):
    """Probability of a horizon and all picks above it, (pick, age, point), over its largest value.

    The logarithm of that largest value is returned, too, (pick,), and the number of ages that
    count, (pick,).
    """
    n_picks = len(parts.ends)
    forward = np.zeros((n_picks, *parts.starts.shape[1:]))
    forward[: len(parts.starts)] = parts.starts
    n_ages = np.full(n_picks, forward.shape[1])
    scale = np.zeros(n_picks)
    for lower in range(n_picks):
        before = scale[lower - 1] if lower else 0.0
        forward[lower] *= np.exp(-before)
        for upper in (each for each in range(lower) if (each, lower) in parts.steps):
            years, probabilities = parts.steps[upper, lower]
            probabilities = probabilities * np.exp(scale[upper] - before)
            for n, own in zip(years, probabilities, strict=True):
                to = forward[lower, n : n + n_ages[upper]]
                to += forward[upper, : len(to)] * own
        scale[lower] = before + _condition_and_normalise(forward[lower], lower, known)
        # What lies below changes the odds of two ages only if a known age is there.
        if lower >= max(known, default=0):
            counts = forward[lower] > NEGLIGIBLE_AGE * forward[lower].max(axis=0)
            n_ages[lower] = 1 + max(np.flatnonzero(counts.any(axis=1)), default=0)
    return forward, scale, n_ages


def _backward(parts, known, n_ages):
    """Probability of all picks below a horizon, (pick, age, point), over its largest value.

    The logarithm of that largest value is returned, too, (pick,). Of a pick, `n_ages` (pick,) ages
    count.
    """
    n_picks = len(parts.ends)
    backward = np.repeat(parts.ends[:, None], parts.starts.shape[1], axis=1)
    scale = np.zeros(n_picks)
    for upper in range(n_picks - 1, -1, -1):
        before = scale[upper + 1] if upper < n_picks - 1 else 0.0
        backward[upper] *= np.exp(-before)
        for lower in (each for each in range(upper, n_picks) if (upper, each) in parts.steps):
            years, probabilities = parts.steps[upper, lower]
            probabilities = probabilities * np.exp(scale[lower] - before)
            for n, own in zip(years, probabilities, strict=True):
                of = backward[lower, n : n + n_ages[upper]]
                backward[upper, : len(of)] += of * own
        scale[upper] = before + _condition_and_normalise(backward[upper], upper, known)
    return backward, scale


def _log_total(forward, log_forward, ends):
    """Logarithm of the probability of all sequences."""
    with np.errstate(divide="ignore"):
        last = np.log(np.einsum("kag,kg->k", forward, ends))
    return np.logaddexp.reduce(log_forward + last)


def _spans(parts, forward, backward, log_forward, log_backward, n_ages, begun):
    """`Spans` of a recursion over ages.

    `begun` is the number of years above a horizon of age 0.
    """
    n_starts = len(parts.starts)
    first = np.einsum("kag,kag->ka", parts.starts, backward[:n_starts])
    first *= np.exp(log_backward[:n_starts, None])
    lower, ages = np.nonzero(first)
    found = [(np.full(lower.size, -1), lower, begun + ages, first[lower, ages])]
    for (upper, lower), (years, probabilities) in parts.steps.items():
        both = np.exp(log_forward[upper] + log_backward[lower])
        probability = np.empty(years.size)
        for number, (n, own) in enumerate(zip(years, probabilities, strict=True)):
            below = backward[lower, n : n + n_ages[upper]]
            summed = np.einsum("ag,ag->g", forward[upper, : len(below)], below)
            probability[number] = both * (summed @ own)
        found.append((np.full(years.size, upper), np.full(years.size, lower), years, probability))
    return Spans(*(np.concatenate(values) for values in zip(*found, strict=True)))


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
    # Most right ages down to a horizon at most as old, less the crusts above it.
    reached = np.full((n_picks, n_ages + 1), -np.inf)
    above = np.append(0, np.cumsum(crust))
    for lower in range(n_picks):
        same = np.where(disjoint[:lower, lower, None], reached[:lower, 1:], reached[:lower, :-1])
        ways = np.vstack([np.zeros(n_ages), same]) + above[lower]
        came[lower] = ways.argmax(axis=0) - 1
        best[lower] = ways.max(axis=0) + posterior.age[lower]
        reached[lower, 1:] = np.maximum.accumulate(best[lower]) - above[lower + 1]
    after = above[-1] - above[1:]
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
