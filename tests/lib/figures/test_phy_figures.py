"""What PHY's charts derive from their tables before they draw."""

import pandas as pd
from numpy.testing import assert_array_equal

from lib.figures.phy import fastest, pareto_front, speed_accuracy_waveforms


def test_pareto_front_holds_what_nothing_beats_in_both():
    error = [1.0, 0.5, 0.5, 2.0, float("nan"), 0.0]
    cost = [1.0, 2.0, 3.0, 1.0, 0.1, 9.0]
    assert_array_equal(pareto_front(error, cost), [True, True, False, False, False, True])


def runs():
    table = {"setting": "s", "method": ["table"] * 3 + ["closed form", "float32 normal"], "repeat": [0, 1, 2, 0, 0]}
    seconds = [1e-6, 9e-6, 2e-6, 5e-6, 1e-6]
    error_db = [0.01, 0.01, 0.01, 0.0, float("nan")]
    return pd.DataFrame(table | {"seconds": seconds, "n_pixels": 100, "error_db": error_db, "device": "cpu"})


def test_points_are_the_fastest_runs_per_pixel():
    points = fastest(runs(), ("setting", "method")).set_index("method")
    assert points.loc["table", "ns"] == 1e-6 / 100 * 1e9
    assert points.loc["table", "error_db"] == 0.01


def test_floor_front_and_points_are_drawn():
    (ax,) = speed_accuracy_waveforms(runs()).axes
    labels = {text.get_text() for text in ax.get_legend().get_texts()}
    assert labels == {"table", "closed form", "Pareto front", "one float32 normal per pixel"}
