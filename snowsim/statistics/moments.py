"""Means of values some of which are missing, standard errors, and the jackknife."""

from dataclasses import dataclass, fields

import numpy as np

DB = 10 / np.log(10)  # decibels in one neper of power
# Binary digits of statistics, 1e-6, on which processors agree: sums and fits leave at most 1e-11.
SHARED_BITS = 20
ERROR_BITS = 10  # and of standard errors, 1e-3: jackknives leave 3e-7
SPECTRUM_BITS = 10  # and of Doppler spectra: phases drawn in float32 leave 2e-6
# Of least squares, so that fits end where processors agree to 1e-11: complex steps have no error
# of differences, and a dogbox reaches a bound.
TO_THE_LAST_DIGITS = {
    "method": "dogbox",
    "jac": "cs",
    "ftol": 1e-15,
    "xtol": 1e-15,
    "gtol": 1e-15,
}


def decibels(power):
    """Power in dB, NaN where it is not positive."""
    return DB * np.log(np.where(power > 0, power, np.nan))


def mean_where(held, values, axis):
    """Mean of the values where `held`, NaN where there is none."""
    n = held.sum(axis=axis)
    total = np.where(held, values, 0).sum(axis=axis)
    return np.where(n > 0, total / np.maximum(n, 1), np.nan)


@dataclass(frozen=True)
class Moments:
    """Mean over groups, its standard error, and the number of values, by layer.

    They are 0 where there is none.
    """

    mean: np.ndarray
    standard_error: np.ndarray
    n: np.ndarray


def nan_moments(values):
    """`Moments` of values (group, layer), NaN where missing."""
    known = np.isfinite(values)
    n = known.sum(axis=0)
    mean = np.nan_to_num(mean_where(known, values, axis=0))
    squares = np.where(known, (values - mean) ** 2, 0).sum(axis=0)
    deviation = np.sqrt(squares / np.maximum(n - 1, 1))
    # A single value is taken as its own scatter.
    deviation = np.where(n > 1, deviation, np.abs(mean))
    return Moments(mean, deviation / np.sqrt(np.maximum(n, 1)), n)


@dataclass(frozen=True)
class Jackknifed:
    """Values of an estimate by name, their standard errors, and the names of what is missing."""

    values: dict
    errors: dict
    missing: list


def jackknife(estimator, part_of):
    """`Jackknifed` of an estimator that returns a dataclass.

    It is handed the frames to use, bool (frame,).
    Standard errors follow from leaving out one part of the flight at a time, `part_of (frame,)`.
    The defaults of the dataclass stand in for what is not finite, which has no error.
    """
    whole = estimator(np.ones(part_of.size, dtype=bool))
    parts = np.unique(part_of)
    without = [estimator(part_of != part) for part in parts] if parts.size > 1 else []
    result = Jackknifed({}, {}, [])
    for field in fields(whole):
        name = field.name
        value = getattr(whole, name)
        known = np.isfinite(value)
        if not np.all(known):
            result.missing.append(name)
        result.values[name] = np.where(known, value, field.default)
        error = _delete_one_error([getattr(one, name) for one in without])
        # NaN where the flight without one of its parts is too short.
        result.errors[name] = np.where(known & np.isfinite(error), error, 0.0)
    return result


def _delete_one_error(estimates):
    """Standard error from estimates that each leave out one of all parts; 0 if there is none."""
    n = len(estimates)
    if n == 0:
        return 0.0
    # Part by part, so that the sum does not depend on how many values there are.
    mean = sum(estimates) / n
    variance = sum(np.square(one - mean) for one in estimates) / n
    return np.sqrt((n - 1) * variance)
