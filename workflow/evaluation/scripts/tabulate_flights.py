"""Scores over flights, the learning curve, and what was drawn for each flight."""

import pandas as pd
from main_path import progress, run

from evaluation.lib.flight_scores import (
    compare_over_flights,
    curve_table,
    errors_in_flight,
    pairs_of,
    score_rows,
    stacked_runs,
)
from evaluation.lib.flights import draw_reference, drawn_rows
from snowsim.io.files import read_table, write_table
from snowsim.seeding import random_stream

CURVE = ["flight", "training_set", "n_scenes", "ods"]


def tabulate_flights(
    counts, few, scores, worth, curve, drawn,
    *, flights, reference, numbers, n_bootstrap, seed,
):  # fmt: skip
    pairs = pairs_of(numbers)
    scored = []
    errors = {}
    curves = [pd.DataFrame(columns=CURVE)]
    files = list(zip(counts, few, flights, strict=True))
    for path, path_to_few, flight in progress(files, "flights"):
        runs = stacked_runs(read_table(path))
        scored.append(score_rows(flight, runs))
        rng = random_stream(seed, "tabulate_flights", flight)
        for name, base in pairs:
            if name in runs:
                pair = (runs[name], runs[base])
                found = errors_in_flight(*pair, n_bootstrap=n_bootstrap, rng=rng)
                errors[flight, name, base] = found
        drawn_from = read_table(path_to_few)
        if len(drawn_from) > 1:
            curves.append(curve_table(flight, runs, drawn_from, n_bootstrap=n_bootstrap, rng=rng))
    table = pd.concat(scored)
    write_table(scores, table)
    write_table(worth, compare_over_flights(table, errors, pairs))
    write_table(curve, pd.concat(curves[1:] or curves))
    write_table(drawn, pd.DataFrame([drawn_rows(draw_reference(reference, f), f) for f in flights]))


run(tabulate_flights)
