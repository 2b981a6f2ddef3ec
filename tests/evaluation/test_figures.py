"""Figures: the same gives the same bytes, layers lie on their pixels, gaps are black."""

import itertools

import numpy as np
import pandas as pd
import pytest
from numpy.testing import assert_allclose

from evaluation.lib.figures.charts import (
    kept_apart,
    plot_task,
    seen_of_estimators,
    seen_of_methods,
)
from evaluation.lib.figures.style import Scale, new_panel, save_figure
from evaluation.lib.studied import SETS

# 5 cm of snow and 2 m along track.
SCALE = Scale(bin_m=0.05, line_km=0.002)


@pytest.mark.parametrize("ending", [".svg", ".png"])
def test_the_same_figure_gives_the_same_bytes(tmp_path, ending):
    paths = [tmp_path / f"{name}{ending}" for name in "xy"]
    for path in paths:
        figure, ax = new_panel()
        ax.plot([1, 2], label="line")
        ax.legend()
        save_figure(path, figure, "source")
    assert paths[0].read_bytes() == paths[1].read_bytes()


def test_layers_lie_on_the_middle_of_their_pixels():
    _, ax = new_panel()
    image = np.zeros((80, 30))
    SCALE.plot_image(ax, image)
    SCALE.plot_layers(ax, np.array([[60.0] * 30]))
    left, right, bottom, top = ax.images[0].get_extent()
    distance_km, depth_m = ax.lines[0].get_data()
    assert_allclose(depth_m, top + (60 + 0.5) / 80 * (bottom - top))
    assert_allclose(depth_m, 10 * 0.05)
    assert_allclose(distance_km, left + (np.arange(30) + 0.5) / 30 * (right - left))


def test_every_set_is_named_beside_the_chart_and_no_two_names_overlap():
    rows = itertools.product(SETS, (500, 1000))
    budgets = pd.DataFrame(rows, columns=["training_set", "n_gradients"])
    # All sets at one height; every other was trained beside other jobs.
    budgets = budgets.assign(
        training_s=10.0 + budgets.index, ods=0.8, scenes_s=[0, 0, np.nan, np.nan] * 7
    )
    budgets.loc[0, "ods"] = 0.7
    figure, ax = new_panel(7, 4.6)
    plot_task(ax, budgets)
    figure.canvas.draw()
    assert {text.get_text().split(":")[0].strip() for text in ax.texts} == {
        shown.about for shown in SETS.values()
    }
    boxes = [text.get_window_extent() for text in ax.texts]
    assert not any(a.overlaps(b) for a, b in itertools.combinations(boxes, 2))
    assert all(box.x1 < ax.get_window_extent().x1 for box in boxes)
    assert sum(line.get_marker() == "x" for line in ax.lines) == 7


def test_values_kept_apart_move_only_where_they_must():
    # The pair at 3 parts by a half to either side; the others have room.
    assert_allclose(kept_apart([1, 3, 3, 5], 1), [1, 2.5, 3.5, 5])


def test_the_atlas_says_what_its_panels_show():
    methods = pd.DataFrame({"method": ["a", "a", "b"], "outcome": ["within", "refused", "wrong"]})
    assert seen_of_methods(methods) == "Never wrong: a;\nwrong in orange: b."
    assert seen_of_methods(methods[:2]) == "Never wrong: a."
    errors = pd.DataFrame({"estimator": ["x", "x", "y"], "error": [-0.5, 2, 1], "bound": 1.0})
    seen = seen_of_estimators(errors.assign(value=3))
    assert seen == "Of 3 errors, within the bound:\nx 1, y 1."
