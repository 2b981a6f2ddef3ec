"""Worth of training sets over flights, and the share of layers found by depth: tables, figures."""

import pandas as pd
from main_path import job

from evaluation.lib.figures.studies import flights_depths, flights_worth
from evaluation.lib.figures.style import save_figure
from evaluation.lib.flight_scores import found_by_depth, worth_table
from snowsim.io.files import read_table, write_table


def of_flights(paths):
    """One table of those of all flights."""
    flights = zip(paths, snakemake.params.flights, strict=True)
    return pd.concat([read_table(path).assign(flight=flight) for path, flight in flights])


with job(snakemake):
    scores = of_flights(snakemake.input.scores)
    write_table(snakemake.output.scores, scores)
    worth = worth_table(scores)
    write_table(snakemake.output.worth, worth)
    depths = of_flights(snakemake.input.depths)
    write_table(snakemake.output.depths, depths)
    note = snakemake.params.source
    save_figure(snakemake.output.flights_worth_svg, flights_worth(worth), note)
    save_figure(snakemake.output.flights_depths_svg, flights_depths(found_by_depth(depths)), note)
