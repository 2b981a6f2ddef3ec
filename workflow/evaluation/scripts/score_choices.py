"""Edge scores without each part of the scene model, with the share of scenes told from observed."""

import pandas as pd
from main_path import job

from evaluation.lib.choices import with_told_apart
from snowsim.io.files import read_table, write_table

with job(snakemake):
    paths = zip(snakemake.input.scores, snakemake.input.two_sample, strict=True)
    scores = [with_told_apart(read_table(of), read_table(told)) for of, told in paths]
    write_table(snakemake.output.scores, pd.concat(scores))
    write_table(snakemake.output.depths, pd.concat(map(read_table, snakemake.input.depths)))
