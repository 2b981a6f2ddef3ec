import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from lib.diagnostics.renders import error_by_band


def test_bands_count_all_and_average_what_was_found():
    error = np.array([[1.0, -3.0, np.nan], [2.0, 5.0, 7.0]])
    depth = np.array([[10.0, 10.0, 15.0], [20.0, 40.0, np.nan]])
    table = error_by_band(error, depth, [0, 20, 30, 40])
    assert_array_equal(table["n"], [3, 1, 1])  # 20 opens its band, 40 closes the last; NaN is nowhere
    assert_allclose(table["share_found"], [2 / 3, 1, 1])
    assert_allclose(table["mean"], [-1, 2, 5])
    assert_allclose(table["mean_absolute"], [2, 2, 5])
    assert_allclose(table["rms"], [np.sqrt(5), 2, 5])


def test_empty_bands_hold_nan():
    table = error_by_band([np.nan], [0.5], [0, 1, 2])
    assert_array_equal(table["n"], [1, 0])
    assert_allclose(table["share_found"], [0, np.nan])
    assert table[["mean", "mean_absolute", "rms"]].isna().all(axis=None)


def test_bad_bands_are_refused():
    with pytest.raises(ValueError, match="one shape"):
        error_by_band([1.0], [1.0, 2.0], [0, 1])
    with pytest.raises(ValueError, match="ascending"):
        error_by_band([1.0], [1.0], [1, 0])
