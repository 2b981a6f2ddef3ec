"""The stability atlas of the estimators: planted flights pushed to where one or both lose what was planted.

A row has `panel, value, estimator, quantity`, mean `error` over layers against what was planted, its `largest`
magnitude, the mean `standard_error` claimed, `unit`, `bound`, the `outcome` and, as `note`, the rule that degraded the
result or the line that refused it. Outcomes: ``within`` the bound, ``beyond`` it, ``refused`` by a ValueError,
``not finite``, which must not be.
"""

import pandas as pd

from snowsim.statistics.stress.borders import sweep_borders
from snowsim.statistics.stress.sweeps import SWEEPS, sweep

COLUMNS = (
    *("panel", "value", "estimator", "quantity", "error", "largest", "standard_error"),
    *("unit", "bound", "outcome", "note"),
)


def draw_atlas(stream, *, share=1.0):
    """Rows of all panels as a table.

    Parameters
    ----------
    stream : callable
        Gives the random generator of a panel and a value on it.
    share : float
        Share of the values of each sweep to run, ends included; borders are always run.

    Returns
    -------
    pandas.DataFrame
        With `COLUMNS`.
    """
    rows = [row for panel in SWEEPS for row in sweep(panel, stream, share=share)]
    return pd.DataFrame([*rows, *sweep_borders(stream)], columns=list(COLUMNS))
