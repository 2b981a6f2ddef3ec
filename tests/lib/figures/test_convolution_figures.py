"""The chart of the convolution model draws what its table holds."""

import numpy as np
import pandas as pd
import pytest
from numpy.testing import assert_allclose

from lib.figures.convolution import LEAST_DB, plot_costs, plot_stacks, plot_tails
from lib.figures.style import new_figure


@pytest.fixture
def table():
    errors = {"Born": (0.1, 1.0), "single scattering": (0.0, 0.2), "convolution": (0.01, 0.3)}
    seconds = [("transfer matrix, stack", 0, 9), ("PHY", 0.05, 0.002), ("PHY", 0.05, 0.001)]
    return pd.DataFrame(
        [{"part": "stacks", "sweep": "layers", "value": value, "unit": "1", "method": method, "error_db": error}
         for method, pair in errors.items() for value, error in zip((1, 10), pair, strict=True)]
        + [{"part": "tail", "sweep": "horizon", "value": tail, "unit": "dB below the peak", "method": "PHY",
            "reference": reference, "error_db": tail / 100}
           for reference in ("annuli integral", "SMRT") for tail in (10, 20)]
        + [{"part": "scene", "method": method, "error_db": error, "seconds": s} for method, error, s in seconds]
    )  # fmt: skip


@pytest.fixture
def ax():
    return new_figure()[1][0, 0]


def test_stacks_show_every_model_and_nothing_below_the_least(table, ax):
    plot_stacks(ax, table, "layers", "layers")
    lines = {line.get_label(): line.get_ydata() for line in ax.get_lines()}
    assert_allclose(lines["Born"], [0.1, 1.0])
    assert_allclose(lines["single scattering"], [LEAST_DB, 0.2])
    assert_allclose(lines["convolution"], [0.01, 0.3])


def test_tails_of_a_study_join_those_of_the_default_run(table, ax):
    plot_tails(ax, table)
    assert ax.get_legend_handles_labels()[1] == ["horizon, annuli integral", "horizon, SMRT"]


def test_costs_take_the_fastest_repeat(table, ax):
    plot_costs(ax, table)
    points = [np.ravel([line.get_xdata(), line.get_ydata()]) for line in ax.get_lines()]
    assert_allclose(points, [[LEAST_DB, 9], [0.05, 0.001]])
