"""Worth of training sets, estimated over several flights.

Every flight has its own generator and test scenes and the same number of trainings, so that
trainings and images are nested in flights and balanced. For such a mixed model the estimate is the
mean over flights of each flight's own mean. Its error is the spread of these means, which contains
the effects of flights, generators, trainings and images in their right proportions.
"""

import numpy as np
import pandas as pd
from scipy.stats import t as student
from scipy.stats import ttest_1samp

from snowsim.metrics.edges import METRICS

LEVEL = 0.05  # significance level of a two-sided test
# Pairs (training set, base) that are compared, named before the flights were scored. The endpoint
# is in ODS, and so are the secondary pairs, which share one level by the method of Holm (1979), so
# that none of them is tested before all of their sets are flown.
ENDPOINT = ("rd_pd", "rd_sample")
SECONDARY = (
    ("rd_sample_pd", "rd_sample"),
    ("rd_pd", "rd"),
    ("rd_pd", "rd_completed"),
    ("rd_gd_picked", "rd"),
)
EXPLORATORY = (
    ("rd_sample", "rd"),
    ("rd_completed", "rd"),
    ("rd_completed_pd", "rd_completed"),
    ("rd_pd_paper", "rd"),
    ("rd_gd", "rd"),
    ("rd_pd_gd", "rd_pd"),
    ("pd", "rd"),
    ("gd", "rd"),
    ("pd_gd", "rd"),
    ("rd_full", "rd"),
    ("rd_pd", "rd_full"),
)
DEEP_BINS = 300  # [range bins] below the surface, about 10 m, from which on a layer is deep
ROLES = {ENDPOINT: "endpoint"} | dict.fromkeys(SECONDARY, "secondary")
ROLES |= dict.fromkeys(EXPLORATORY, "exploratory")


def mean_over_flights(values):
    """Mean of a Series of one value for each flight, and its 95 % interval by Student's t.

    The interval is exact for normal values, and NaN for one flight.
    """
    mean = values.mean()
    reach = student.ppf(1 - LEVEL / 2, len(values) - 1) * values.sem()
    return {"mean": mean, "low": mean - reach, "high": mean + reach}


def worth_table(scores):
    """Worth of training sets over flights: rows for pairs and metrics, then for sets and metrics.

    `scores` has columns `training_set, flight` and `METRICS`, a row for each training. Columns are
    `training_set, base, role, metric`, those of `mean_over_flights`, `p` of a t test, `p_holm`, and
    for each flight the mean over its trainings, `flight_4000` and so on. Values are differences to
    `base`, or scores where there is no base. `role` is one of endpoint, secondary and exploratory;
    pairs of which a set was not flown have no row. `p` is given for ODS of the endpoint and the
    secondary pairs; `p_holm`, for the latter, is adjusted for their number.
    """
    means = scores.groupby(["training_set", "flight"], sort=False)[list(METRICS)].mean()
    flown = means.index.unique("training_set")
    rows = []
    for (training_set, base), role in ROLES.items():
        if training_set in flown and base in flown:
            differences = means.loc[training_set] - means.loc[base]
            rows += _rows(training_set, base, role, differences)
    for training_set in flown:
        rows += _rows(training_set, None, None, means.loc[training_set])
    table = pd.DataFrame(rows)
    secondary = (table["role"] == "secondary") & table["p"].notna()
    table.insert(table.columns.get_loc("p") + 1, "p_holm", np.nan)
    if secondary.sum() == len(SECONDARY):
        table.loc[secondary, "p_holm"] = holm(table.loc[secondary, "p"].to_numpy())
    else:
        table.loc[secondary, "p"] = np.nan
    return table


def holm(p):
    """P values adjusted for their number by Holm (1979), Scand. J. Statist. 6, 65-70."""
    order = np.argsort(p)
    stepped = np.maximum.accumulate(np.arange(len(p), 0, -1) * p[order])
    adjusted = np.empty(len(p))
    adjusted[order] = np.minimum(stepped, 1)
    return adjusted


def _rows(training_set, base, role, values):
    """Rows of `worth_table` from values by flight and metric."""
    rows = []
    for metric in METRICS:
        row = {"training_set": training_set, "base": base, "role": role, "metric": metric}
        row |= mean_over_flights(values[metric])
        is_tested = role in ("endpoint", "secondary") and metric == "ods"
        row["p"] = ttest_1samp(values[metric], 0).pvalue if is_tested else np.nan
        rows.append(row | values[metric].add_prefix("flight_").to_dict())
    return rows


def share_of_deep(depths):
    """Share of the pixels of deep layers that was found: a row a training set, a column a flight.

    `depths` are as of `found_by_depth`.
    """
    deep = depths[depths["depth_from_bins"] >= DEEP_BINS]
    sums = deep.groupby(["training_set", "flight"], sort=False)[["n_true", "n_found"]].sum()
    return (sums["n_found"] / sums["n_true"]).unstack()


def found_by_depth(depths):
    """Share of layer pixels found by depth, over all trainings: a row a set and a depth step.

    `depths` has columns `training_set, flight, replica, depth_from_bins, n_true, n_found,
    n_layers`. Columns are `training_set, depth_from_bins, share, n_layers`: a layer counts once,
    not once a training.
    """
    keys = ["training_set", "depth_from_bins"]
    sums = depths.groupby(keys, sort=False)[["n_true", "n_found", "n_layers"]].sum().reset_index()
    runs = depths[["training_set", "flight", "replica"]].drop_duplicates()
    n_trainings = runs.groupby("training_set").size() / depths["flight"].nunique()
    table = sums[keys].assign(share=sums["n_found"] / sums["n_true"])
    table["n_layers"] = sums["n_layers"] / sums["training_set"].map(n_trainings)
    return table.sort_values(keys)
