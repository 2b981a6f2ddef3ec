"""Distributions of the flight beside labels and renders, tests of normality, sum of layers."""

import pandas as pd
from main_path import run

from evaluation.lib import validation
from snowsim.io.files import read_dataset, read_table, write_table
from snowsim.seeding import random_stream
from snowsim.statistics import merge, summary_from_dataset


def tabulate_validation(
    summaries,
    statistics,
    rendered,
    label_layers,
    label_histograms,
    thickness,
    tests,
    distributions,
    superposition,
    tracked_power,
    independence,
    *,
    seed,
):
    summary = merge(summary_from_dataset(read_dataset(path)) for path in summaries)
    flight = read_dataset(statistics)
    labels = [read_table(label_layers), read_table(label_histograms)]
    edges = flight["zone_edge_bins"].values
    rng = random_stream(seed, "tabulate_validation")
    tables = validation.validate(summary, flight, read_dataset(rendered), labels, edges, rng=rng)
    write_table(thickness, tables["thickness"])
    write_table(tests, tables["tests"])
    write_table(distributions, tables["distributions"])
    write_table(superposition, validation.superposition(summary, flight))
    write_table(independence, validation.independence(summary, flight))
    # Quantiles of tracked peak power beside those of the Gamma law of as many looks.
    power = {
        "probability": flight["probability"].values,
        "gamma": flight["gamma_quantile"].values,
        "tracked": flight["tracked_power_quantile"].values,
        "n_looks": float(flight.attrs["n_looks"]),
    }
    write_table(tracked_power, pd.DataFrame(power))


run(tabulate_validation)
