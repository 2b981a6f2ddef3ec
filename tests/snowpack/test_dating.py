"""The posterior of ages against the sum over all sequences, one by one, its numbers written out."""

import itertools

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.stats import norm

from snowsim.snowpack import dating
from snowsim.snowpack.dating import (
    ANNUAL,
    TRACKED,
    Rates,
    Series,
    posterior,
    stated_ages,
    typical_mass,
)

MOST = 14  # years of a step, and age of the first horizon


def series_of(above_m, known=(), apart=(), elapsed=0.6, error=0.03, separable_m=0.0):
    above_m = np.array(above_m)
    shares_none = np.zeros((above_m.size, above_m.size), bool)
    for pair in apart:
        shares_none[pair] = shares_none[pair[::-1]] = True
    confidence = np.linspace(0.9, 0.6, above_m.size)
    return Series(
        above_m,
        above_m - above_m[:, None],
        error * above_m,
        shares_none,
        confidence,
        elapsed,
        dict(known),
        separable_m,
    )


def lognormal(ratio, variance):
    return np.exp(-(np.log(ratio) ** 2) / (2 * variance)) / np.sqrt(2 * np.pi * variance)


def step_of(series, grid, i, j, n):
    """Probability of n years from pick i to j, both horizons, (point,)."""
    m, s, missed, _ = grid
    mass = series.span_m[i, j]
    one = (1 - missed) * missed ** max(n - 1, 0)
    gap = 0.98 * one + 0.02 * (n > 1) / max(n * (n - 1), 1)
    if series.disjoint[i, j]:
        share = 0.5 if n == 0 else 0.5 * gap
        density = norm.pdf(mass / m, n, np.sqrt(n * s**2 + 0.2**2)) / m
        return share * density * series.confidence[j]
    scatter = 0.5 if {i, j} <= set(series.known) else s
    error = (series.error_m[i] ** 2 + series.error_m[j] ** 2) / mass**2
    density = lognormal(mass / (n * m), scatter**2 / n + error) / mass
    return gap * density * series.confidence[j]


def start_of(series, grid, hidden, first, begun):
    """Probability of the first horizon at an age, (point,)."""
    m, s, missed, crusts = grid
    if series.known:
        return 1.0 if 0 in series.known else series.confidence[first] * (crusts / m) ** first
    years = max(series.elapsed + begun, 0.1)
    above = series.above_m[first]
    variance = s**2 / years + (0.1 / years) ** 2 + (series.error_m[first] / above) ** 2
    density = lognormal(above / (years * m), variance) / above
    for age in range(begun):
        above_m = max(series.elapsed + age, 0.1) * m
        in_tail = hidden * norm.cdf(np.log(0.34 / above_m))
        density = density * (1 - (1 - missed) * (1 - in_tail))
    return series.confidence[first] * density * (crusts / m) ** first * np.exp(-crusts * years)


def end_of(series, grid, last):
    """Probability of no horizon from the last one to the deepest pick, (point,)."""
    m, s, missed, crusts = grid
    n_none = len(series.above_m) - 1 - last
    mass = series.span_m[last, -1]
    longer = missed ** (3 * MOST)
    for n in range(1, 3 * MOST + 1):
        within = norm.cdf(np.log(n * m / mass) * np.sqrt(n) / s) if n_none else 1
        longer = longer + (1 - missed) * missed ** (n - 1) * within
    return longer * (crusts / m) ** n_none * np.exp(-crusts * mass / m)


def one_by_one(series, scatters, missing, crusts_a_year, hidden, prior=lambda mass: 1):
    """Probability of every age of every pick, (pick, age)."""
    n_picks = series.above_m.size
    unit_m = np.median(np.diff(series.above_m)) if not series.disjoint.any() else 0.3
    masses = np.geomspace(0.3, 2.5, 48) * unit_m
    values = np.meshgrid(masses, scatters, missing, crusts_a_year)
    m, s, missed, crusts = (value.ravel() for value in values)
    if series.separable_m:
        separated = norm.cdf(np.log(m / (2.5 * series.separable_m)) / 0.4)
        missed = 1 - (1 - missed) * np.maximum(separated, 0.01)
    grid = (m, s, missed, crusts)
    age = np.zeros((n_picks, n_picks * MOST + MOST))
    total = 0.0
    some = (itertools.combinations(range(n_picks), k) for k in range(1, n_picks + 1))
    for horizons in itertools.chain.from_iterable(some):
        if not set(series.known) <= set(horizons):
            continue
        pairs = [*itertools.pairwise(horizons)]
        steps = [
            {
                n: step_of(series, grid, i, j, n)
                * (crusts / m) ** (j - i - 1)
                * np.exp(-crusts * n)
                for n in range(0 if series.disjoint[i, j] else 1, MOST)
            }
            for i, j in pairs
        ]
        end = end_of(series, grid, horizons[-1]) * prior(m)
        for begun in range(MOST):
            start = start_of(series, grid, hidden, horizons[0], begun)
            for chosen in itertools.product(*steps):
                told = dict(zip(horizons, begun + np.cumsum([0, *chosen]), strict=True))
                if any(told[pick] != known for pick, known in series.known.items()):
                    continue
                weight = start * end
                for own, n in zip(steps, chosen, strict=True):
                    weight = weight * own[n]
                total += weight.sum()
                for pick, own in told.items():
                    age[pick, own] += weight.sum()
    return age / total


