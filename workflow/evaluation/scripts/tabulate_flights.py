"""Worth of training sets over flights: table and figure."""

import pandas as pd
from main_path import job

from evaluation.lib.figures.study_flights import flights_worth
from evaluation.lib.figures.style import save_figure
from evaluation.lib.flight_scores import worth_table
from snowsim.io.files import read_table, write_table

with job(snakemake):
    flights = zip(snakemake.input.scores, snakemake.params.flights, strict=True)
    scores = [read_table(path).assign(flight=flight) for path, flight in flights]
    worth = worth_table(pd.concat(scores))
    write_table(snakemake.output.worth, worth)
    figure = flights_worth(worth)
    save_figure(snakemake.output.flights_worth_svg, figure, snakemake.params.source)
