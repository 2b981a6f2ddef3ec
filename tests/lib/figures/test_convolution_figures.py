"""The chart of the convolution model draws what its table holds."""

import numpy as np
import pandas as pd
import pytest
from numpy.testing import assert_allclose

from lib.figures.convolution import LEAST_DB, plot_costs, plot_stacks, plot_tails
from lib.figures.style import new_figure


@pytest.fixture
def table():
    rows = [
        {"part": "stacks", "sweep": "layers", "value": value, "unit": "1", "method": method, "error_db": error}
        for method, errors in (("Born", (0.1, 1.0)), ("single scattering", (0.0, 0.2)), ("convolution", (0.01, 0.3)))
        for value, error in zip((1, 10), errors, strict=True)
    ]
    rows += [
        {"part": "tail", "sweep": case, "value": tail, "unit": "dB below the peak", "method": "PHY",
         "reference": reference, "error_db": tail / 100}
        for case, reference in (("horizon", "annuli integral"), ("horizon", "SMRT")) for tail in (10, 20)
    ]  # fmt: skip
    rows += [
        {"part": "scene", "method": method, "error_db": error, "seconds": seconds}
        for method, error, seconds in (("transfer matrix, stack", 0, 9), ("PHY", 0.05, 0.002), ("PHY", 0.05, 0.001))
    ]
    return pd.DataFrame(rows)


def test_stacks_show_every_model_and_nothing_below_the_least(table):
    figure, axes = new_figure()
    plot_stacks(axes[0, 0], table, "layers", "layers")
    lines = {line.get_label(): line.get_ydata() for line in axes[0, 0].get_lines()}
    assert_allclose(lines["Born"], [0.1, 1.0])
    assert_allclose(lines["single scattering"], [LEAST_DB, 0.2])
    assert_allclose(lines["convolution"], [0.01, 0.3])
    figure.clear()


def test_tails_of_a_study_join_those_of_the_default_run(table):
    figure, axes = new_figure()
    plot_tails(axes[0, 0], table)
    labels = axes[0, 0].get_legend_handles_labels()[1]
    assert labels == ["horizon, annuli integral", "horizon, SMRT"]
    figure.clear()


def test_costs_take_the_fastest_repeat(table):
    figure, axes = new_figure()
    plot_costs(axes[0, 0], table)
    points = [np.ravel([line.get_xdata(), line.get_ydata()]) for line in axes[0, 0].get_lines()]
    assert_allclose(points, [[LEAST_DB, 9], [0.05, 0.001]])
    figure.clear()
