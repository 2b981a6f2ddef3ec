"""Loss of ODS without each part of the scene model, over flights and trainings."""

import pandas as pd
from main_path import job

from evaluation.lib.choices import choice_table
from snowsim.io.files import read_table, write_table

with job(snakemake):
    flights = zip(snakemake.input.scores, snakemake.params.flights, strict=True)
    scores = [read_table(path).assign(flight=flight) for path, flight in flights]
    write_table(snakemake.output.losses, choice_table(pd.concat(scores)))
