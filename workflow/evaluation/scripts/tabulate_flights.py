"""Worth of training sets over flights."""

import pandas as pd
from main_path import job

from evaluation.lib.flight_scores import worth_table
from snowsim.io.files import read_table, write_table

with job(snakemake):
    flights = zip(snakemake.input.scores, snakemake.params.flights, strict=True)
    scores = [read_table(path).assign(flight=flight) for path, flight in flights]
    write_table(snakemake.output.worth, worth_table(pd.concat(scores)))
