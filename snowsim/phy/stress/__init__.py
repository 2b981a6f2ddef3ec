"""The stability atlas: scenes pushed to where ways of computing them fail, the public functions among them.

A row has ``setting, value, method, error_db, limit_db, outcome``: the sweep, where on it, what computed, how far off,
how far it may be off, and ``within`` that limit, ``refused`` by a ValueError, or ``wrong``.
"""

import pandas as pd

from snowsim.phy.stress.borders import sweep_borders
from snowsim.phy.stress.power import (
    sweep_decay,
    sweep_position,
    sweep_power_ratio,
    sweep_size,
    sweep_spacing,
    sweep_tolerance,
    sweep_variance,
)
from snowsim.phy.stress.speckle import sweep_looks

# What the package offers, of which nothing may be wrong; all other methods are there to fail.
PUBLIC = ("exact", "planned", "render", "looks", "gamma", "cube", "quantile")
SWEEPS_OF_POWER = (
    sweep_decay,
    sweep_variance,
    sweep_position,
    sweep_spacing,
    sweep_power_ratio,
    sweep_tolerance,
    sweep_size,
)
SWEEPS_OF_DRAWS = (sweep_looks, sweep_borders)


def draw_atlas(*, rng):
    """Rows of all sweeps as a table."""
    rows = [row for sweep in SWEEPS_OF_POWER for row in sweep()]
    return pd.DataFrame(rows + [row for sweep in SWEEPS_OF_DRAWS for row in sweep(rng=rng)])


def safe_regions(atlas):
    """Where each method of each sweep over numbers is within its limit, between which values.

    Parameters
    ----------
    atlas : pandas.DataFrame
        Of `draw_atlas`.

    Returns
    -------
    pandas.DataFrame
        ``setting, method, first_safe, last_safe, n_within, n_refused, n_wrong``: ends of the longest run of values
        without a wrong one, refusals at its ends left out; empty where no value is within.
    """
    rows = []
    for (setting, method), sweep in atlas.groupby(["setting", "method"], sort=False):
        counts = {f"n_{name}": int((sweep["outcome"] == name).sum()) for name in ("within", "refused", "wrong")}
        safe = pd.DataFrame()
        if pd.api.types.is_number(sweep["value"].iloc[0]):
            sweep = sweep.sort_values("value", kind="stable")
            run = (sweep["outcome"] == "wrong").cumsum()
            within = sweep[sweep["outcome"] == "within"]
            runs = [rows for _, rows in within.groupby(run)]
            safe = max(runs, key=len, default=safe)
        ends = {} if safe.empty else {"first_safe": safe["value"].iloc[0], "last_safe": safe["value"].iloc[-1]}
        rows.append({"setting": setting, "method": method, "first_safe": None, "last_safe": None} | ends | counts)
    return pd.DataFrame(rows)
