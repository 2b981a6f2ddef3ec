import numpy as np
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


def test_permittivity_of_ice_is_that_of_kovacs():
    # Kovacs et al. (1995) find 3.15 for ice.
    assert_allclose(firn.refractive_index_kovacs95(917) ** 2, 3.15, atol=0.005)
