"""Radars in physical units against a coherent solver, the reference radar's annuli and echo."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from evaluation.lib.simulation import SPACING, solver_errors, tail_error_db
from snowsim.phy.waveform import waveform_exact, waveform_peak
from snowsim.physical import PRESETS, Snowpack, physical_parameters
from snowsim.reference import checked_settings
from snowsim.reference.firn import surface_reflectivity
from snowsim.reference.radar import interface_waveform, range_response

each_radar = pytest.mark.parametrize("radar", PRESETS.values(), ids=PRESETS)


@each_radar
@pytest.mark.parametrize("contrast_kg_m3", [30, 100, 250])
def test_delays_and_powers_are_those_of_a_coherent_solver(radar, contrast_kg_m3, rng):
    delay_bins, power_db = solver_errors(radar, contrast_kg_m3, SPACING, rng=rng)
    # Asked of `simulate`; beyond these contrasts the figure convolution_accuracy shows how they
    # grow.
    assert np.abs(delay_bins).max() < 0.1
    assert np.abs(power_db).max() < 0.5


@each_radar
# A chord of a tail that curves: 0.7 dB where the beam, not facets, ends it; the diffuse share adds
# 0.3 dB.
@pytest.mark.parametrize(
    ("slope", "share", "most_db"), [(0.03, 0, 0.05), (0.5, 0, 0.8), (0.03, 0.0007, 0.3)]
)
def test_tails_fall_as_the_integral_over_annuli_does(radar, slope, share, most_db):
    assert tail_error_db(radar, slope, diffuse_share=share) < most_db


def test_an_echo_has_the_height_and_the_trailing_edge_of_the_reference_radar_s():
    settings = checked_settings({"radar": {"diffuse_share": 0.0, "n_sub_bins": 16}}).radar
    response = range_response(settings).astype(float) ** 2
    wave = interface_waveform(settings, settings.horizon_slope, 0.02)
    # The reference radar spreads a unit of power, and refracts by 1.3 wherever an interface lies.
    received = np.convolve(wave.power.astype(float), response, mode="same") / response.max()
    snow = Snowpack([0.0], [340.0], roughness_m=0.02 * 1.3, slope=settings.horizon_slope)
    radar = PRESETS["snow-2012"]
    _, given = physical_parameters(snow, radar)
    shape = (given["variance_bins2"], given["decay_rate"])
    after_lead = np.arange(received.size) - wave.lead
    peak_bins, _ = waveform_peak(*shape)
    one = waveform_exact(after_lead / 16 + peak_bins, *shape)
    _, share = radar.tail(settings.horizon_slope, radar.height_m)
    ours = given["peak_power"][0] / (share * surface_reflectivity(340.0)) * one
    tail = (after_lead > 0) & (received > 0.01 * received.max())
    error_db = 10 * np.log10(ours[tail] / received[tail])
    # A Gaussian stands for the window's main lobe.
    assert np.abs(error_db).max() < 0.15


@pytest.mark.parametrize("roughness_m", [0.0, 0.01, 0.05])
def test_roughness_spreads_power_and_adds_none(roughness_m):
    radar = PRESETS["ku-12-18"]
    _, given = physical_parameters(Snowpack([0.0], [340.0], roughness_m, slope=0.1), radar)
    # Area of eq. (1): a Gaussian's times an exponential's. A Hann window's cell is 1.5 / B.
    gaussian = given["peak_power"][0] * np.sqrt(2 * np.pi * given["variance_bins2"])
    area = gaussian / given["decay_rate"]
    mirror = surface_reflectivity(340.0) * 1.5 / radar.bandwidth_hz / radar.bin_s
    _, share = radar.tail(0.1, radar.height_m)
    # 4096 frequencies of the window: 2.5e-4.
    assert_allclose(area / share, mirror, rtol=1e-3)
