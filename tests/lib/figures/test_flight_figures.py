"""Pictures of frames with gaps, and which of their pixels are shown one by one."""

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from lib.figures.flight import chosen_bins, chosen_pixels, image_with_gaps
from snowsim.echogram import to_uint8


def test_a_frame_without_gaps_looks_as_it_always_did(rng):
    power = rng.gamma(4, 1e-3, size=(60, 40))
    assert_array_equal(image_with_gaps(power), to_uint8(power)[0])


def test_ragged_ends_and_gaps_are_black_and_leave_the_rest_as_bright(rng):
    power = rng.gamma(4, 1e-3, size=(60, 400))
    ragged = np.vstack([np.full((20, 400), np.nan), power])
    ragged[20:23, ::3] = np.nan
    ragged[40, 7] = 0
    image = image_with_gaps(ragged)
    missing = ~(np.isfinite(ragged) & (ragged > 0))
    assert (image[missing] == 0).all()
    # The noise floor is the smallest of 60 row means; three of them are now of two thirds of their pixels. A mean of
    # 400 pixels of 4 looks, 2.3 dB each, is known to 0.12 dB, a grey level of some 30 dB in 255; allow three.
    assert np.abs(image[~missing].astype(int) - to_uint8(power)[0][~missing[20:]]).max() <= 3


def test_lines_left_out_are_black_and_leave_the_rest_as_it_was_even_where_they_are_most(rng):
    power = rng.gamma(4, 1e-3, size=(60, 100))
    held = np.arange(100) < 30
    image = image_with_gaps(np.where(held, power, np.nan))
    assert (image[:, ~held] == 0).all()
    # Gaps count as medians of their rows: the floor moves by the scatter of a row of 30 pixels, 2.3 / sqrt(30) dB,
    # 6 grey levels of 18 dB in 255.
    assert np.abs(image[:, held].astype(int) - to_uint8(power[:, held])[0]).max() <= 6


def test_a_frame_that_no_row_of_shows_half_is_refused():
    with pytest.raises(ValueError, match="half of the range lines"):
        image_with_gaps(np.full((4, 5), np.nan))


def test_the_first_four_lines_with_three_layers_are_shown():
    layer_bins = np.full((5, 20), np.nan)
    layer_bins[0], layer_bins[2] = 50.0, 90.0
    layer_bins[3, 6:12], layer_bins[4, 2:19] = 110.0, 130.0
    line, layers = chosen_pixels(layer_bins)
    assert line == 2
    assert_array_equal(layers, [0, 2, 4])
    assert chosen_bins(layer_bins[layers, line : line + 4], 800) == (44, 142)


def test_fewer_layers_are_shown_where_there_are_no_more_and_none_where_there_are_no_picks():
    layer_bins = np.full((3, 20), np.nan)
    assert [np.size(part) for part in chosen_pixels(layer_bins)] == [1, 0]
    assert chosen_bins(np.empty((0, 4)), 800) == (0, 48)
    layer_bins[1, 7:11] = 3.0
    line, layers = chosen_pixels(layer_bins)
    assert (line, list(layers)) == (7, [1])
    assert chosen_bins(layer_bins[layers, line : line + 4], 10) == (0, 10)
