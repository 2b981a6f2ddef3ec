"""Tables of the accuracy page that the study of flights fills."""

import numpy as np
from table_parts import RUNS, difference, digits, markdown, read, share

FLIGHTS = "studies/flights"
NAMES = {
    **RUNS,
    "rd_full": "RD, full labels",
    "rd_full_pd": "RD, full labels, +PD",
    "rd_own": "RD + own blocks",
    "universal": "tracker of the package",
}


def called(run):
    """What tables call a run; one of the learning curve draws by the picks of train scenes."""
    name, _, n = run.partition("_of_")
    return f"{NAMES[name]} by picks of {n} scenes" if n else NAMES[name]


def flights(results):
    """Worth of training sets over flights, a pair of sets a row; the endpoint is the first ODS."""
    table = read(results, "worth", FLIGHTS)
    rows = []
    for (run, base), scores in table.groupby(["run", "base"], sort=False):
        by_metric = scores.set_index("metric").loc[["ods", "ois", "ap"]]
        ods = by_metric.loc["ods"]
        means = f"{share(ods['mean'])} - {share(ods['base_mean'])}"
        differences = [difference(row) for row in by_metric.itertuples()]
        higher = ", ".join(map(str, by_metric["n_higher"]))
        corrected = ", ".join(digits(value, 2) for value in by_metric["p_holm"])
        rows.append([f"{called(run)} less {called(base)}", means, *differences, higher, corrected])
    header = ["sets", "means of ODS", "ODS", "OIS", "AP", "flights higher", "p (Holm)"]
    n = table["n_flights"].iloc[0]
    n_trainings = read(results, "scores", FLIGHTS)["replica"].nunique()
    title = f"{n} flights, {n_trainings} trainings a set on each (`{FLIGHTS}/worth.csv`). "
    title += "The endpoint is the first difference of ODS, its p is not corrected:\n\n"
    return title + markdown(header, rows)


def flight_parts(results):
    """What the spread between flights of some differences of ODS is made of."""
    rows = []
    for r in read(results, "worth", FLIGHTS).query("metric == 'ods'").itertuples():
        parts = (r.flight_spread, r.between_flights, r.training_error, r.image_error)
        rows.append([f"{called(r.run)} less {called(r.base)}", *map(four_digits, parts)])
    header = ["sets", "between flights", "flight, label sets", "trainings", "images"]
    return markdown(header, rows)


def four_digits(value):
    """An error of a score; nothing where one training leaves it unknown."""
    return "" if np.isnan(value) else f"{value:.4f}"


def flight_settings(results):
    """What was drawn for each flight."""
    table = read(results, "flights", FLIGHTS).set_index("flight")
    rows = [[f"`{name}`", *map(digits, values)] for name, values in table.items()]
    return markdown(["setting", *table.index], rows)


def learning_curve(results):
    """Scores by the number of annotated scenes, and scenes that drawn ones save."""
    table = read(results, "curve", FLIGHTS)
    sets = [name for name in table["training_set"].unique() if name != "universal"]
    rows = []
    for (flight, n_scenes), scores in table.groupby(["flight", "n_scenes"], sort=False):
        by_set = scores.set_index("training_set")
        if n_scenes == 0:
            rows.append([flight, "none", *[""] * (len(sets) + 1), on_curve(by_set, "universal")])
            continue
        ods = [on_curve(by_set, name) for name in sets]
        rows.append([flight, n_scenes, *ods, saved(by_set.loc["rd_pd"]), ""])
    names = [NAMES[name] for name in sets]
    header = ["flight", "annotated scenes", *names, "scenes saved by RD+PD", NAMES["universal"]]
    return f"ODS (`{FLIGHTS}/curve.csv`):\n\n" + markdown(header, rows)


def on_curve(by_set, name):
    """ODS of a training set with its interval, or that there is none."""
    row = by_set.loc[name]
    if np.isnan(row["ods"]):
        return "too little to draw from"
    return f"{share(row['ods'])} [{share(row['low'])}, {share(row['high'])}]"


def saved(row):
    """Scenes saved with their interval; nothing where there is no score."""
    if np.isnan(row["ods"]):
        return ""
    low, high = scenes(row["saved_low"]), scenes(row["saved_high"])
    return f"{scenes(row['saved'])} [{low}, {high}]"


def scenes(number):
    """A number of scenes, or that it is more than the curve holds."""
    return "more" if np.isinf(number) else f"{number:.0f}"


FLIGHT_BLOCKS = (flights, flight_parts, flight_settings, learning_curve)
