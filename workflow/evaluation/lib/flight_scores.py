"""What training sets are worth over flights.

Flights, trainings within flights and images within both are nested and balanced: each flight has
its own generator and test scenes, and as many trainings. Of such a mixed model the mean over
flights of the flights' own means is the estimate, and its error is the spread of these means: it
holds what flights, generators, trainings and images bring, in their right proportions.
"""

import pandas as pd
from scipy.stats import t as student

from lib.score_tables import counts_by_image
from snowsim.metrics.comparison import METRICS
from snowsim.metrics.edges import score

LEVEL = 0.05  # of a two-sided test
# Set less base. The first, in ODS, is the endpoint, named before the study was run; others are
# exploratory.
PAIRS = (
    ("rd_pd", "rd"),
    ("pd", "rd"),
    ("gd", "rd"),
    ("rd_gd", "rd"),
    ("rd_pd_gd", "rd"),
    ("rd_full", "rd"),
    ("rd_pd_gd", "rd_pd"),
    ("pd", "rd_full"),
    ("rd_pd", "rd_full"),
)


def training_scores(tables, trainings):
    """Scores of the fused output: rows of `training_set, replica` and `METRICS`.

    Edge counts of a flight's trainings, one table for each (training set, replica).
    """
    rows = []
    for table, (training_set, replica) in zip(tables, trainings, strict=True):
        fused = table[table["output"] == "fuse"]
        scores = score(counts_by_image(fused))
        row = {"training_set": training_set, "replica": replica}
        rows.append(row | {metric: scores[metric] for metric in METRICS})
    return pd.DataFrame(rows)


def mean_over_flights(values):
    """Mean of the flights' values, a Series, and its 95 % interval: Student's t over flights.

    Exact where values are normal; one flight leaves the interval unknown (NaN).
    """
    mean = values.mean()
    reach = student.ppf(1 - LEVEL / 2, len(values) - 1) * values.sem()
    return {"mean": mean, "low": mean - reach, "high": mean + reach}


def worth_table(scores):
    """Worth of training sets over flights: a row per pair and metric, then one per set and metric.

    `scores` of `training_scores`, with a column `flight`. Columns `training_set, base, metric`,
    those of `mean_over_flights`, and the mean of every flight's trainings, `flight_2000` and so on.
    All are of the difference to `base`, or of the scores themselves where there is none.
    """
    means = scores.groupby(["training_set", "flight"], sort=False)[list(METRICS)].mean()
    rows = []
    for training_set, base in PAIRS:
        differences = means.loc[training_set] - means.loc[base]
        rows += _rows(training_set, base, differences)
    for training_set in means.index.unique("training_set"):
        rows += _rows(training_set, None, means.loc[training_set])
    return pd.DataFrame(rows)


def _rows(training_set, base, values):
    """Rows of `worth_table`, of values by flight and metric."""
    rows = []
    for metric in METRICS:
        row = {"training_set": training_set, "base": base, "metric": metric}
        row |= mean_over_flights(values[metric])
        rows.append(row | values[metric].add_prefix("flight_").to_dict())
    return rows