RATES = {
    "tracked": (TRACKED, (0.2, 0.25), (0.03, 0.1, 0.3), (0.01, 0.05, 0.2), 1.0),
    "annual": (ANNUAL, (0.25,), (0.002,), (0.002,), 0.01),
}


def assert_same(found, slow):
    """Points of the grid below 1e-4 of the most probable one are left out."""
    n_ages = min(slow.shape[1], found.shape[1])
    assert_allclose(found[:, :n_ages], slow[:, :n_ages], atol=2e-3)


@pytest.mark.parametrize(
    ("rates", "series"),
    [
        ("tracked", series_of([0.35, 0.62, 0.95])),
        ("tracked", series_of([0.8, 0.95, 1.7])),
        ("tracked", series_of([0.02, 0.33, 0.6], elapsed=0.02)),
        ("tracked", series_of([0.35, 0.62, 1.2], known={1: 2})),
        ("tracked", series_of([0.35, 0.62, 1.5], known={0: 1, 1: 2})),
        ("tracked", series_of([0.35, 0.62, 0.95], separable_m=0.15)),
        ("annual", series_of([0.2, 0.52, 1.1])),
        # The first pick may lie below a hidden horizon, the second may be a crust.
        ("annual", series_of([0.45, 0.75, 1.05])),
        ("annual", series_of([0.3, 0.345, 0.65])),
    ],
)
def test_probabilities_of_ages_are_those_of_all_sequences_one_by_one(rates, series):
    rates, *numbers = RATES[rates]
    slow = one_by_one(series, *numbers)
    found = posterior(series, rates).age
    assert_same(found, slow)


def test_layers_that_no_line_shares_may_be_of_one_year():
    series = series_of([0.3, 0.6, 0.64, 0.9], apart=[(1, 2)])
    slow = one_by_one(series, *RATES["tracked"][1:])
    found = posterior(series).age
    assert_same(found, slow)
    ages = stated_ages(posterior(series), series.disjoint)
    assert ages[1] == ages[2]


def test_an_expected_mass_is_a_lognormal_prior():
    series = series_of([0.35, 0.62, 1.4])
    numbers = RATES["tracked"][1:]
    slow = one_by_one(series, *numbers, prior=lambda m: np.exp(-(np.log(m / 0.5) ** 2) / 0.08))
    found = posterior(series, TRACKED, 0.5, 0.2).age
    # The grid reaches as far with the expected mass as without.
    assert_same(found, slow)


def test_six_crusts_between_two_horizons_are_left_out():
    year_m = 0.15 + 0.3 * np.arange(15)
    crust_m = year_m[4] + 0.3 * np.arange(1, 7) / 7
    above_m = np.sort(np.append(year_m, crust_m))
    series = series_of(above_m, elapsed=0.5, error=0.0)
    found = posterior(series)
    expected = np.where(np.isin(above_m, year_m), np.searchsorted(year_m, above_m), -1)
    assert (stated_ages(found, series.disjoint) == expected).all()
    # A step of the grid of masses is 5 %.
    assert_allclose(found.typical_m, 0.3, rtol=0.05)


def test_a_long_series_is_dated_without_underflow():
    above_m = 0.15 + 0.3 * np.arange(150)
    found = posterior(series_of(above_m, elapsed=0.5, error=0.0))
    assert (stated_ages(found, np.zeros((150, 150), bool)) == np.arange(150)).all()
    assert (found.age.sum(axis=1) > 0.5).all()


@pytest.mark.parametrize("known", [{0: 0}, {2: 3}, {0: 1, 3: 5}])
def test_what_is_left_out_beside_known_ages_is_negligible(monkeypatch, known):
    series = series_of(np.cumsum([0.35, 0.27, 0.33, 0.6, 0.2, 0.3, 0.28]), known)
    # Of twice the mass that layers have alone: their years are sequences of little weight.
    found = posterior(series, TRACKED, 0.6, 0.1)
    mass_m = typical_mass(series, TRACKED, 0.6, 0.1)
    for name in ("NEGLIGIBLE_NAMED_POINT", "NEGLIGIBLE_STEP", "NEGLIGIBLE_AGE"):
        monkeypatch.setattr(dating, name, 1e-300)
    whole = posterior(series, TRACKED, 0.6, 0.1)
    # Some thousand steps and points of less than 1e-15.
    assert_allclose(found.age, whole.age, atol=1e-12)
    assert_allclose([found.scatter, mass_m], [whole.scatter, whole.typical_m], rtol=1e-12)
    assert whole.weight.size > found.weight.size


def test_no_age_is_lost_where_layers_have_far_less_snow_than_is_expected():
    # Thirty years of .3 m, where the user is sure of 1 m. So thin a year has exp(-8) of the density
    # of a typical one, but a crust has 1e-12. Years of 1 m would be no more than nine.
    rates = Rates(scatter=(0.3,), missed=(0.03,), crusts=(1e-12,))
    series = series_of(0.15 + 0.3 * np.arange(30), elapsed=0.5, error=0.0)
    found = posterior(series, rates, 1.0, 0.01)
    assert (stated_ages(found, series.disjoint) == np.arange(30)).all()
    # Every pick is a horizon: in place of two years, exp(-16), there is one of .6 m and a crust,
    # exp(-1.5) 1e-12, in one of a million cases.
    assert_allclose(found.age.sum(axis=1), 1, atol=1e-5)
