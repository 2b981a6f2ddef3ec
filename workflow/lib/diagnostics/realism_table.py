"""The table of realism: the flight beside real material and printed figures, and how many rows agree.

A row agrees where flight and real material differ by no more than real frames or cores differ from
each other on average, or than the bootstrap interval of the flight, whichever is larger.
"""

from itertools import combinations

import numpy as np
import pandas as pd

N_BOOTSTRAP = 500
COLUMNS = "quantity unit value low high real_low real_high real_frames difference tolerated comparable agrees reason source"


def interval(units, statistic=np.nanmedian, *, rng):
    """A statistic of frames, places or scenes, and its 95 % interval by the bootstrap over them."""
    units = [unit for unit in units if not (isinstance(unit, float) and np.isnan(unit))]
    value = statistic(units) if units else np.nan
    if np.isnan(value):
        return np.nan, np.nan, np.nan
    draws = rng.integers(len(units), size=(N_BOOTSTRAP, len(units)))
    return (
        value,
        *np.nanpercentile([statistic([units[i] for i in draw]) for draw in draws], [2.5, 97.5]),
    )


def realism_table(flight, real, known):
    """A row for every quantity of either side.

    `flight`: value, lowest and highest of its interval by quantity; `real`: a table of quantity,
    frame, value; `known`: what realism_rows.yaml says of quantities.
    """
    rows = []
    for quantity in dict.fromkeys([*flight, *real["quantity"], *known["printed"]]):
        value, low, high = flight.get(quantity, (np.nan,) * 3)
        group = real[real["quantity"] == quantity].dropna()
        frames = "; ".join(f"{row.frame}: {row.value:.3g}" for row in group.itertuples())
        row = known["printed"].get(quantity)
        row = row or next(
            row for begin, row in known["measured"].items() if quantity.startswith(begin)
        )
        values = row.get("values", group["value"].tolist())
        reason = row.get("reason", "")
        if not reason and not (np.isfinite(value) and values):
            reason = f"no such value in the {'flight' if values else 'real frames'}"
        ends = (min(values), max(values)) if values else (np.nan, np.nan)
        difference, tolerated = (
            compare(value, high - low, values) if not reason else (np.nan, np.nan)
        )
        agrees = "" if reason else "yes" if abs(difference) <= tolerated else "no"
        source = known["sources"][row["source"]]
        compared = (difference, tolerated, not reason, agrees, reason)
        rows.append([quantity, row["unit"], value, low, high, *ends, frames, *compared, source])
    return pd.DataFrame(rows, columns=COLUMNS.split())


def compare(value, width, values):
    """Difference of a value from the median of real ones, and what is tolerated: their own, or an interval's width."""
    differences = [abs(one - other) for one, other in combinations(values, 2)]
    return value - np.median(values), max(np.mean(differences) if differences else 0, width)


def summary(table):
    """One line: how many rows have both numbers and can be held against each other, and how many agree."""
    comparable, agreeing = table["comparable"].sum(), (table["agrees"] == "yes").sum()
    return f"{comparable} quantities comparable, {agreeing} agree ({agreeing / max(1, comparable):.0%})"
