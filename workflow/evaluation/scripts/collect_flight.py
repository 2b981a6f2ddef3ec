"""Edge counts of all trainings of one flight in one table."""

import pandas as pd
from main_path import run

from snowsim.io.files import read_table, write_table


def collect_flight(counts, table, *, runs):
    tables = []
    for path, (name, replica) in zip(counts, runs, strict=True):
        tables.append(read_table(path).assign(run=name, replica=replica))
    write_table(table, pd.concat(tables, ignore_index=True))


run(collect_flight)
