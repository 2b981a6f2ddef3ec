"""Radiometry that varies: planted spreads, background and ends of picks come back."""

import numpy as np
import pytest
from made_up import made_up_frame
from numpy.testing import assert_allclose
from planted import gaussian_series

from snowsim.statistics import fit, summarise
from snowsim.statistics.radiometry import common_and_own_spread

N_FRAMES, N_LINES, N_LAYERS, N_BINS, SPACING = 12, 1024, 6, 480, 60
POWER, NOISE, DECAY = 10 ** -np.arange(0, 0.3 * N_LAYERS, 0.3), 1e-3, 0.1
COMMON_DB, LAYER_DB, NOISE_DB = 3.0, 2.0, 1.5
FADING_DB, FADING_LINES = 2.0, 30  # of the power of a layer along track


def standardised(values):
    """Deviations of which mean and standard deviation over blocks are exactly 0 and 1."""
    values = values - values.mean(axis=0)
    return values / values.std(axis=0, ddof=1)


def flight(rng):
    n_lines = N_FRAMES * N_LINES
    n_blocks = n_lines // 256
    common = standardised(rng.standard_normal((n_blocks, 1)))
    layers = standardised(rng.standard_normal((n_blocks, N_LAYERS)))
    noise = standardised(rng.standard_normal(n_blocks))
    of_block_db = np.repeat(COMMON_DB * common + LAYER_DB * layers, 256, axis=0).T
    fading_db = gaussian_series((N_LAYERS, n_lines), FADING_DB, FADING_LINES, rng)
    deviation_db = of_block_db + fading_db
    deviation_db[0] = 0
    row = 60 + SPACING * np.arange(N_LAYERS)
    below = np.arange(N_BINS)[:, None] - row
    echo = np.where(below >= 0, np.exp(-DECAY * below), 0)
    mean = echo @ (POWER[:, None] * 10 ** (deviation_db / 10))
    mean += NOISE * 10 ** (NOISE_DB * np.repeat(noise, 256) / 10)
    layer_bins = row[:, None] + np.zeros(N_LINES)
    parts = np.split(rng.gamma(5, mean / 5), N_FRAMES, axis=1)
    return [made_up_frame(part, layer_bins, minute=i) for i, part in enumerate(parts)]


@pytest.fixture(scope="module")
def planted_radiometry():
    return fit(flight(np.random.default_rng(1)), estimator="paper")


def test_planted_spreads_of_power_and_noise_come_back_within_15_percent(planted_radiometry):
    fitted = planted_radiometry
    # Fading's own block mean is part of a layer's spread: its variance there is that of 256 lines'
    # mean.
    lag = np.arange(256)
    share = np.where(lag > 0, 2, 1) * (256 - lag) / 256**2
    kept = (share * np.exp(-((lag / FADING_LINES) ** 2))).sum()
    planted = {
        "common_spread_db": COMMON_DB,
        "layer_spread_db": np.hypot(LAYER_DB, FADING_DB * np.sqrt(kept)),
    }
    assert fitted["surface_spread_db"] < 0.15 * NOISE_DB
    for name, value in planted.items():
        assert_allclose(fitted[name], value, rtol=0.15, err_msg=name)


def test_planted_gain_comes_back(rng):
    """300 groups of 20 lines tell a variance to 3 %."""
    mean = np.where(np.arange(420)[:, None] < 60, 1e-3, 0.02)
    mean = mean * 10 ** (0.05 * rng.standard_normal(6000))
    surface = np.full((2, 6000), [[60.0], [90.0]])
    summary = summarise(*made_up_frame(rng.gamma(5, mean / 5), surface))
    gain_db = 10 / np.log(10) * np.sqrt(np.nanmean(summary["gain_variance"]))
    # Half of the samples are beyond the median, those beyond 6 deviations hardly any.
    assert_allclose(gain_db, 0.5, rtol=0.1)


def test_layers_that_share_nothing_have_no_common_spread(rng):
    common, own = common_and_own_spread(3 * rng.standard_normal((4000, 5)))
    assert common < 0.5
    assert_allclose(own, 3, rtol=0.02)  # 20,000 values: 0.5 %
