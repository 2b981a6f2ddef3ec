import numpy as np
import pytest
from made_up import made_up_frame
from numpy.testing import assert_allclose

from snowsim.statistics import doppler_spectra, summarise
from snowsim.statistics.speckle import compare_with_gamma, range_correlation


@pytest.mark.parametrize("n_looks", [1, 5, 100])
def test_looks_of_gamma_power_come_back_whatever_its_brightness(rng, n_looks):
    brightness = np.exp(rng.standard_normal((500, 4, 1)))
    power = brightness * rng.gamma(n_looks, size=(500, 4, 20))
    found, observed, law = compare_with_gamma(power)
    # 40,000 samples: the variance, and so the looks, to 1 %.
    assert_allclose(found, n_looks, rtol=0.04)
    # Quantiles between 1 and 99 % of 40,000 values: to 1 % of the spread or 2 % of the value.
    assert_allclose(observed[3:-3], law[3:-3], rtol=0.02, atol=0.01)


RESPONSE = np.array([0.3, 1.0, 0.5, -0.1])  # of the amplitude, in range bins


def air_frame(rng, surface=130.0):
    """Air of 3 looks through `RESPONSE`, gain by line, bands, overloaded lines, a surface."""
    shape = (3, 160 + RESPONSE.size - 1, 4096)
    looks = rng.standard_normal(shape) + 1j * rng.standard_normal(shape)
    field = sum(tap * looks[:, i : i + 160] for i, tap in enumerate(RESPONSE))
    bands = 3 * (np.arange(160)[:, None] % 40 == 7)
    power = (np.abs(field) ** 2).mean(axis=0) + bands
    gain = np.exp(0.3 * rng.standard_normal(4096))
    power *= gain * np.where(np.arange(4096) % 512 == 100, 50, 1)
    power[110:] *= 1000
    layer_bins = np.array([surface, surface + 10])[:, None] * np.ones(4096)
    return made_up_frame(power, layer_bins)


def correlation_of(echogram, layers):
    summary = summarise(echogram, layers)
    return range_correlation(summary["air_products"].values, summary["air_pairs"].values)


def test_correlation_down_range_comes_back(rng):
    found = correlation_of(*air_frame(rng))
    amplitude = np.correlate(RESPONSE, RESPONSE, "full")[RESPONSE.size - 1 :]
    planted = np.pad((amplitude / amplitude[0]) ** 2, (0, 5))
    assert found[0] == 1
    # 400,000 pairs give 1 / sqrt(n) = 1.6e-3 and somewhat more: four of 2.5e-3.
    assert_allclose(found, planted, rtol=0, atol=0.01)


def test_without_air_or_speckle_bins_are_independent(rng):
    still = made_up_frame(np.ones((160, 512)), np.array([130.0, 140])[:, None] * np.ones(512))
    for frame in (air_frame(rng, surface=43.0), still):
        assert correlation_of(*frame).tolist() == [1] + 8 * [0]


def test_doppler_spectrum_of_a_steady_squint_is_a_line():
    amplitude = np.exp(2j * np.pi / 8 * np.arange(512)) * np.ones((40, 1))
    layer_bins = np.array([[5.0], [15], [25]]) * np.ones(512)
    wavenumber, first, mean = doppler_spectra(amplitude, layer_bins, 2.5)
    assert wavenumber[first.argmax()] == wavenumber[mean.argmax()] == 1 / 8 / 2.5
    assert_allclose(mean.mean(), 1, rtol=2**-10)  # spectra have 10 binary digits
