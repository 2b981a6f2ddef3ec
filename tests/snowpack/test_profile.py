"""Profiles as measured: interfaces within a range cell add in amplitude, others in power."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from refusals import refusal

import snowsim
from snowsim.constants import KOVACS_M3_KG, SPEED_OF_LIGHT_M_S
from snowsim.echogram import to_db
from snowsim.snowpack import PRESETS, Climate, Snowpack, combine, physical_parameters

# 600-900 MHz, 2-8, 12-18 and 2-18 GHz.
each_band = pytest.mark.parametrize("band", ["accumulation", "snow-2-8", "ku-12-18", "snow-2-18"])
LEVEL = {"roughness_m": 0.0, "slope": 1e-5, "coherent": True}


def steps_of_density(step_m, sd_kg_m3):
    """Snow of 4 m in steps of random density, denser with depth."""
    depth_m = np.arange(0, 4, step_m)
    density = 340 + 20 * depth_m
    density += sd_kg_m3 * np.random.default_rng(1).standard_normal(depth_m.size)
    return Snowpack(depth_m, np.clip(density, 100, 917), **LEVEL)


def transfer_matrix_power(snow, radar, delay_s):
    """Power of a Hann-weighted sweep over homogeneous slabs, every multiple included, (delay,).

    A mirror has 1. What comes back above an interface is ``(r + below) / (1 + r below)``, the
    quotient of the waves that a transfer matrix gives: Yeh (1988), Optical Waves in Layered Media,
    chapter 5.
    """
    index = np.append(1, 1 + KOVACS_M3_KG * snow.density_kg_m3[:, 0])
    # So many frequencies that no echo up to two and a half times the last delay folds back.
    n_frequencies = int(np.ceil(2.5 * radar.bandwidth_hz * delay_s[-1]))
    place = (np.arange(n_frequencies) + 0.5) / n_frequencies
    frequency_hz = radar.centre_hz + radar.bandwidth_hz * (place - 0.5)
    slab_s = np.append(0, 2 * index[1:-1] * np.diff(snow.depth_m[:, 0]) / SPEED_OF_LIGHT_M_S)
    back = 0
    for above, below, above_s in zip(index[-2::-1], index[:0:-1], slab_s[::-1], strict=True):
        r = (above - below) / (above + below)
        back = (r + back) / (1 + r * back) * np.exp(2j * np.pi * frequency_hz * above_s)
    weight = np.sin(np.pi * place) ** 2
    turn_back = np.exp(-2j * np.pi * np.outer(frequency_hz, delay_s))
    return np.abs((back * weight / weight.sum()) @ turn_back) ** 2


def depth_to_delay(snow, depth_m):
    """Two-way travel time from the surface [s], by a sum of its own."""
    index = 1 + KOVACS_M3_KG * snow.density_kg_m3[:-1, 0]
    optical_m = np.append(0, np.cumsum(index * np.diff(snow.depth_m[:, 0])))
    return np.interp(depth_m, snow.depth_m[:, 0], 2 * optical_m / SPEED_OF_LIGHT_M_S)


def simulated(snow, band):
    """Radar far above the snow, delays [s] and power of its mean echo, and delays of layers."""
    cell_s = PRESETS[band].cell_s
    plane = {"height_m": 1e6, "widening": 1.0, "bin_s": cell_s / 6}
    radar = replace(PRESETS[band], **plane, n_looks=1e5, surface_to_noise_db=90.0)
    with warnings.catch_warnings():
        # It tells what reflections above take; multiples count here.
        warnings.simplefilter("ignore", UserWarning)
        echogram, layers = snowsim.simulate(snow, radar, n_range_lines=1, rng=1)
    surface_s = 2 * radar.height_m / SPEED_OF_LIGHT_M_S
    delay_s = echogram["twtt"].values - surface_s
    below = delay_s > 0
    power = echogram["Data"].values[below, 0]
    return radar, delay_s[below], power, layers["twtt"].values[:, 0] - surface_s


@each_band
def test_simulated_echoes_are_those_of_a_transfer_matrix(band):
    # Slabs of 4 range cells and more: the surface's field has fallen to 1.5e-3 of its peak (Hann)
    # at the next layer, a tenth as strong: 1.5 %, .13 dB. Multiples are below 1e-3 of the field.
    density = np.array([340.0, 400.0, 350.0, 500.0, 380.0])
    slab_s = np.array([4, 5.3, 6.1, 4.7]) * PRESETS[band].cell_s
    slab_m = slab_s * SPEED_OF_LIGHT_M_S / 2 / (1 + KOVACS_M3_KG * density[:-1])
    slabs = Snowpack(np.append(0, np.cumsum(slab_m)), density, **LEVEL)
    radar, delay_s, power, layer_s = simulated(slabs, band)
    solved = transfer_matrix_power(slabs, radar, delay_s)
    at = [np.abs(delay_s - one_s).argmin() for one_s in layer_s]
    assert_allclose(to_db(power[at]), to_db(solved[at]), atol=0.15)

    # Ice of 5 mm, faint where the fields of its two interfaces almost cancel: r^2 of 2.5 %, left
    # out as multiples within it, is .2 dB.
    lens = Snowpack([0, 2.25, 2.255, 3.9], [350, 917, 350, 351], **LEVEL)
    radar, delay_s, power, layer_s = simulated(lens, band)
    solved = transfer_matrix_power(lens, radar, delay_s)
    around = np.abs(delay_s - layer_s[1]) < 1.5 * radar.cell_s
    assert abs(to_db(power[around].sum() / solved[around].sum())) < 0.3

    # Steps far within a range cell: mean power of half metres, below the surface's sidelobes.
    errors_db = []
    for step_m in (0.002, 0.01, 0.05):
        steps = steps_of_density(step_m, 30.0)
        radar, delay_s, power, _ = simulated(steps, band)
        solved = transfer_matrix_power(steps, radar, delay_s)
        bounds_s = depth_to_delay(steps, np.arange(1.5, 4.1, 0.5))
        sums = (np.histogram(delay_s, bounds_s, weights=each)[0] for each in (power, solved))
        errors_db.extend(to_db(np.divide(*sums)))
    assert np.median(np.abs(errors_db)) < 1
    assert np.abs(errors_db).max() < 3


def test_power_spreads_with_the_square_of_range_and_the_beam_takes_in_a_share_of_it(rng):
    snow = Climate(accumulation_m=0.3).draw(3, 5.2, rng=rng)
    by_height = []
    for height_m in (500.0, 1e6):
        radar = replace(PRESETS["snow-2-8"], height_m=height_m)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            _, given = physical_parameters(snow, radar)
        decay_per_s, share = radar.tail(snow.slope, height_m + snow.depth_m.mean(axis=1))
        # Bins and widths are the same of both.
        by_height.append(given["peak_power"] / (share * decay_per_s)[:, None])
    # Of the far radar less than 1e-4 is lost on the way through the snow.
    expected = (500 / (500 + snow.depth_m)) ** 2
    assert_allclose(by_height[0] / by_height[1], expected, rtol=1e-4)


@each_band
def test_interfaces_further_than_a_range_cell_apart_stay_as_they_are(band):
    depth_m = [0, 1.0, 2.5, 4.1]
    density = [340, 400, 350, 420]
    apart = physical_parameters(Snowpack(depth_m, density, coherent=False), PRESETS[band])
    combined = physical_parameters(Snowpack(depth_m, density, coherent=True), PRESETS[band])
    # Sums over 32 frequencies for one product: rounding.
    assert_allclose(combined[0], apart[0], rtol=1e-12)
    for name, values in apart[1].items():
        assert_allclose(combined[1][name], values, rtol=1e-12)


def test_there_is_one_reflector_a_range_cell_and_the_surface_is_the_first():
    radar = PRESETS["snow-2-8"]
    snow = steps_of_density(0.002, 30.0)
    below_s, _ = physical_parameters(snow, radar)
    assert below_s[0, 0] == 0
    assert (np.diff(below_s[:, 0]) > 0).all()
    assert len(below_s) <= below_s[-1, 0] / radar.cell_s + 1


@pytest.mark.parametrize(
    ("delay_s", "reflection", "message"),
    [
        ([0, 9e-9, 4e-9], [0.1, 0.1, 0.1], "delay_s must not fall: .*at least 0"),
        ([0, 1e-9], [0.1, 0.1, 0.1], "of one size"),
        ([0, 1e-9], [0, 0], "the surface's not 0"),
    ],
)
def test_delays_and_reflections_that_are_no_profile_are_refused(delay_s, reflection, message):
    with refusal(message):
        combine(delay_s, reflection, PRESETS["snow-2-8"].sweep)


def test_a_surface_of_another_height_delays_all_reflectors():
    sweep = PRESETS["snow-2-8"].sweep
    level = combine([0, 1e-10, 4e-9], [0.1, 0.1, 0.1], sweep)
    risen = combine([-3e-9, -2.9e-9, 1e-9], [0.1, 0.1, 0.1], sweep)
    assert_allclose(risen.power, level.power, rtol=1e-9)
    assert_allclose(risen.delay_s, level.delay_s - 3e-9, rtol=0, atol=1e-18)


def test_interfaces_closer_than_the_range_cell_are_told_of_where_they_add_in_power():
    thin = {"depth_m": [0, 1, 1.005], "density_kg_m3": [340, 600, 350]}
    with pytest.warns(UserWarning, match="1 interfaces lie within a range cell, 5 ns, of the one"):
        snowsim.simulate(Snowpack(**thin), "accumulation", rng=1)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        physical_parameters(Snowpack(**thin, coherent=False), PRESETS["accumulation"])
        physical_parameters(Snowpack(**thin, coherent=True), PRESETS["accumulation"])
        # Distances that vary by more than a wavelength there and back average the phases.
        depth_m = [np.zeros(64), np.ones(64), np.linspace(1.1, 1.4, 64)]
        drifted = Snowpack(depth_m, [[340], [600], [350]])
        physical_parameters(drifted, PRESETS["accumulation"])


def test_where_reflections_take_4_db_a_warning_tells_from_which_depth_on():
    snow = steps_of_density(0.005, 120.0)
    with pytest.warns(UserWarning, match=r"below [\d.]+ m more than 4 dB are lost to reflections"):
        physical_parameters(snow, PRESETS["ku-12-18"])
