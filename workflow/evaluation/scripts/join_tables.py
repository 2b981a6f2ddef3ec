"""One table of several."""

import pandas as pd
from main_path import job

from snowsim.io.files import read_table, write_table

with job(snakemake):
    write_table(snakemake.output[0], pd.concat(map(read_table, snakemake.input)))
