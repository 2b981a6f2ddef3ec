"""Table of the picks of all own frames, with a warning if frames could not be tracked."""

import sys
from pathlib import Path

import pandas as pd
from job import job
from tqdm import tqdm

from snowsim.io.files import read_table, write_table

with job(snakemake):
    tables = [read_table(Path(folder) / "frames.csv") for folder in snakemake.input.folders]
    found = pd.concat(tables)
    table = snakemake.output.table
    write_table(table, found)
    failed = found.loc[~found["tracked"], "frame"].tolist()
    if failed:
        told = f"{len(failed)} of {len(found)} frames could not be tracked, {failed[0]} the first"
        tqdm.write(f"warning: {told}: {table} says why", file=sys.stderr)
