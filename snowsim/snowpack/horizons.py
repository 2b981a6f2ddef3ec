"""Ages of the layers of a track, by the posterior of its picks as one series."""

import warnings
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import pandas as pd

from snowsim.limits import check_count
from snowsim.snowpack.dating import (
    ANNUAL,
    HALF_SEPARATED,
    MOST_CRUSTS_IN_A_ROW,
    TRACKED,
    Posterior,
    Series,
    log_scatter,
    posterior,
    quantile,
    stated_ages,
    typical_mass,
    weighted_masses,
)

NINE_IN_TEN_SD = 1.645  # a Gaussian lies within so many standard deviations in nine of ten cases
NINE_IN_TEN_QUANTILES = (0.05, 0.95)  # nine of ten cases lie between these quantiles
MOST_COMPARED_LINES = 1000  # the median distance of two layers is that on at most so many lines
N_MEDIAN_ROUNDS = 3  # rounds of medians by layer and by line; assumed, not measured
# Named layers are refused if the mass of a year between them is more than so many times the typical
# one, or less than it divided by this.
REFUSED_FACTOR = 4
# Above the uppermost named layer they are warned of by that factor, if more years than this differ.
LEAST_NOTED_YEARS = 2
# A warning is given if the expected mass and the typical one by the layers alone differ by more
# than this factor, or by more than so many of their joint standard deviations.
NOTED_FACTOR, NOTED_SD = 2, 3
# Nothing is dated if typical years are, with more than this probability, so thin that half of their
# horizons have no pick. So on thirty tuning seeds none of 180 simulations of .1 m w.e. a year is
# dated, where less than .3 of dates would be right, and 50, 43 and 36 of 60 of .15 m with 0, 3 and
# 5 crusts in twenty years.
MOST_UNRESOLVED = 0.1
LEAST_SPAN = 1e-3  # least mass between two layers, in typical spans


@dataclass(frozen=True, eq=False)
class Dated:
    """Ages of the layers of a track, the surface first.

    `last_autumn` is the year of age 0. `age` (layer,) counts years before the last autumn, and is
    -1 for the surface and for crusts; `sure` (layer,) is the probability that the layer is the
    horizon of this age; `age_low` and `age_high` (layer,) are the limits of nine ages in ten.
    `posterior` and the mass above, `above_m`, are those of the layers below the surface.
    `resolved` is False if the tracker may not separate years: then no layer is dated.
    """

    last_autumn: int
    age: np.ndarray
    sure: np.ndarray
    age_low: np.ndarray
    age_high: np.ndarray
    posterior: Posterior
    above_m: np.ndarray
    resolved: bool

    @property
    def first(self):
        """Number of the first layer below the surface that is a horizon."""
        return 1 + int(np.argmax(self.age[1:] >= 0))

    @property
    def typical_m(self):
        """Mass of a typical year [m w.e.]."""
        return self.posterior.typical_m

    @property
    def scatter(self):
        """Standard deviation of the logarithm of a year's mass."""
        return self.posterior.scatter

    def relative_limits(self, upper, lower):
        """Limits of the accumulation between two layers, divided by that of the stated ages.

        They hold nine of ten cases. All spans of all sequences of horizons count, each by its
        probability and by the mass that it has between the two layers.
        """
        top_m, base_m = self.above_m[[upper - 1, lower - 1]]
        stated = (base_m - top_m) / (self.age[lower] - self.age[upper])
        yearly_m, probability, begin_m, end_m = self._masses_of_spans
        within_m = np.minimum(base_m, end_m) - np.maximum(top_m, begin_m)
        inside = within_m > 0
        if not inside.any():  # medians over different parts of the track are in another order
            return [1.0, 1.0]
        weights = probability[inside] * within_m[inside]
        of_share = [quantile(yearly_m[inside], weights, share) for share in NINE_IN_TEN_QUANTILES]
        return [mass / stated for mass in of_share]

    @cached_property
    def _masses_of_spans(self):
        """Mass of a year of each span, its probability, and the mass above its ends [m w.e.]."""
        spans = self.posterior.spans
        begin_m = np.append(self.above_m, 0.0)[spans.upper]  # the last, number -1, is the surface
        end_m = self.above_m[spans.lower]
        dated = spans.years > 0
        yearly_m = (end_m - begin_m)[dated] / spans.years[dated]
        return yearly_m, spans.probability[dated], begin_m[dated], end_m[dated]


