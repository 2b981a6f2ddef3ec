import numpy as np
from numpy.testing import assert_allclose

from reference.picks import n_visible_layers, pick_peaks, rise_db
from reference.settings import PickSettings
from snowsim.echogram import check_layer_bins

SETTINGS = PickSettings(picker_db=1.6, wrong_share=0)


def planted(n_lines=200, peaks_db=(30, 20, 20, 20), slope=0.0):
    """Mean power of layers with exponential tails over noise of 1, and where they are."""
    layer_bins = np.array([[50.0], [85], [120], [160]]) + slope * np.arange(n_lines)
    below = np.arange(260)[:, None] - layer_bins[:, None]
    echoes = np.exp(-np.abs(below) / np.where(below >= 0, 10, 1.5))
    return 1 + np.tensordot(10 ** (np.array(peaks_db) / 10), echoes, 1), layer_bins


def speckled_picks(power, layer_bins, rng, settings=SETTINGS):
    """Picks of an echogram of 16 looks."""
    speckled = power * rng.gamma(16, 1 / 16, power.shape)
    return pick_peaks(speckled, layer_bins, settings, rng=rng)


def test_rise_is_that_of_a_layer_over_the_tail_above():
    power, layer_bins = planted()
    rise = rise_db(power, layer_bins)
    assert np.isinf(rise[0])
    # Peak: 100, noise, and layer 2's tail after 40 bins. Valley, at the eighth of ten steps, 32
    # bins down: the same tail, noise, and the foot of layer 3 itself; layer 1 is 1 % of either.
    peak = 101 + 100 * np.exp(-4)
    valley = 1 + 100 * (np.exp(-3.2) + np.exp(-8 / 1.5))
    assert_allclose(rise[3], 10 * np.log10(peak / valley), atol=0.2)


def test_the_record_ends_at_the_deepest_rise():
    assert n_visible_layers(np.array([np.inf, 3, 0.2, 2, 0.5, np.nan]), 1.0) == 4
    assert n_visible_layers(np.array([np.inf, 0.5, 0.2]), 1.0) == 1


def test_clear_layers_are_found_to_the_bin_and_a_weak_one_is_lost_and_nothing_invented(rng):
    power, layer_bins = planted(slope=0.05)
    picked = speckled_picks(power, layer_bins, rng)
    assert np.isfinite(picked).mean() > 0.95
    assert np.nanmean(np.abs(picked - layer_bins)) < 1
    power, layer_bins = planted(peaks_db=(30, 20, -10, 20))
    n_found = np.isfinite(speckled_picks(power, layer_bins, rng)).mean(axis=1)
    assert n_found[2] < 0.2
    assert n_found[[0, 1, 3]].mean() > 0.95


def test_a_share_of_pieces_behind_a_gap_follows_the_layer_above_or_below(rng):
    power, layer_bins = planted(n_lines=4000)
    # Gaps every 100 lines: 39 pieces of layer 2 behind one.
    without, _ = planted(n_lines=4000, peaks_db=(30, 20, -20, 20))
    gaps = np.arange(4000) % 100 >= 60
    power[:, gaps] = without[:, gaps]
    for share, least, most in ((0.0, 0, 0), (0.25, 0.01, 0.53)):
        settings = PickSettings(picker_db=1.6, wrong_share=share)
        picked = speckled_picks(power, layer_bins, rng, settings)
        check_layer_bins(picked)
        error = np.abs(picked[2] - layer_bins[2])
        # Of 39 pieces a quarter: 0.25 +- 0.07, and what was lost to others; four of those.
        assert least <= (error[np.isfinite(error)] > 10).mean() <= most
