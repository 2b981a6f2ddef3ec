import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import cumulative_trapezoid

from snowsim.constants import ICE_DENSITY_KG_M3, SPEED_OF_LIGHT_M_S
from snowsim.snowpack import firn

PROFILE = (0.25, 245.0, 340.0)  # accumulation, temperature, surface density


def test_depth_age_relation_equals_integrated_densification():
    accumulation_m, temperature_k, _ = PROFILE
    k0, k1 = firn.rates_herron_langway80(temperature_k)
    age_yr = np.linspace(0, 120, 200_001)
    water_m = accumulation_m * age_yr
    density = firn.density_herron_langway80(water_m, *PROFILE)
    first_stage = density < 550
    assert 0.1 < first_stage.mean() < 0.9
    rate = np.where(first_stage, k0 * accumulation_m, k1 * np.sqrt(accumulation_m))
    densified = cumulative_trapezoid(rate * (ICE_DENSITY_KG_M3 - density), age_yr, initial=0)
    # Trapezoids of 6e-4 years: (step / scale)^2 is 1e-9, and one step lies across both stages.
    assert_allclose(density, PROFILE[2] + densified, rtol=1e-6)
    depth_m = cumulative_trapezoid(1000 / density, water_m, initial=0)
    assert_allclose(firn.depth_herron_langway80(water_m, *PROFILE), depth_m, rtol=1e-6, atol=1e-9)


def test_travel_time_equals_integral_of_refractive_index():
    water_m = 9.0
    depth_m = float(firn.depth_herron_langway80(water_m, *PROFILE))
    grid_water_m = np.linspace(0, water_m, 20_001)
    grid_depth_m = firn.depth_herron_langway80(grid_water_m, *PROFILE)
    index = firn.refractive_index_kovacs95(firn.density_herron_langway80(grid_water_m, *PROFILE))
    numerical_s = 2 / SPEED_OF_LIGHT_M_S * np.trapezoid(index, grid_depth_m)
    # Trapezoids of 4.5e-4 m w.e.: error of order (step / scale)^2 = 1e-8.
    assert_allclose(firn.travel_time_s(depth_m, water_m), numerical_s, rtol=1e-7)


def test_rate_constants_have_the_published_activation_energies():
    # Herron & Langway (1980): 10.16 and 21.4 kJ/mol, to the last digit.
    warm, cold = firn.rates_herron_langway80(253.15), firn.rates_herron_langway80(223.15)
    energy = 8.314 * np.log(np.divide(warm, cold)) / (1 / 223.15 - 1 / 253.15)
    assert_allclose(energy, [10.16e3, 21.4e3], rtol=1e-3)


def test_density_is_that_of_a_core_of_north_greenland(shared_data):
    path = shared_data / "snow_radar" / "core_b26" / "b26_density_1mm.npz"
    if not path.is_file():
        pytest.skip(f"no core: {path} is no file")
    with np.load(path) as core:
        depth_m, density = core["midpoint_depth_m"], core["density_kg_m3"]
    # Core B26: .176 m w.e. a year (Weissbach et al. 2016, Clim. Past 12), some 243 K.
    water_m = np.linspace(0, 40, 4001)
    snow = (0.18, 243.0, 340.0)
    modelled = np.interp(
        np.arange(7.5, 40, 5),
        firn.depth_herron_langway80(water_m, *snow),
        firn.density_herron_langway80(water_m, *snow),
    )
    measured = [
        np.median(density[(depth_m > top) & (depth_m < top + 5)]) for top in range(5, 40, 5)
    ]
    # Herron & Langway (1980) find cores within some 2 %; half a rate is 10 % off at 40 m.
    assert_allclose(modelled, measured, rtol=0.025)


def test_permittivity_of_ice_is_that_of_kovacs():
    # Kovacs et al. (1995) find 3.15 for ice.
    assert_allclose(firn.refractive_index_kovacs95(917) ** 2, 3.15, atol=0.005)
