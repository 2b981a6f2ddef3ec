"""What becomes of a claim, and how that follows from differences."""

from dataclasses import dataclass

import numpy as np
from scipy import stats

CONFIRMED = "confirmed"
CONTRADICTED = "contradicted"
OPEN = "not resolved"
MISSING = "no table"


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
    return OPEN if OPEN in outcomes else CONFIRMED


def paired_outcome(differences, unit=""):
    """Outcome of the claim of a positive mean difference by scene, and its numbers as text."""
    mean, low, high = mean_interval(differences)
    n_scenes = np.isfinite(differences).sum()
    unit = unit and f" {unit}"
    text = f"{signed(mean)} [{signed(low)}, {signed(high)}]{unit}, {n_scenes} scenes"
    return side_of_zero(low, high), text


def mean_interval(values):
    """Mean of the finite values and the ends of its 95 % Student t interval; NaN ends below two."""
    values = np.asarray(values, dtype=float)
    values = values[np.isfinite(values)]
    if values.size < 2:
        return (values[0] if values.size else np.nan), np.nan, np.nan
    mean = values.mean()
    quantile = stats.t.ppf(0.975, values.size - 1)
    half = quantile * values.std(ddof=1) / np.sqrt(values.size)
    return mean, mean - half, mean + half


def signed(value):
    """A difference with its sign, three decimals below 1 and two above; a real minus sign."""
    if not np.isfinite(value):
        return "unknown"
    text = f"{value:+.3f}" if abs(value) < 1 else f"{value:+.2f}"
    return text.replace("-", "\N{MINUS SIGN}")
