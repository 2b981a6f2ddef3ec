"""Figures: the same gives the same bytes, layers lie on their pixels, gaps are black."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from evaluation.lib.figures.style import Scale, new_panel, save_figure

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
