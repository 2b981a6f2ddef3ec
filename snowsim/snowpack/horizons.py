"""Ages of the layers of a track: its picks as one series, and what the posterior says of each."""

import warnings
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from snowsim.limits import check_count
from snowsim.snowpack.dating import (
    ANNUAL,
    MOST_SKIPPED,
    TRACKED,
    Posterior,
    Series,
    posterior,
    quantile,
    stated_ages,
)

YEAR_DAYS = 366
NINE_OF_TEN = 1.645  # standard deviations to either side that hold nine of ten
TAILS = (0.05, 0.95)  # between which nine of ten lie
MOST_LINES = 1000  # range lines of two layers whose median distance is taken
N_POLISH = 3  # rounds of medians by layer and by line; assumed, not measured
CONTRADICTION = 4  # factor of mass, over the typical one, from which on years of names are refused
NOTED = 2  # factor of the typical mass over the expected one, from which on it is said
# Nothing is dated where a typical year has, with more than this probability, less than so many
# times the mass between layers that the tracker separates: of six simulations of .05 m w.e. a year
# (1.1 times) four or five, of .1 m (1.9 times) none.
RESOLVED, UNRESOLVED = 1.5, 0.04
LEAST_MASS = 1e-3  # of spans between layers, in typical spans


@dataclass(frozen=True, eq=False)
class Dated:
    """Ages of the layers of a track, the surface first.

    `last_autumn` is the year of age 0. By layer: `age`, in years before it, -1 of the surface and
    of layers that are no horizon; `sure`, the probability that the layer is the horizon of this
    age; `low` and `high`, between which nine of ten lie. `found` is the posterior of the layers
    below the surface, `above_m` the mass above them in the series. `resolved` is False where the
    tracker may not separate years: then no layer is dated.
    """

    last_autumn: int
    age: np.ndarray
    sure: np.ndarray
    low: np.ndarray
    high: np.ndarray
    found: Posterior
    above_m: np.ndarray
    resolved: bool

    @property
    def first(self):
        """The first layer below the surface that is a horizon."""
        return 1 + int(np.argmax(self.age[1:] >= 0))

    @property
    def typical_m(self):
        """Mass of a typical year [m w.e.]."""
        return self.found.typical_m

    @property
    def scatter(self):
        """Standard deviation of the logarithm of a year's mass."""
        return self.found.scatter

    def spread(self, upper, lower):
        """Quantiles `TAILS` of the accumulation between two layers, over that by stated ages.

        Mixture, by mass, of what all sequences of horizons have between these two.
        """
        top_m, base_m = self.above_m[[upper - 1, lower - 1]]
        stated = (base_m - top_m) / (self.age[lower] - self.age[upper])
        rates, weights = [], []
        for above, below, years, probability in self.found.spans:
            begin_m = self.above_m[above] if above >= 0 else 0.0
            within_m = min(base_m, self.above_m[below]) - max(top_m, begin_m)
            if within_m > 0 and years > 0:
                rates.append((self.above_m[below] - begin_m) / years)
                weights.append(probability * within_m)
        if not rates:  # medians over different parts of the track are in another order
            return [1.0, 1.0]
        rates, weights = np.array(rates), np.array(weights)
        return [quantile(rates, weights, share) / stated for share in TAILS]


def dated(water_m, picks, year, annual, expected, apart_m):
    """`Dated` from the mass above picks (layer, range_line) [m w.e.], the surface first.

    The tracker separates layers from `apart_m` of snow on.
    """
    last_autumn = picks.flown.year - 1
    is_named = hasattr(year, "items")
    of_first = {} if year is None else {str(picks.names[1]): year}
    given = given_years(picks, year if is_named else of_first)
    known = {layer - 1: last_autumn - told for layer, told in given.items()}
    series = replace(series_of(water_m, picks, known), apart_m=apart_m)
    rates = ANNUAL if annual else TRACKED
    expected_m, _ = expected
    if len(known) > 1 or expected_m is not None:
        alone = posterior(replace(series, known={}), rates).typical_m
        _check_years(series, alone, given)
        _note_expected(expected_m, alone)
    found = posterior(series, rates, *expected)
    if annual:
        age = np.arange(series.above_m.size)
        if given:
            age = last_autumn - in_order(len(picks.names), given)
    else:
        age = stated_ages(found, series.apart)
    resolved = annual or bool(known) or found.below(RESOLVED * apart_m) < UNRESOLVED
    if not resolved:
        age = np.full(age.size, -1)
    sure = np.where(age >= 0, found.age[np.arange(age.size), age], np.nan)
    sure[list(known)] = 1  # but for rounding
    sure = falling(sure, list(known))
    low, high = limits(found.age)
    surface = [-1.0]
    return Dated(
        last_autumn,
        np.append(-1, age),
        np.append(1.0, sure),
        np.append(surface, np.minimum(low, age)),
        np.append(surface, np.maximum(high, age)),
        found,
        series.above_m,
        resolved,
    )


