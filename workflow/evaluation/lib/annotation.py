"""What PHY's scenes are worth by number of annotated scenes."""

import numpy as np

from evaluation.lib.studied import studied_set


def annotation_curve(scores):
    """ODS by number of annotated scenes, with and without PHY's, at the best number of gradients.

    `scores` has columns `flight, training_set, n_gradients, replica, ods`, of sets of the first
    scenes of RD. Columns of the table are `flight, n_scenes, with_pd, n_gradients, ods`, a mean
    over trainings, `low, high`, the lowest and the highest of them, and `worth`: for sets with
    PHY's scenes, the number of annotated scenes without these that has the same ODS, interpolated
    along the logarithm; NaN where no number of them reaches it.
    """
    keys = ["flight", "training_set", "n_gradients"]
    table = scores.groupby(keys)["ods"].agg(["mean", "min", "max"]).reset_index()
    table = table.rename(columns={"mean": "ods", "min": "low", "max": "high"})
    table = table.loc[table.groupby(["flight", "training_set"])["ods"].idxmax()]
    sets = [studied_set(name) for name in table["training_set"]]
    table["n_scenes"] = [each.n_real for each in sets]
    table["with_pd"] = [bool(each.added) for each in sets]
    table = table.sort_values(["flight", "with_pd", "n_scenes"])
    table["worth"] = [_worth(row, table) for row in table.itertuples()]
    columns = ["flight", "n_scenes", "with_pd", "n_gradients", "ods", "low", "high", "worth"]
    return table[columns].reset_index(drop=True)


def _worth(row, table):
    """Annotated scenes without PHY's that have the ODS of a row; NaN beyond the most there are."""
    if not row.with_pd:
        return np.nan
    alone = table[(table["flight"] == row.flight) & ~table["with_pd"]]
    # More scenes are no worse: what is lower is scatter of trainings.
    reached = np.maximum.accumulate(alone["ods"].to_numpy())
    log_n = np.interp(row.ods, reached, np.log(alone["n_scenes"]), right=np.nan)
    return float(np.exp(log_n))
