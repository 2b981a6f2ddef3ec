"""Worth of training sets, estimated over several flights.

Every flight has its own generator and test scenes and the same number of trainings, so that
trainings and images are nested in flights and balanced. For such a mixed model the estimate is the
mean over flights of each flight's own mean. Its error is the spread of these means, which contains
the effects of flights, generators, trainings and images in their right proportions.
"""

import pandas as pd
from scipy.stats import t as student

from lib.score_tables import counts_by_image
from snowsim.metrics.edges import METRICS, score

LEVEL = 0.05  # significance level of a two-sided test
# Pairs (training set, base) that are compared. The first, in ODS, is the endpoint, named before the
# study was run; the others are exploratory.
PAIRS = (
    ("rd_pd", "rd"),
    ("pd", "rd"),
    ("gd", "rd"),
    ("rd_gd", "rd"),
    ("rd_pd_gd", "rd"),
    ("rd_full", "rd"),
    ("rd_own", "rd"),
    ("rd_pd", "rd_own"),
    ("rd_pd_gd", "rd_pd"),
    ("pd", "rd_full"),
    ("rd_pd", "rd_full"),
)


def training_scores(tables, trainings):
    """Table of scores of the fused output, with columns `training_set, replica` and `METRICS`.

    `tables` holds edge counts, one table for each (training set, replica) of `trainings`.
    """
    rows = []
    for table, (training_set, replica) in zip(tables, trainings, strict=True):
        scores = score(counts_by_image(table, "fuse"))
        row = {"training_set": training_set, "replica": replica}
        rows.append(row | {metric: scores[metric] for metric in METRICS})
    return pd.DataFrame(rows)


def mean_over_flights(values):
    """Mean of a Series of one value for each flight, and its 95 % interval by Student's t.

    The interval is exact for normal values, and NaN for one flight.
    """
    mean = values.mean()
    reach = student.ppf(1 - LEVEL / 2, len(values) - 1) * values.sem()
    return {"mean": mean, "low": mean - reach, "high": mean + reach}


def worth_table(scores):
    """Worth of training sets over flights: rows for pairs and metrics, then for sets and metrics.

    `scores` are those of `training_scores` with a column `flight`. Columns are `training_set, base,
    metric`, those of `mean_over_flights`, and for each flight the mean over its trainings,
    `flight_2000` and so on. Values are differences to `base`, or scores where there is no base.
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
    """Rows of `worth_table` from values by flight and metric."""
    rows = []
    for metric in METRICS:
        row = {"training_set": training_set, "base": base, "metric": metric}
        row |= mean_over_flights(values[metric])
        rows.append(row | values[metric].add_prefix("flight_").to_dict())
    return rows
