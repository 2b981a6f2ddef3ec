"""Means of values some of which are missing, and decibels."""

import numpy as np

DB = 10 / np.log(10)  # decibels in one neper of power
# Binary digits of statistics, 1.5e-5, on which processors agree: sums and fits leave at most 1e-11,
# fading that is longer than a block 1e-7.
SHARED_BITS = 16
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


def known_mean(values, axis=None):
    """Mean of the known values, NaN where there is none."""
    known = np.isfinite(values)
    n = known.sum(axis=axis)
    total = np.where(known, values, 0).sum(axis=axis)
    return np.where(n > 0, total / np.maximum(n, 1), np.nan)
