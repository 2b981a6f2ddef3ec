"""Number of annotated scenes that PHY's scenes are worth."""

import numpy as np
import pandas as pd
from numpy.testing import assert_allclose

from evaluation.lib.annotation import annotation_curve
from evaluation.lib.studied import first_scenes


def scores_of(levels, n_gradients=(500, 1000)):
    """Scores of three trainings; those with more gradients are better by .01."""
    rows = []
    for (n_scenes, with_pd), level in levels.items():
        for n in n_gradients:
            for replica, shift in enumerate((-0.002, 0.0, 0.002)):
                ods = level + shift + 0.01 * (n == n_gradients[-1])
                name = first_scenes(n_scenes, with_pd)
                rows.append((1102, name, n, replica, ods))
    return pd.DataFrame(rows, columns=["flight", "training_set", "n_gradients", "replica", "ods"])


def test_scenes_are_worth_those_that_reach_the_same_score_without_them():
    levels = {(20, False): 0.60, (40, False): 0.70, (80, False): 0.69, (160, False): 0.80}
    levels |= {(20, True): 0.65, (40, True): 0.75, (80, True): 0.81}
    curve = annotation_curve(scores_of(levels))
    assert set(curve["n_gradients"]) == {1000}
    with_pd = curve[curve["with_pd"]].set_index("n_scenes")
    # Half way between 20 and 40 and between 80 and 160, along the logarithm.
    assert_allclose(with_pd.loc[[20, 40], "worth"], [20 * 2**0.5, 80 * 2**0.5])
    assert np.isnan(with_pd.loc[80, "worth"])
    assert curve.loc[~curve["with_pd"], "worth"].isna().all()
    assert_allclose(curve["high"] - curve["low"], 0.004)
