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
    """Worth of training sets over flights, the endpoint first."""
    table = read(results, "worth", FLIGHTS)
    rows = []
    for r in table.itertuples():
        sets = f"{called(r.run)} less {called(r.base)}"
        means = f"{share(r.mean)} - {share(r.base_mean)}"
        higher = f"{r.n_higher} of {r.n_flights}"
        corrected = digits(r.p_holm, 2)
        row = [sets, r.metric.upper(), r.family, means, difference(r), higher, corrected]
        rows.append(row)
    header = ["sets", "score", "family", "means", "difference", "flights higher", "p (Holm)"]
    n = table["n_flights"].iloc[0]
    n_trainings = read(results, "scores", FLIGHTS)["replica"].nunique()
    title = f"{n} flights, {n_trainings} trainings a set on each (`{FLIGHTS}/worth.csv`):\n\n"
    return title + markdown(header, rows)


def flight_parts(results):
    """What the spread between flights of some differences of ODS is made of."""
    rows = []
    for r in read(results, "worth", FLIGHTS).query("metric == 'ods'").itertuples():
        parts = (r.flight_spread, r.between_flights, r.training_error, r.image_error)
        rows.append([f"{called(r.run)} less {called(r.base)}", *map(four_digits, parts)])
    header = ["sets", "between flights", "flight and generator", "trainings", "images"]
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
    rows = []
    for r in read(results, "curve", FLIGHTS).itertuples():
        if np.isnan(r.ods):
            rows.append(
                [r.flight, r.n_scenes, NAMES[r.training_set], "too little to draw from", ""]
            )
            continue
        score = f"{share(r.ods)} [{share(r.low)}, {share(r.high)}]"
        saved = ""
        if r.training_set != "rd":
            saved = f"{scenes(r.saved)} [{scenes(r.saved_low)}, {scenes(r.saved_high)}]"
        rows.append([r.flight, r.n_scenes, NAMES[r.training_set], score, saved])
    header = ["flight", "annotated scenes", "set", "ODS", "scenes saved"]
    return f"(`{FLIGHTS}/curve.csv`)\n\n" + markdown(header, rows)


def scenes(number):
    """A number of scenes, or that it is more than the curve holds."""
    return "more" if np.isinf(number) else f"{number:.0f}"


FLIGHT_BLOCKS = (flights, flight_parts, flight_settings, learning_curve)
