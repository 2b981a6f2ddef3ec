"""Flagged range lines: what is left of them, in a frame and in its statistics."""

import numpy as np
import pytest
from numpy.testing import assert_array_equal
from test_cut_blocks import make_level_frame

from snowsim.alignment import count_flagged, flatten, leave_out_flagged
from snowsim.statistics import summarise

N_LINES = 1024
FLAGGED = slice(300, 312)
FLAGS = ("no_good_data", "low_SNR", "land_ice")


def flagged(echogram, **lines):
    """The echogram with a mask in which each flag named is set on a slice of its lines."""
    mask = np.zeros(echogram.sizes["slow_time"], dtype=np.uint8)
    for name, where in lines.items():
        mask[where] |= 1 << FLAGS.index(name)
    attributes = {
        "flag_masks": np.array([1, 2, 4], dtype=np.uint8),
        "flag_meanings": " ".join(FLAGS),
    }
    return echogram.assign(quality_mask=("slow_time", mask, attributes))


@pytest.fixture
def frame(rng):
    """A level frame flagged with land ice throughout, weak in places, of no use in FLAGGED."""
    echogram, layers = make_level_frame(rng, n_lines=N_LINES)
    return flagged(
        echogram, no_good_data=FLAGGED, low_SNR=slice(0, 100), land_ice=slice(None)
    ), layers


def test_flagged_lines_lose_power_and_picks_and_the_others_keep_every_bit(frame):
    echogram, layers = leave_out_flagged(*frame)
    fit = np.ones(N_LINES, dtype=bool)
    fit[FLAGGED] = False
    assert_array_equal(echogram["flagged"], ~fit)
    for found, name, given in ((echogram, "Data", frame[0]), (layers, "twtt", frame[1])):
        assert np.isnan(found[name].values[:, ~fit]).all()
        assert found[name].dtype == given[name].dtype
        assert_array_equal(found[name].values[:, fit], given[name].values[:, fit])
        # The frame that came in is not touched.
        assert np.isfinite(given[name]).all()


def test_the_setting_says_which_flags_flag_a_line_and_others_change_nothing(frame):
    echogram, _ = leave_out_flagged(*frame, flags=("low_SNR", "coh_noise_removal_artifact"))
    assert_array_equal(np.flatnonzero(echogram["flagged"]), np.arange(100))
    bare, layers = frame[0].drop_vars("quality_mask"), frame[1]
    assert leave_out_flagged(bare, layers) == (bare, layers)
    assert count_flagged(flagged(bare)) == (0, "none")


def test_what_flagged_lines_hold_enters_no_statistics(frame):
    echogram, layers = frame
    spoiled, moved = echogram.copy(deep=True), layers.copy(deep=True)
    spoiled["Data"].values[:, FLAGGED] *= 1e6
    moved["twtt"].values[:, FLAGGED] += (
        3e-9  # ten bins, surface included: it must not level the frame either
    )
    found, expected = (
        summarise(*flatten(*leave_out_flagged(*given)))
        for given in ((spoiled, moved), (echogram, layers))
    )
    assert found.identical(expected)
    # Air by group of 20 lines: 210 rows above the surface less 30, of lines 300 to 311 none.
    count = expected["air_count"].values
    assert (count[[14, 15, 16]] == np.array([20, 8, 20]) * 180).all()
    # Group 15 has 8 of its 20 lines left, fewer than the half that a row of an average needs.
    assert np.isnan(expected["power"].values[15]).all()
