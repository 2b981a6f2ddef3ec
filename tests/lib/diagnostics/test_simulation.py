"""Radars in physical units against a coherent solver, the reference radar's annuli and its whole echo."""

from dataclasses import replace

import numpy as np
import pytest

from lib.diagnostics.simulation import SPACING, solver_errors, tail_error_db
from snowsim.phy.waveform import waveform_exact, waveform_peak
from snowsim.physical.echo import physical_parameters
from snowsim.physical.radar import PRESETS
from snowsim.physical.snowpack import Snowpack
from snowsim.reference import checked_settings
from snowsim.reference.firn import surface_reflectivity
from snowsim.reference.radar import hann_response, interface_waveform, range_response

each_radar = pytest.mark.parametrize("radar", PRESETS.values(), ids=PRESETS)


@each_radar
@pytest.mark.parametrize("contrast_kg_m3", [30, 100, 250])
def test_delays_and_powers_are_those_of_a_coherent_solver(radar, contrast_kg_m3, rng):
    delay_bins, power_db = solver_errors(radar, contrast_kg_m3, SPACING, rng=rng)
    # Asked of `simulate`; beyond these contrasts the figure convolution_accuracy shows how they grow.
    assert np.abs(delay_bins).max() < 0.1
    assert np.abs(power_db).max() < 0.5


@each_radar
# The chord of a tail that curves: at most 0.7 dB where no facet is narrower than the beam; 0.3 dB by the diffuse share.
@pytest.mark.parametrize(("slope", "share", "most_db"), [(0.03, 0, 0.05), (0.5, 0, 0.8), (0.03, 0.0007, 0.3)])
def test_tails_fall_as_the_integral_over_annuli_does(radar, slope, share, most_db):
    assert tail_error_db(radar, slope, diffuse_share=share) < most_db


def test_an_echo_has_height_and_shape_of_the_reference_radar_s():
    settings = checked_settings({"radar": {"diffuse_share": 0.0, "n_sub_bins": 16}}).radar
    wave = interface_waveform(settings, settings.horizon_slope, 0.02)
    received = np.convolve(wave.power.astype(float), range_response(settings).astype(float) ** 2, mode="same")
    # The reference radar spreads a unit of power; a mirror's peak is that of its squared response alone.
    received /= (range_response(settings).astype(float) ** 2).max()
    radar = PRESETS["snow-2012"]
    # The reference radar refracts by 1.3 wherever an interface lies.
    snow = Snowpack([0.0], [340.0], roughness_m=0.02 * 1.3, slope=settings.horizon_slope)
    _, parameters = physical_parameters(snow, radar)
    shape = parameters["variance_bins2"], parameters["decay_rate"]
    offset, _ = waveform_peak(*shape)
    bins = (np.arange(received.size) - wave.lead) / 16 + offset
    share = radar.beam_share(settings.horizon_slope) * surface_reflectivity(340.0)
    ours = parameters["peak_power"][0] / share * waveform_exact(bins, *shape)
    tail = (bins > offset) & (received > 0.01 * received.max())
    level_db = 10 * np.log10(ours / received)[tail]
    # A Gaussian stands for the window's main lobe.
    assert np.abs(level_db).max() < 0.15


def test_range_cells_are_the_width_of_the_response():
    radar = PRESETS["snow-2-8"]
    delay_s = np.linspace(-3e-9, 3e-9, 60_001)
    width_s = (hann_response(delay_s, radar.bandwidth_hz) ** 2).sum() * (delay_s[1] - delay_s[0])
    # Side lobes beyond 18 / B are below 1e-10 of the width; 4096 frequencies are good to 1e-3.
    assert abs(radar.cell_s / width_s - 1) < 1e-3


def test_roughness_spreads_power_and_adds_none():
    radar = PRESETS["ku-12-18"]
    areas = []
    for roughness_m in (0.0, 0.01, 0.05):
        _, p = physical_parameters(Snowpack([0.0], [340.0], roughness_m, slope=0.1), radar)
        # Area of eq. (1): a Gaussian's times an exponential's.
        areas.append(float(p["peak_power"][0, 0] * np.sqrt(2 * np.pi * p["variance_bins2"][0]) / p["decay_rate"][0]))
    mirror = surface_reflectivity(340.0) * radar.cell_s / radar.bin_s
    np.testing.assert_allclose(areas, mirror * radar.beam_share(0.1), rtol=1e-12)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"bandwidth_hz": 11e9}, "bandwidth_hz must be positive and below 1e\\+10, got 11"),
        ({"height_m": -1.0}, "height_m must be positive"),
        ({"bin_s": 1e-12}, "bin_s must be longer"),
    ],
)
def test_impossible_radars_are_refused(change, message):
    with pytest.raises(ValueError, match=message):
        replace(PRESETS["snow-2-8"], **change)
