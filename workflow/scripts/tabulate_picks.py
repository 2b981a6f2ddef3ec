"""What was picked in all own frames; frames that could not be tracked are said loudly."""

import sys

import pandas as pd
from job import run
from tqdm import tqdm

from snowsim.io.files import read_table, write_table


def tabulate(tables, table):
    found = pd.concat([read_table(path) for path in tables])
    write_table(table, found)
    failed = found.loc[~found["tracked"], "frame"].tolist()
    if failed:
        told = f"{len(failed)} of {len(found)} frames could not be tracked, {failed[0]} the first"
        tqdm.write(f"warning: {told}: {table} says why", file=sys.stderr)


run(tabulate)
