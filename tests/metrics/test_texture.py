import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.signal import lfilter

from snowsim.metrics import texture


@pytest.mark.parametrize("n_looks", [1, 5, 100])
def test_gamma_speckle_has_its_number_of_looks(rng, n_looks):
    power = rng.gamma(n_looks, 3 / n_looks, size=200_000)
    # The relative error of mean^2 / variance of n gamma variates is below sqrt((2 + 6 / looks) /
    # n); allow four.
    assert_allclose(
        texture.equivalent_number_of_looks(power),
        n_looks,
        rtol=4 * np.sqrt((2 + 6 / n_looks) / 200_000),
    )


def test_constant_power_has_infinitely_many_looks():
    assert texture.equivalent_number_of_looks(np.full(10, 2.0)) == np.inf


@pytest.mark.parametrize(("along", "axis"), [("range_line", 1), ("range_bin", 0)])
def test_autocorrelation_of_an_autoregressive_texture_falls_geometrically(rng, along, axis):
    image = lfilter([1], [1, -0.8], rng.standard_normal((600, 600)), axis=axis)[100:, 100:]
    other = "range_bin" if along == "range_line" else "range_line"
    # Independent pixels: 250,000 x (1 - 0.8^2) / (1 + 0.8^2) = 55,000; four of 1 / sqrt(55,000) is
    # 0.017.
    lags = np.array([0, 1, 2, 5, 10])
    assert_allclose(texture.autocorrelation(image, lags, along=along), 0.8**lags, atol=0.017)
    assert_allclose(texture.autocorrelation(image, [1, 10], along=other), 0, atol=0.017)


def test_texture_does_not_depend_on_gain_or_offset(rng):
    image = rng.standard_normal((50, 60))
    plain = texture.autocorrelation(image, [1, 2, 3], along="range_bin")
    assert_allclose(
        texture.autocorrelation(5 + 3 * image, [1, 2, 3], along="range_bin"),
        plain,
        rtol=1e-10,
        atol=1e-12,
    )


def test_white_noise_has_a_flat_spectrum_at_its_variance(rng):
    wavenumber, psd = texture.radial_psd(2 * rng.standard_normal((512, 384)), 16)
    # The Hann window leaves a quarter of the narrowest ring's 150 wavenumbers independent: 4 /
    # sqrt(38).
    assert_allclose(psd, 4, rtol=0.65)
    # All rings together hold pi / 4 of 196,608: four of 1 / sqrt(n / 2) is 1.4 %.
    assert_allclose(np.average(psd, weights=wavenumber), 4, rtol=0.014)


def test_a_wave_appears_in_the_ring_of_its_wavenumber():
    rows = np.arange(256)[:, None]
    wave = np.cos(2 * np.pi * 0.21 * rows) * np.ones(200)
    wavenumber, psd = texture.radial_psd(wave, 20)
    assert abs(wavenumber[np.argmax(psd)] - 0.21) <= 0.0125


def test_twice_the_contrast_is_six_decibels_away_and_height_does_not_count(rng):
    image = rng.standard_normal((128, 100))
    assert texture.radial_psd_distance_db(image, image) == 0
    assert_allclose(
        texture.radial_psd_distance_db(2 * image + 5, image), 20 * np.log10(2), rtol=1e-9
    )
    short, tall = rng.standard_normal((256, 256)), rng.standard_normal((900, 256))
    smooth = lfilter([1], [1, -0.8], tall, axis=1)
    assert (
        texture.radial_psd_distance_db(short, tall)
        < 1.5
        < texture.radial_psd_distance_db(short, smooth)
    )


def test_planted_offset_slope_and_curvature_come_back():
    lines = np.arange(101)
    layer_bins = np.stack([50 + 0.3 * lines, 160 + 0.01 * (lines - 50.0) ** 2])
    rows = np.arange(300)[:, None]
    image = sum(np.exp(-0.5 * ((rows - layer - 4) / 3) ** 2) for layer in layer_bins)
    found = texture.layer_position_error(image, layer_bins)
    # The brightest pixel is the nearest to the peak: half a bin.
    assert_allclose(found["error_bins"], 4, atol=0.5)
    inside = slice(4, -4)
    assert_allclose(found["slope"][0, inside], 0.3, rtol=1e-9)
    assert_allclose(found["slope"][1, inside], 0.02 * (lines - 50)[inside], atol=1e-9)
    assert_allclose(found["curvature"][0, inside], 0, atol=1e-9)
    assert_allclose(found["curvature"][1, inside], 0.02, rtol=1e-9)
    assert np.isnan(found["slope"][:, [0, 3, -4, -1]]).all()


def test_a_peak_beyond_half_way_belongs_to_the_neighbour_and_no_local_peak_gives_nan():
    image = np.zeros((100, 3))
    image[40] = 1
    image[46] = 9
    found = texture.layer_position_error(image, np.array([[39.0] * 3, [47.0] * 3]), window_lines=3)
    assert_allclose(found["error_bins"], [[1] * 3, [-1] * 3])
    ramp = np.broadcast_to(np.arange(100.0)[:, None], (100, 4))
    layer_bins = np.array([[50.0, np.nan, 0.0, 99.0]])
    assert np.isnan(texture.layer_position_error(ramp, layer_bins)["error_bins"]).all()
    assert np.isnan(texture.layer_position_error(np.ones((100, 4)), layer_bins)["error_bins"]).all()


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: texture.equivalent_number_of_looks([1.0]), "two or more"),
        (lambda: texture.equivalent_number_of_looks([1.0, -1.0]), "none negative"),
        (lambda: texture.equivalent_number_of_looks([0.0, 0.0]), "not all zero"),
        (
            lambda: texture.autocorrelation(np.ones((5, 5)), [1], along="range_bin"),
            "not be constant",
        ),
        (lambda: texture.autocorrelation(np.eye(5), [5], along="range_bin"), r"\[0, 4\]"),
        (
            lambda: texture.autocorrelation(np.eye(5), [1], along="slow_time"),
            "range_bin or range_line",
        ),
        (lambda: texture.radial_psd(np.eye(8), 32), "ring"),
        (lambda: texture.radial_psd(np.full((8, 8), np.nan)), "finite"),
        (lambda: texture.layer_position_error(np.eye(8), np.ones((1, 7))), "same range lines"),
        (lambda: texture.layer_position_error(np.eye(8), np.ones((1, 8)), window_lines=4), "odd"),
        (
            lambda: texture.layer_position_error(np.eye(8), np.ones((1, 8)), search_bins=0),
            "at least 1",
        ),
        (lambda: texture.layer_position_error(np.full((8, 8), np.nan), np.ones((1, 8))), "finite"),
    ],
)
def test_bad_input_is_refused(call, message):
    with pytest.raises(ValueError, match=message):
        call()
