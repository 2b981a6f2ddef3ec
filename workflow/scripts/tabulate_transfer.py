"""Scores of all trackers on all flights never seen, and their means over flights."""

import pandas as pd
from job import run

from snowsim.io.files import read_table, write_table


def tabulate(scores, reliability, table, curves):
    found = pd.concat([read_table(path) for path in scores])
    mean = found.groupby("tracker", sort=False).mean(numeric_only=True).reset_index()
    write_table(table, pd.concat([found, mean.assign(flight="mean")]))
    write_table(curves, pd.concat([read_table(path) for path in reliability]))


run(tabulate)
