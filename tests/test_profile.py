"""Profiles as measured: interfaces within a range cell add in amplitude, others in power."""

import warnings
from functools import partial

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import snowsim
from evaluation.lib.profiles import BANDS, Kind, cell_errors, compared, draw_profile, profile_table
from snowsim.constants import SPEED_OF_LIGHT_M_S
from snowsim.physical import PRESETS, Climate, Snowpack, physical_parameters
from snowsim.profile import combine
from snowsim.seeding import random_stream

each_band = pytest.mark.parametrize("band", BANDS)


@pytest.fixture(scope="module")
def errors():
    return compared(profile_table(12, partial(random_stream, 3, "test_profile")))


@each_band
def test_mean_power_of_half_metre_cells_is_that_of_a_coherent_solver(errors, band):
    error_db = errors.loc[errors["radar"] == band, "error_db"].abs()
    # Asked of profiles from 1 mm to 20 cm with lenses; the study has 200 of them.
    assert error_db.median() < 1
    assert error_db.quantile(0.95) < 3


@pytest.mark.parametrize(
    ("band", "in_power_db"), [("accumulation", 13), ("ku-12-18", 3)], ids=["accumulation", "ku"]
)
def test_a_lens_of_5_mm_is_as_faint_as_the_solver_says(band, in_power_db):
    lens = ([0, 2.25, 2.255, 3.9], [350, 917, 350, 351])
    snow = Snowpack(*lens, roughness_m=0, slope=1e-5, coherent=True)
    cells = cell_errors(snow, PRESETS[band])
    around = cells[cells["depth_m"] == 2.0]
    assert abs(around["error_db"].item()) < 0.5
    # Twice the power of one interface, where the fields of the two almost cancel.
    assert around["in_power_db"].item() > in_power_db


def plain_parameters(snow, radar):
    """Delays and powers of interfaces that add in power, as they were before any combining."""
    index = 1 + 0.845e-3 * np.r_[0 * snow.density_kg_m3[:1], snow.density_kg_m3]
    above, below = index[:-1], index[1:]
    optical_m = np.r_[snow.depth_m[:1], above[1:] * np.diff(snow.depth_m, axis=0)]
    reflected = ((above - below) / (above + below)) ** 2
    passed = np.ones_like(reflected)
    passed[1:] = np.cumprod((1 - reflected[:-1]) ** 2, axis=0)
    spread = (radar.height_m / (radar.height_m + snow.depth_m)) ** 2
    return 2 / SPEED_OF_LIGHT_M_S * np.cumsum(optical_m, axis=0), reflected * passed * spread


@pytest.mark.parametrize("name", PRESETS)
def test_coarse_snow_is_what_it_was_to_the_byte(name, rng):
    radar = PRESETS[name]
    drawn = Climate(accumulation_m=0.3).draw(3, 5.2, rng=rng)
    for snow in (Snowpack([0, 1.0, 2.5], [340, 400, 350]), drawn):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            below_s, given = physical_parameters(snow, radar)
        expected_s, power = plain_parameters(snow, radar)
        decay_per_s, share = radar.tail(snow.slope, radar.height_m + snow.depth_m.mean(axis=1))
        response = (radar.cell_s / radar.bin_s) ** 2 / (2 * np.pi)
        decay_rate = decay_per_s * radar.bin_s
        height = share * decay_rate * np.sqrt(response / given["variance_bins2"])
        assert_array_equal(below_s, expected_s)
        assert_array_equal(given["peak_power"], power * height[:, None])


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
    kind = Kind(step_m=0.002, sd_kg_m3=30.0, lens_m=0.0)
    snow = draw_profile(kind, rng=np.random.default_rng(1))
    below_s, _ = physical_parameters(snow, radar)
    assert below_s[0, 0] == 0
    assert (np.diff(below_s[:, 0]) > 0).all()
    assert len(below_s) <= below_s[-1, 0] / radar.cell_s + 1


@pytest.mark.parametrize(
    ("delay_s", "reflection", "message"),
    [
        ([0, 9e-9, 4e-9], [0.1, 0.1, 0.1], "delay_s must be finite and not fall"),
        ([0, 1e-9], [0.1, 0.1, 0.1], "of one size"),
        ([0, 1e-9], [0, 0], "the surface's not 0"),
    ],
)
def test_delays_and_reflections_that_are_no_profile_are_refused(delay_s, reflection, message):
    with pytest.raises(ValueError, match=message):
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
    kind = Kind(step_m=0.005, sd_kg_m3=120.0, lens_m=0.0)
    snow = draw_profile(kind, rng=np.random.default_rng(1))
    with pytest.warns(UserWarning, match=r"below [\d.]+ m more than 4 dB are lost to reflections"):
        physical_parameters(snow, PRESETS["ku-12-18"])
