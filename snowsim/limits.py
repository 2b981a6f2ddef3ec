"""Checks of arguments, made where they enter the public interface."""

from numbers import Integral

import numpy as np

from snowsim.constants import STATISTICS_CONTENT

# Range bins [s] and distances of range lines [m] that a radar over snow may have. They refuse
# nanoseconds in place of seconds, and kilometres or degrees in place of metres.
BIN_S_LIMITS = (1e-12, 1e-6)
LINE_SPACING_M_LIMITS = (1e-2, 1e4)


def check_values(name, values, low=-np.inf, high=np.inf, *, above=False, number=False):
    """Raise ValueError, with the first bad value, unless all are finite and within limits.

    With `above`, values must be greater than `low`. With `number`, there must be one number only.
    """
    values = np.asarray(values)
    if number and values.ndim:
        msg = f"{name} must be one number, got an array of shape {values.shape}"
        raise ValueError(msg)
    bad = np.ones(values.shape, dtype=bool)
    if values.dtype.kind in "fiu":
        held = (values > low) if above else (values >= low)
        bad = ~(held & np.isfinite(values) & (values <= high))
    if bad.any():
        place = tuple(np.argwhere(bad)[0].tolist())
        rule = "finite"
        if low > -np.inf:
            rule += f", {'above' if above else 'at least'} {low:g}"
        if high < np.inf:
            rule += f", at most {high:g}"
        at = f" at {place}" if place else ""
        found = values[place]
        got = f"{found:g}" if values.dtype.kind in "fiu" else repr(np.asarray(found).tolist())
        msg = f"{name} must be {rule}, got {got}{at}"
        raise ValueError(msg)


def check_unmasked(name, values):
    """Raise ValueError if values are masked: most functions of numpy take what the mask hides."""
    if np.ma.is_masked(values):
        n_masked = np.ma.count_masked(values)
        msg = f"{name} must not be masked, got {n_masked} masked values: NaN marks absent ones"
        raise ValueError(msg)


def check_count(name, value, least=1):
    """Raise ValueError unless a value is a whole number and at least `least`."""
    if not isinstance(value, Integral) or isinstance(value, bool) or value < least:
        got = value if isinstance(value, Integral) else repr(value)
        msg = f"{name} must be a whole number of at least {least}, got {got}"
        raise ValueError(msg)


def check_content(dataset, content, remedy, where):
    """Raise ValueError, naming `where` and the remedy, unless a dataset has this `content`."""
    found = dataset.attrs.get("content", "none")
    if found != content:
        msg = f"{where}: content must be '{content}', got '{found}': {remedy}"
        raise ValueError(msg)


def check_statistics(statistics, where="statistics"):
    """Raise ValueError, naming `where`, unless flight statistics are of this version."""
    check_content(statistics, STATISTICS_CONTENT, "fit them again", where)
