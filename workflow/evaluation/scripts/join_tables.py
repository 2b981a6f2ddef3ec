"""Tables of the same columns, one below the other."""

import pandas as pd
from main_path import job

from snowsim.io.files import read_table, write_table

with job(snakemake):
    for name, path in snakemake.output.items():
        write_table(path, pd.concat(map(read_table, snakemake.input[name])))
