"""What becomes of a claim, and how that follows from differences."""

from dataclasses import dataclass

import numpy as np
from scipy import stats

CONFIRMED, CONTRADICTED, OPEN, MISSING = "confirmed", "contradicted", "not resolved", "no table"


@dataclass(frozen=True)
class Claim:
    """What a run says of one claim."""

    outcome: str
    numbers: str
    rule: str  # how the outcome follows from them
    caveat: str = ""  # what makes the numbers say less than they seem to
    claim: str = ""
    tables: tuple = ()  # names of those it was computed from
    by_construction: bool = False  # it could hardly have come out otherwise: no confirmation


def side_of_zero(low, high):
    """Outcome of the claim "positive" from the ends of an interval."""
    if low > 0:
        return CONFIRMED
    return CONTRADICTED if high < 0 else OPEN


def all_of(outcomes):
    """Outcome of a claim that needs every one of several: contradicted by one, confirmed by all."""
    if CONTRADICTED in outcomes:
        return CONTRADICTED
    return CONFIRMED if set(outcomes) == {CONFIRMED} else OPEN


def paired_outcome(differences, unit=""):
    """Outcome of the claim of a positive mean difference, and its numbers as text, from differences scene by scene."""
    mean, low, high = mean_interval(differences)
    n = np.isfinite(np.asarray(differences, dtype=float)).sum()
    text = f"{signed(mean)} [{signed(low)}, {signed(high)}]{unit and ' ' + unit}, {n} scenes"
    return (OPEN if not np.isfinite(low) else side_of_zero(low, high)), text


def mean_interval(values, level=0.95):
    """Mean of the finite values and the ends of its Student t interval; NaN ends from fewer than two values."""
    values = np.asarray(values, dtype=float)
    values = values[np.isfinite(values)]
    if values.size < 2:
        return (values[0] if values.size else np.nan), np.nan, np.nan
    mean = values.mean()
    half = stats.t.ppf(0.5 + level / 2, values.size - 1) * values.std(ddof=1) / np.sqrt(values.size)
    return mean, mean - half, mean + half


def signed(value):
    """A difference with its sign, three decimals below 1 and two above; a real minus sign."""
    if not np.isfinite(value):
        return "unknown"
    text = f"{value:+.3f}" if abs(value) < 1 else f"{value:+.2f}"
    return text.replace("-", "\N{MINUS SIGN}")