def typical_mass_of_layers(water_m, picks, year, annual, expected, separable_m):
    """`Dated.typical_m` [m w.e.] of what `date_layers` takes, without the dates."""
    series, _ = _checked_series(water_m, picks, year, annual, expected, separable_m)
    return typical_mass(series, ANNUAL if annual else TRACKED, *expected)


def date_layers(water_m, picks, year, annual, expected, separable_m):
    """`Dated` layers, from the mass above their picks (layer, range_line) [m w.e.].

    The tracker separates layers with at least `separable_m` [m w.e.] between them.
    """
    last_autumn = picks.last_autumn
    series, given = _checked_series(water_m, picks, year, annual, expected, separable_m)
    known = series.known
    found = posterior(series, ANNUAL if annual else TRACKED, *expected)
    _note_snow_above(series, found.typical_m, given)
    if annual and given:
        age = last_autumn - consecutive_years(len(picks.names), given)
    elif annual:
        age = np.arange(series.above_m.size)
    else:
        age = stated_ages(found, series.disjoint)
    resolved = annual or bool(known) or found.below(HALF_SEPARATED * separable_m) < MOST_UNRESOLVED
    if not resolved:
        age = np.full(age.size, -1)
    sure = np.where(age >= 0, found.age[np.arange(age.size), age], np.nan)
    sure[list(known)] = 1  # but for rounding
    younger = np.cumsum(found.age, axis=1)
    younger /= np.maximum(younger[:, -1:], np.finfo(float).tiny)
    low, high = ((younger < share).sum(axis=1) for share in NINE_IN_TEN_QUANTILES)
    surface = [-1.0]
    return Dated(
        last_autumn,
        age=np.append(-1, age),
        sure=np.append(1.0, only_falling(sure, list(known))),
        age_low=np.append(surface, np.minimum(low, age)),
        age_high=np.append(surface, np.maximum(high, age)),
        posterior=found,
        above_m=series.above_m,
        resolved=resolved,
    )


def _checked_series(water_m, picks, year, annual, expected, separable_m):
    """`Series` of layers, and the years that the user gave, by the number of the layer.

    ValueError if years contradict the snow between their layers; a warning is given if the expected
    mass does.
    """
    by_name = year if hasattr(year, "items") else {str(picks.names[1]): year}
    given = years_by_layer(picks, {} if year is None else by_name)
    known = {layer - 1: picks.last_autumn - given_year for layer, given_year in given.items()}
    series = replace(median_series(water_m, picks, known), separable_m=separable_m)
    expected_m, expected_error = expected
    if len(known) > 1 or expected_m is not None:
        rates = ANNUAL if annual else TRACKED
        masses = weighted_masses(replace(series, known={}), rates)
        by_layers_m = quantile(*masses, 0.5)
        _check_years(series, by_layers_m, given)
        noted = min(np.log(NOTED_FACTOR), NOTED_SD * np.hypot(log_scatter(*masses), expected_error))
        if expected_m and abs(np.log(by_layers_m / expected_m)) > noted:
            warnings.warn(
                f"expected_m: {expected_m:g} m w.e. a year were expected, with a relative error of "
                f"{expected_error:g}; by the layers alone a typical year has {by_layers_m:.2g}",
                stacklevel=4,
            )
    return series, given


def _note_snow_above(series, typical_m, given):
    """Warn if far more or less snow than typical lies above the uppermost layer of given year."""
    if not given:
        return
    layer, year = next(iter(given.items()))
    years = series.known[layer - 1] + series.elapsed
    found = series.above_m[layer - 1] / typical_m
    differ = abs(found - years) > LEAST_NOTED_YEARS
    if differ and not years / REFUSED_FACTOR < found < years * REFUSED_FACTOR:
        warnings.warn(
            f"year: {year}, {years:.3g} years before the flight, was given for a layer under the "
            f"snow of {found:.2g} typical years",
            stacklevel=4,
        )


