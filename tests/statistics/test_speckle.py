import numpy as np
import pytest
from numpy.testing import assert_allclose

from snowsim.statistics.speckle import compare_with_gamma, doppler_spectra


@pytest.mark.parametrize("n_looks", [1, 5, 100])
def test_looks_of_gamma_power_come_back_whatever_its_brightness(rng, n_looks):
    brightness = np.exp(rng.standard_normal((500, 4, 1)))
    fitted, error, _, observed, expected = compare_with_gamma(brightness * rng.gamma(n_looks, size=(500, 4, 20)))
    # 40,000 samples: the variance, and so the looks, to 1 %, and it says so.
    assert error < 0.02 * n_looks
    assert abs(fitted - n_looks) < 4 * error
    # Quantiles between 1 and 99 % of 40,000 values: to 1 % of the spread or 2 % of the value.
    assert_allclose(observed[3:-3], expected[3:-3], rtol=0.02, atol=0.01)


def test_power_of_another_law_does_not_fit(rng):
    _, _, _, observed, expected = compare_with_gamma(rng.choice([1.0, 3.0], size=(500, 4, 20)))
    assert np.abs(observed - expected).max() > 0.2


def test_doppler_spectrum_of_a_steady_squint_is_a_line(rng):
    n, spacing_m = 512, 2.5
    amplitude = 0.1 * (rng.standard_normal((40, n)) + 1j * rng.standard_normal((40, n)))
    amplitude += np.exp(2j * np.pi * 64 * np.arange(n) / n)
    wavenumber, first, mean = doppler_spectra(amplitude, np.array([[5.0], [15], [25]]) * np.ones(n), spacing_m)
    assert wavenumber[first.argmax()] == wavenumber[mean.argmax()] == 64 / n / spacing_m
    assert_allclose(mean.mean(), 1, rtol=1e-12)


def test_doppler_spectrum_of_white_speckle_is_flat(rng):
    n = 4096
    amplitude = rng.standard_normal((40, n)) + 1j * rng.standard_normal((40, n))
    rows = np.arange(2.0, 34, 2)[:, None] * np.ones(n)
    _, _, mean = doppler_spectra(amplitude, rows, 1.0)
    # Mean of 15 x 512 exponential values in each of 8 bands: to 1.1 %; allow four of those.
    assert_allclose(mean.reshape(8, -1).mean(axis=1), 1, rtol=0.046)


def test_a_gap_in_layer_1_is_refused():
    rows = np.array([[5.0, 5], [15, np.nan]])
    with pytest.raises(ValueError, match="layer 1 must be picked"):
        doppler_spectra(np.ones((40, 2), dtype=complex), rows, 1.0)
