"""Which pixels of the flight are shown."""

import numpy as np
from numpy.testing import assert_array_equal
from plot_pixel_grid import chosen_bins, chosen_pixels


def test_the_first_four_lines_with_three_layers_are_shown():
    layer_bins = np.full((5, 20), np.nan)
    layer_bins[0], layer_bins[2] = 50.0, 90.0
    layer_bins[3, 6:12], layer_bins[4, 2:19] = 110.0, 130.0
    line, layers = chosen_pixels(layer_bins)
    assert line == 2
    assert_array_equal(layers, [0, 2, 4])
    assert chosen_bins(layer_bins[layers, line : line + 4], 800) == (44, 142)


def test_fewer_layers_are_shown_where_there_are_no_more():
    layer_bins = np.full((3, 20), np.nan)
    layer_bins[1, 7:11] = 3.0
    line, layers = chosen_pixels(layer_bins)
    assert (line, list(layers)) == (7, [1])
    assert chosen_bins(layer_bins[layers, line : line + 4], 10) == (0, 10)


def test_a_frame_without_picks_is_shown_all_the_same():
    line, layers = chosen_pixels(np.full((3, 20), np.nan))
    assert (line, layers.size) == (0, 0)
    assert chosen_bins(np.empty((0, 4)), 800) == (0, 48)
