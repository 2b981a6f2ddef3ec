"""Edge counts of all trainings of one flight in one table; what could be drawn of few scenes."""

import pandas as pd
from main_path import run

from snowsim.io.files import read_table, write_table

FEW = ["n_scenes", "radiometry", "reason"]  # also where there is no learning curve


def collect_flight(counts, few_counts, choices, table, few, *, runs):
    tables = []
    for path, (name, replica) in zip([*counts, *few_counts], runs, strict=True):
        tables.append(read_table(path).assign(run=name, replica=replica))
    write_table(table, pd.concat(tables, ignore_index=True))
    rows = [pd.DataFrame(columns=FEW), *map(read_table, choices)]
    write_table(few, pd.concat(rows[1:] or rows, ignore_index=True))


run(collect_flight)
