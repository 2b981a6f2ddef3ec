"""What each part of the scene model is worth: statistics that lack it, and the loss without it."""

import pandas as pd

from evaluation.lib.flight_scores import mean_over_flights

WHOLE = "whole"
# A part may go if the mean of its loss and the upper end of the interval lie below these ODS, and
# if a network does not distinguish scenes without it from observed ones more often.
MOST_MEAN = 0.005
MOST_HIGH = 0.010
# Statistics that hold a part, all of which are 0 without it. With and without a part, scenes are
# drawn by the same random numbers.
SPREADS = {
    "line_gain": ("line_gain_spread_db",),
    "surface_row": ("surface_error_bins", "surface_movement_bins"),
    "relief": ("relief_variance_bins2", "slab_change_bins2"),
    "power": ("common_spread_db", "layer_spread_db"),
    "background": ("background_spread_db",),
    "echoes_below": ("further_rise_db",),
}
PARTS = {
    "line_gain": "gain varies from range line to range line",
    "surface_row": "the surface moves about its row",
    "relief": "thickness varies along track",
    "power": "power of buried layers varies from scene to scene and from layer to layer",
    "background": "power of unpicked snow varies from scene to scene",
    "echoes_below": "echoes below the last layer",
    "speckle_correlation": "speckle is correlated down range",
}


def without(statistics, part):
    """Flight statistics that lack one of `PARTS`; those of `WHOLE` lack none."""
    if part == WHOLE:
        return statistics
    if part == "speckle_correlation":
        return statistics.drop_vars("speckle_correlation")
    return statistics.assign({name: statistics[name] * 0 for name in SPREADS[part]})


def with_told_apart(scores, two_sample):
    """Edge scores with a column `told_apart`, the accuracy of the two-sample test."""
    of_renders = two_sample.query("scenes == 'phy' and first_row == -1")
    return scores.assign(told_apart=of_renders["accuracy"].item())


def choice_table(scores):
    """Loss of ODS without each part of the scene model, a row a part, the most costly first.

    `scores` has columns `flight, training_set, replica, ods, told_apart`, where the training set is
    named by the part that its scenes lack. Losses are those of the whole model less those without
    the part, paired by flight and training. Columns are `part, what, mean, low, high`, with a 95 %
    interval by Student's t over all pairs; `costs_little`, whether the loss is small enough for the
    part to go; and the mean loss of each flight, `flight_1101` and so on. `told_apart` is the
    accuracy of the two-sample test of scenes without the part, `whole_told_apart` that of scenes of
    the whole model, both means over flights.
    """
    ods = scores.set_index(["training_set", "flight", "replica"])["ods"]
    told_apart = scores.groupby("training_set")["told_apart"].mean()
    rows = []
    for part in scores["training_set"].unique():
        if part == WHOLE:
            continue
        loss = ods[WHOLE] - ods[part]
        row = {"part": part, "what": PARTS.get(part, "all that go, together")}
        row |= mean_over_flights(loss)
        row["costs_little"] = row["mean"] < MOST_MEAN and row["high"] < MOST_HIGH
        row |= loss.groupby("flight").mean().add_prefix("flight_").to_dict()
        row |= {"told_apart": told_apart[part], "whole_told_apart": told_apart[WHOLE]}
        rows.append(row)
    return pd.DataFrame(rows).sort_values("mean", ascending=False, kind="stable")
