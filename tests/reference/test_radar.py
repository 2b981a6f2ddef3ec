import numpy as np
import pytest
from numpy.testing import assert_allclose

from reference import radar as rd
from reference.settings import RadarSettings
from snowsim.constants import SPEED_OF_LIGHT_M_S

RADAR = RadarSettings()
MARGIN = rd.range_response(RADAR).size // 2 + RADAR.n_sub_bins


def test_hann_response_has_the_published_width_and_is_the_spectrum_of_the_weighted_beat_signal():
    # 6 GHz: 0.075 m equivalent width of path there and back.
    delay_s = np.linspace(-50 / 6e9, 50 / 6e9, 200_001)
    power = rd.hann_response(delay_s, 6e9) ** 2
    width_m = np.trapezoid(power, delay_s) * SPEED_OF_LIGHT_M_S
    assert_allclose(width_m, 0.075, rtol=2e-3)  # likewise rounded, from 0.07495
    sweep = (np.arange(4096) + 0.5) / 4096 - 0.5  # of the bandwidth
    window = 0.5 + 0.5 * np.cos(2 * np.pi * sweep)
    x = np.array([0.0, 0.3, 1.0, 1.73, 2.6])
    spectrum = np.cos(2 * np.pi * np.outer(x, sweep)) @ window / window.sum()
    # Midpoint rule of a smooth periodic integrand.
    assert_allclose(rd.hann_response(x / 6e9, 6e9), spectrum, atol=1e-6)


def test_narrow_slopes_give_an_exponential_tail_and_rougher_interfaces_only_spread_their_power():
    # tan^2 = 2 d / H for an excess range d: exp(-tan^2 / 2 s^2) is exp(-d / (H s^2)), to order d /
    # H = 1e-3.
    excess_m = np.linspace(0, 1, 11)
    tail = rd.annulus_power(2 * excess_m / SPEED_OF_LIGHT_M_S, 500, 0.03, 0, 180)
    assert_allclose(np.log(tail), -excess_m / (500 * 0.03**2), atol=0.02)
    for slope, roughness_m in ((0.022, 0.0), (0.03, 0.02), (0.06, 0.08)):
        waveform = rd.interface_waveform(RADAR, slope, roughness_m)
        assert_allclose(waveform.power.sum(), 1, rtol=1e-5)  # float32 sum of some thousand values
    rough = rd.interface_waveform(RADAR, 0.03, 0.08)
    smooth = rd.interface_waveform(RADAR, 0.03, 0.02)
    assert rough.peak < smooth.peak


def flat_field(n_lines, n_bins, power):
    n_sub = n_bins * RADAR.n_sub_bins + 2 * MARGIN
    return np.full((n_lines, n_sub), power, dtype=np.float32)


@pytest.mark.parametrize("n_looks", [1, 5])
def test_speckle_has_the_looks_asked_for(rng, n_looks):
    detected = rd.draw_detected(flat_field(400, 500, 0.7), RADAR, MARGIN, n_looks, rng=rng)
    n = detected.size / 1.2  # neighbouring bins correlate by 0.08
    assert_allclose(detected.mean(), 0.7, rtol=4 / np.sqrt(n_looks * n))
    looks = detected.mean(dtype=float) ** 2 / detected.var(dtype=float)
    # Relative standard error of the variance of Gamma(M) is sqrt((2 + 6 / M) / n).
    assert_allclose(looks, n_looks, rtol=4 * np.sqrt((2 + 6 / n_looks) / n))


def test_speckle_is_correlated_in_fast_time_as_the_window_says(rng):
    power = rd.draw_detected(flat_field(600, 500, 1), RADAR, MARGIN, 1, rng=rng).astype(float)
    # Field correlation is the normalised transform of the squared window; power correlation its
    # square.
    f = np.linspace(-0.5, 0.5, 20_001)
    squared = (0.5 + 0.5 * np.cos(2 * np.pi * f)) ** 2
    lag = RADAR.bin_size_s * RADAR.bandwidth_hz / RADAR.response_widening
    field = np.average(np.cos(2 * np.pi * f * lag), weights=squared)
    measured = np.corrcoef(power[:, :-1].ravel(), power[:, 1:].ravel())[0, 1]
    # 3e5 pairs; the exponential's fourth moment triples the error of a correlation.
    assert_allclose(measured, field**2, atol=4 * 3 / np.sqrt(3e5))


def test_range_lines_and_phases_of_a_look_are_independent(rng):
    look = rd.draw_look(np.sqrt(flat_field(200, 300, 1) / 2), RADAR, MARGIN, rng=rng)
    bound = 4 / np.sqrt(look.size)
    assert abs(np.mean(look[1:] * look[:-1].conj())) < bound
    assert abs(np.mean(look**2)) < bound * 1.5  # circular


def test_received_mean_is_that_of_many_looks_and_does_not_depend_on_the_window(rng):
    field = flat_field(1, 60, 1e-3)
    field[0, 130] = 5
    mean = rd.received_mean(field, RADAR, MARGIN)
    repeated = np.repeat(field, 4000, axis=0)
    detected = rd.draw_detected(repeated, RADAR, MARGIN, 10, rng=rng).mean(axis=0)
    # The largest of 60 exponential means.
    assert_allclose(detected, mean[0], rtol=5 / np.sqrt(40_000))
    field = rng.random((3, 50 * RADAR.n_sub_bins + 2 * MARGIN)).astype(np.float32)
    whole = rd.received_mean(field, RADAR, MARGIN)
    n_sub = 30 * RADAR.n_sub_bins + 2 * MARGIN
    part = rd.received_mean(field[:, :n_sub], RADAR, MARGIN)
    assert_allclose(part, whole[:, :30], rtol=1e-6)  # float32


def test_gain_jumps_and_rolls_as_often_as_asked(rng):
    radar = RadarSettings(roll_enter=0.02, roll_leave=0.1, roll_gain=0.5)
    gain = rd.draw_roll_gain(200_000, radar, rng=rng)
    assert set(np.unique(gain)) == {0.5, 1.0}
    # Stationary share e / (e + l); correlation (1 - e - l) leaves n (e + l) / 2 independent lines.
    share = 0.02 / 0.12
    error = np.sqrt(share * (1 - share) / (200_000 * 0.06))
    assert_allclose((gain < 1).mean(), share, atol=4 * error)
    jumping = RadarSettings(jump_rate=0.01, line_gain_sd_db=0.0)
    gain = rd.draw_receiver_gain(100_000, jumping, rng=rng)
    assert_allclose(np.count_nonzero(np.diff(gain)), 1000, atol=4 * np.sqrt(1000))


def test_compensation_leaves_fractions_of_a_bin(rng):
    row = rd.draw_surface_row(20_000, 50, RadarSettings(tracking_sd_bins=0.0), rng=rng)
    assert np.abs(row - 50).max() <= 0.5
    assert row.std() > 0.2
    tracked = rd.draw_surface_row(20_000, 50, RadarSettings(jitter_m=0.0), rng=rng)
    # Gaussian smoothing over 20 lines leaves 20000 / (20 * 2 sqrt(pi)) = 280 independent values.
    assert_allclose(tracked.std(), 0.8, rtol=4 / np.sqrt(2 * 280))