def falling(sure, named):
    """Probabilities (layer,) that rise nowhere but towards a named layer.

    Of a layer between two that are named, or the surface and one, the doubt is the lesser of what
    lies above it and what lies below it.
    """
    down, up = sure.copy(), np.zeros_like(sure)
    start = 0
    for stop in [*sorted(named), sure.size]:
        down[start:stop] = np.fmin.accumulate(sure[start:stop])
        if stop < sure.size:
            up[start : stop + 1] = np.fmin.accumulate(sure[start : stop + 1][::-1])[::-1]
        start = stop
    return np.where(np.isnan(sure), np.nan, np.maximum(down, up))


def limits(age):
    """Ages between which nine of ten of each pick's horizon lie, from (pick, age)."""
    below = np.cumsum(age, axis=1)
    below /= np.maximum(below[:, -1:], np.finfo(float).tiny)
    return tuple((below < share).sum(axis=1) for share in TAILS)


def series_of(water_m, picks, known):
    """`Series` of the mass above picks (layer, range_line), medians over lines that have both.

    Accumulation changes along track: masses are taken over a factor by range line, the median over
    layers of their mass over that of the layer. Where no line has two layers, their distance is
    that of their medians.
    """
    level_m, above_m = _level(water_m[1:])
    n_layers = len(level_m)
    span_m = above_m - above_m[:, None]
    there = np.isfinite(level_m)
    apart = ~(there[:, None] & there).any(axis=2)
    reach = n_layers if known else MOST_SKIPPED + 2
    for upper in range(n_layers):
        for lower in range(upper + 1, min(n_layers, upper + reach)):
            lines = np.flatnonzero(there[upper] & there[lower])
            if lines.size:
                lines = lines[:: 1 + lines.size // MOST_LINES]
                span_m[upper, lower] = np.median(level_m[lower, lines] - level_m[upper, lines])
    least_m = LEAST_MASS * np.median(np.abs(np.diff(above_m))) if n_layers > 1 else 0
    span_m = np.where(apart, span_m, np.maximum(span_m, least_m))
    with np.errstate(divide="ignore", invalid="ignore"):
        relative = picks.error_s[1:] / picks.below_s[1:]
    error_m = above_m * np.nan_to_num(_median(relative)) / NINE_OF_TEN
    elapsed = picks.flown.day_of_year / YEAR_DAYS
    sure = 1 - _median(picks.doubt[1:])
    return Series(above_m, span_m, error_m, apart, sure, elapsed, known)


def _level(below_m):
    """Masses (layer, range_line) over the factor of their line, and their medians by layer."""
    log_m = pd.DataFrame(np.log(below_m))
    of_layer = log_m.median(axis=1)
    for _ in range(N_POLISH):
        of_line = log_m.sub(of_layer, axis=0).median()
        of_line -= of_line.median()
        of_layer = log_m.sub(of_line, axis=1).median(axis=1)
    return below_m / np.exp(of_line.to_numpy()), np.exp(of_layer.to_numpy())


def _median(values):
    return pd.DataFrame(values).median(axis=1).to_numpy()


def given_years(picks, year):
    """Years by the number of the layer that is named so, downwards."""
    for each in year.values():
        check_count("year", each, 0)
    given = {layer: year[name] for layer, name in enumerate(picks.names) if name in year}
    flown = picks.flown.year  # of the surface; the last autumn is of the year before
    falls = np.diff([flown, *given.values()]) < 0
    if len(given) != len(year) or 0 in given or not falls.all():
        msg = (
            f"year: expected names of layers with picks, {', '.join(picks.names[1:])}, and years "
            f"that fall from each to the next, none after {flown - 1}, found {year}"
        )
        raise ValueError(msg)
    return given


def in_order(n_layers, given):
    """Years of all layers below the surface, each older than the one above, but for those given."""
    layers, years = np.array(list(given.items())).T
    more = -np.diff(layers + years)
    if (np.diff(layers)[more != 0] > 1).any():
        msg = (
            f"year: expected as many years from name to name as layers, found {more} more: name "
            "every layer, or count years"
        )
        raise ValueError(msg)
    every = np.arange(1, n_layers)
    return np.interp(every, layers, layers + years).astype(int) - every


def _note_expected(expected_m, typical_m):
    """Say where layers alone contradict the expected mass of a year."""
    if expected_m is not None and abs(np.log(typical_m / expected_m)) > np.log(NOTED):
        warnings.warn(
            f"expected_m: {expected_m:g} m w.e. a year were expected, by the layers alone a "
            f"typical year has {typical_m:.2g}",
            stacklevel=5,
        )


def _check_years(series, typical_m, given):
    """Refuse given years between which lies far more or less snow than typical."""
    picks = list(series.known)
    told = -np.diff(list(given.values()))
    found = series.span_m[picks[:-1], picks[1:]] / typical_m
    if ((found < told / CONTRADICTION) | (found > told * CONTRADICTION)).any():
        msg = (
            f"year: from name to name {told} years contradict their snow, that of "
            f"{found.round(1)} typical years"
        )
        raise ValueError(msg)
