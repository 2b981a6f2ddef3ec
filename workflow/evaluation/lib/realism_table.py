"""The table of realism: the flight beside real material and printed figures; how many rows agree.

A row agrees where flight and real material differ by no more than real frames or cores differ from
each other on average, or than the bootstrap interval of the flight, whichever is larger.
"""

from itertools import combinations

import numpy as np
import pandas as pd

N_BOOTSTRAP = 500


def interval(units, statistic=np.nanmedian, *, rng):
    """A statistic of frames, places or scenes, and its 95 % interval by the bootstrap over them."""
    units = [unit for unit in units if not (isinstance(unit, float) and np.isnan(unit))]
    value = statistic(units) if units else np.nan
    if np.isnan(value):
        return np.nan, np.nan, np.nan
    draws = rng.integers(len(units), size=(N_BOOTSTRAP, len(units)))
    redrawn = [statistic([units[i] for i in draw]) for draw in draws]
    low, high = np.nanpercentile(redrawn, [2.5, 97.5])
    return value, low, high


def realism_table(flight, real, known):
    """A row for every quantity of either side.

    `flight`: value, lowest and highest of its interval by quantity; `real`: a table of quantity,
    frame, value; `known`: what realism_rows.yaml says of quantities.
    """
    quantities = dict.fromkeys([*flight, *real["quantity"], *known["printed"]])
    rows = []
    for quantity in quantities:
        about = about_quantity(quantity, known)
        of_real = real[real["quantity"] == quantity].dropna()
        value, low, high = flight.get(quantity, (np.nan, np.nan, np.nan))
        values = about.get("values", of_real["value"].tolist())
        frames = [f"{frame.frame}: {frame.value:.3g}" for frame in of_real.itertuples()]
        reason = about.get("reason", "")
        if not reason and not values:
            reason = "no such value in the real frames"
        if not reason and not np.isfinite(value):
            reason = "no such value in the flight"
        difference = tolerated = np.nan
        agrees = ""
        if not reason:
            difference, tolerated = compare(value, high - low, values)
            agrees = "yes" if abs(difference) <= tolerated else "no"
        row = {
            "quantity": quantity,
            "unit": about["unit"],
            "value": value,
            "low": low,
            "high": high,
            "real_low": min(values, default=np.nan),
            "real_high": max(values, default=np.nan),
            "real_frames": "; ".join(frames),
            "difference": difference,
            "tolerated": tolerated,
            "comparable": not reason,
            "agrees": agrees,
            "reason": reason,
            "source": known["sources"][about["source"]],
        }
        rows.append(row)
    return pd.DataFrame(rows)


def about_quantity(quantity, known):
    """What realism_rows.yaml says of a quantity: of its name, else of the beginning of its name."""
    if quantity in known["printed"]:
        return known["printed"][quantity]
    return next(row for begin, row in known["measured"].items() if quantity.startswith(begin))


def compare(value, width, values):
    """Difference of a value from the median of real ones, and what is tolerated.

    That is their own mean difference, or an interval's width.
    """
    differences = [abs(one - other) for one, other in combinations(values, 2)]
    typical = np.mean(differences) if differences else 0
    return value - np.median(values), max(typical, width)


def summary(table):
    """One line: how many rows have both numbers and can be compared, and how many agree."""
    n_comparable = table["comparable"].sum()
    n_agreeing = (table["agrees"] == "yes").sum()
    share = n_agreeing / max(1, n_comparable)
    return f"{n_comparable} quantities comparable, {n_agreeing} agree ({share:.0%})"
