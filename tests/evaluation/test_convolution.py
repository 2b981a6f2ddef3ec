"""Range profiles of a sweep, stacks, and what simpler models make of them."""

import sys

import numpy as np
import pytest
from numpy.testing import assert_allclose

from evaluation.lib import coherent as convolution
from evaluation.lib.coherent import draw_lenses, draw_years, interface_delays_s, layered, reflect
from evaluation.lib.smrt_waveforms import import_smrt

BANDWIDTH_HZ = 6e9
DELAY_S = np.arange(-10, 150) * 2.886e-10
FREQUENCY_HZ = convolution.sweep_frequencies_hz(2e9, 8e9, 120e-9)
YEARS = {"mean_density_kg_m3": 400.0, "slab_m": 0.3, "roughness_m": 0.02}


def test_a_mirror_has_power_one_and_the_width_of_the_window_and_no_late_echo_is_folded_back():
    at_s = 60 * 2.886e-10
    mirror = np.exp(2j * np.pi * FREQUENCY_HZ * at_s)[None]
    x = np.array([0, -2, 2, 1]) / BANDWIDTH_HZ
    power = convolution.mean_profile(mirror, FREQUENCY_HZ, at_s + x)
    # The window is sampled at 721 frequencies: sums for integrals, second order.
    assert_allclose(power, [1, 0, 0, 0.25], atol=1e-5)
    late = np.exp(2j * np.pi * FREQUENCY_HZ * 110e-9)[None]
    assert convolution.mean_profile(late, FREQUENCY_HZ, DELAY_S).max() < 1e-6


def test_one_interface_is_the_same_coherent_and_not():
    at_s = 33.3 * 2.886e-10
    reflection = 0.2 * np.exp(2j * np.pi * FREQUENCY_HZ * at_s)
    coherent = convolution.mean_profile(reflection[None], FREQUENCY_HZ, DELAY_S)
    incoherent = convolution.incoherent_profile([[0.04]], [[at_s]], DELAY_S, BANDWIDTH_HZ)
    # Side lobes beyond 8 / B, below -60 dB, are left out.
    assert_allclose(incoherent, coherent, atol=0.04 * 1e-6)


def test_profile_peaks_where_a_layer_lies_and_as_high_as_it_reflects():
    index = np.array([[1.0, 1.3, 1.32]])
    thickness_m = np.array([[1.0]])
    [delay_s] = interface_delays_s(index, thickness_m)
    reflection, _ = reflect(index, thickness_m, FREQUENCY_HZ)
    power = convolution.mean_profile(reflection, FREQUENCY_HZ, delay_s)
    r1 = 0.3 / 2.3
    r2 = 0.02 / 2.62
    # 26 nulls apart the surface leaves less than -70 dB of itself, in amplitude 3e-4 of r1.
    assert_allclose(np.sqrt(power), [r1, (1 - r1**2) * r2], atol=1e-4)


def test_years_have_the_contrast_and_roughness_asked_for_and_lenses_keep_the_depths(rng):
    density, thickness_m = draw_years(2000, 6, 80.0, **YEARS, rng=rng)
    assert_allclose(np.abs(np.diff(density, axis=1)), 80)
    depth_m = np.cumsum(thickness_m, axis=1)
    assert_allclose(depth_m.std(axis=0), 0.02, rtol=4 / np.sqrt(2 * 2000))
    density, thickness_m = draw_years(50, 8, 80.0, **YEARS, rng=rng)
    with_lenses, thinner_m = draw_lenses(density, thickness_m, 3, lens_m=0.03, rng=rng)
    n_ice = (with_lenses == 917).sum(axis=1)
    assert (n_ice == 3).all()
    assert_allclose(thinner_m.sum(axis=1), thickness_m.sum(axis=1), rtol=1e-13)
    assert (thinner_m >= 0).all()
    assert with_lenses.shape[1] == thinner_m.shape[1] + 1 == density.shape[1] + 6


def test_impossible_stacks_are_refused(rng):
    denser = YEARS | {"mean_density_kg_m3": 700.0}
    with pytest.raises(ValueError, match=r"densities must lie in \[100, 917\] kg m-3, got 925"):
        draw_years(2, 3, 450.0, **denser, rng=rng)
    stack = draw_years(2, 3, 80.0, **YEARS, rng=rng)
    with pytest.raises(ValueError, match=r"n_lenses must lie in \[0, 3\], got 4"):
        draw_lenses(*stack, 4, lens_m=0.03, rng=rng)


def test_models_agree_where_layers_are_weak_and_part_where_they_are_strong(rng):
    years = YEARS | {"mean_density_kg_m3": 450.0}
    air = np.ones((64, 1))
    simpler = convolution.MODELS[1:]
    errors = {}
    for contrast in (3.0, 100.0, 600.0):
        density, thickness_m = draw_years(64, 15, contrast, **years, rng=rng)
        index = np.concatenate([air, 1 + 0.845e-3 * density], axis=1)
        works = convolution.model_works(index, thickness_m, FREQUENCY_HZ, DELAY_S, BANDWIDTH_HZ)
        assert tuple(works) == convolution.MODELS
        powers = {name: work() for name, work in works.items()}
        exact = powers["transfer matrix"]
        noise_power = 2e-3 * exact.max()
        for name in simpler:
            errors[name, contrast] = convolution.error_db(powers[name], exact, noise_power)
    assert errors["single scattering", 3.0] < 0.01
    for name in simpler:
        assert errors[name, 3.0] <= errors[name, 100.0] < 0.5
        assert errors[name, 600.0] > 2


def test_errors_are_decibels_over_the_noise():
    reference = np.array([1.0, 0.1])
    twice_db = 10 * np.log10(2)
    error_db = convolution.error_db(2 * reference, reference)
    assert_allclose(error_db, twice_db, rtol=1e-12)
    bias_db = convolution.bias_db(2 * reference, reference)
    assert_allclose(bias_db, twice_db, rtol=1e-12)
    over_noise_db = convolution.error_db([1.0, 0.0], [1.0, 1.0], 1.0)
    assert_allclose(over_noise_db, twice_db / np.sqrt(2), rtol=1e-12)
    with pytest.raises(ValueError, match="expected two positive, finite powers of one shape"):
        convolution.error_db([1.0], [1.0, 2.0])
    with pytest.raises(ValueError, match="expected two positive"):
        convolution.error_db([1.0, 0.0], [1.0, 2.0])


def test_a_layered_profile_ends_as_a_half_space(rng):
    density, thickness_m = layered(rng.normal(0, 50, (3, 40)), 340.0, 0.005)
    assert density.shape == (3, 40)
    assert thickness_m.shape == (3, 39)
    assert density.min() >= 100
    with pytest.raises(ValueError, match=r"but for 2%, \d+.\d% do not"):
        layered(rng.normal(0, 300, (3, 40)), 340.0, 0.005)


def test_a_missing_smrt_is_named_with_how_to_get_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "smrt", None)  # importing it then fails
    message = r"smrt, which is not installed: pip install 'snowsim\[studies\]'"
    with pytest.raises(ValueError, match=message):
        import_smrt()