def only_falling(sure, named):
    """Probabilities (layer,), lowered where they rise downwards but not towards a named layer.

    An age follows from the nearest certain ages above and below, those of the surface or of named
    layers. The smallest probability on the way to one of the two limits it; the better way counts.
    """
    down, up = sure.copy(), np.zeros_like(sure)
    start = 0
    for stop in [*sorted(named), sure.size]:
        down[start:stop] = np.fmin.accumulate(sure[start:stop])
        if stop < sure.size:
            up[start : stop + 1] = np.fmin.accumulate(sure[start : stop + 1][::-1])[::-1]
        start = stop
    return np.where(np.isnan(sure), np.nan, np.maximum(down, up))


def median_series(water_m, picks, known):
    """`Series` of the mass above picks (layer, range_line) [m w.e.], by medians along track.

    Accumulation changes along track, so masses are divided by a factor of their range line. The
    mass between two layers is the median over the lines that have both; without such a line it is
    the difference of the layers' medians.
    """
    level_m, above_m = _without_line_factors(water_m[1:])
    n_layers = len(level_m)
    span_m = above_m - above_m[:, None]
    there = np.isfinite(level_m)
    disjoint = ~(there[:, None] & there).any(axis=2)
    reach = n_layers if known else MOST_CRUSTS_IN_A_ROW + 2
    for upper in range(n_layers):
        for lower in range(upper + 1, min(n_layers, upper + reach)):
            lines = np.flatnonzero(there[upper] & there[lower])
            if lines.size:
                lines = lines[:: 1 + lines.size // MOST_COMPARED_LINES]
                span_m[upper, lower] = np.median(level_m[lower, lines] - level_m[upper, lines])
    least_m = LEAST_SPAN * np.median(np.abs(np.diff(above_m))) if n_layers > 1 else 0
    span_m = np.where(disjoint, span_m, np.maximum(span_m, least_m))
    with np.errstate(divide="ignore", invalid="ignore"):
        relative = picks.error_s[1:] / picks.below_s[1:]
    error_m = above_m * np.nan_to_num(_median(relative)) / NINE_IN_TEN_SD
    sure = 1 - _median(picks.doubt[1:])
    return Series(above_m, span_m, error_m, disjoint, sure, picks.elapsed, known)


def _without_line_factors(below_m):
    """Masses (layer, range_line), divided by a factor of their line, and their medians by layer.

    The factor is the median over layers of a mass divided by its layer's median.
    """
    log_m = pd.DataFrame(np.log(below_m))
    of_layer = log_m.median(axis=1)
    for _ in range(N_MEDIAN_ROUNDS):
        of_line = log_m.sub(of_layer, axis=0).median()
        of_line -= of_line.median()
        of_layer = log_m.sub(of_line, axis=1).median(axis=1)
    return below_m / np.exp(of_line.to_numpy()), np.exp(of_layer.to_numpy())


def _median(values):
    return pd.DataFrame(values).median(axis=1).to_numpy()


def years_by_layer(picks, year):
    """Years that the user gave, by the number of the layer, from the uppermost down."""
    for each in year.values():
        check_count("year", each, 0)
    given = {layer: year[name] for layer, name in enumerate(picks.names) if name in year}
    falls = np.diff([picks.last_autumn + 1, *given.values()]) < 0
    if len(given) != len(year) or 0 in given or not falls.all():
        msg = (
            f"year: expected names of layers with picks, {', '.join(picks.names[1:])}, and years "
            f"that fall from each to the next, none after {picks.last_autumn}, found {year}"
        )
        raise ValueError(msg)
    return given


def consecutive_years(n_layers, given):
    """Years of all layers below the surface: each layer is one year older than the one above."""
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


def _check_years(series, typical_m, given):
    """Refuse given years if far more or less snow than typical lies between them."""
    picks = list(series.known)
    years = -np.diff(list(given.values()))
    found = series.span_m[picks[:-1], picks[1:]] / typical_m
    if ((found < years / REFUSED_FACTOR) | (found > years * REFUSED_FACTOR)).any():
        msg = (
            f"year: from name to name {years} years contradict their snow, that of "
            f"{found.round(1)} typical years"
        )
        raise ValueError(msg)
