"""Means with intervals, and numbers as the report writes them."""

import numpy as np
from scipy import stats


def mean_interval(values, level=0.95):
    """Mean of the finite values and the ends of its Student t interval, three floats; NaN ends from fewer than two."""
    values = np.asarray(values, dtype=float)
    values = values[np.isfinite(values)]
    if values.size == 0:
        return np.nan, np.nan, np.nan
    mean = values.mean()
    if values.size < 2:
        return mean, np.nan, np.nan
    half = stats.t.ppf(0.5 + level / 2, values.size - 1) * values.std(ddof=1) / np.sqrt(values.size)
    return mean, mean - half, mean + half


def signed(value):
    """A difference with its sign, three decimals below 1 and two above; a real minus sign."""
    if not np.isfinite(value):
        return "unknown"
    text = f"{value:+.3f}" if abs(value) < 1 else f"{value:+.2f}"
    return text.replace("-", "\N{MINUS SIGN}")
