"""Densification, permittivity and travel time of dry firn."""

from dataclasses import dataclass

import numpy as np

from snowsim.constants import (
    GAS_CONSTANT_J_MOL_K,
    ICE_DENSITY_KG_M3,
    KOVACS_M3_KG,
    SPEED_OF_LIGHT_M_S,
    WATER_DENSITY_KG_M3,
)

CRITICAL_DENSITY_KG_M3 = 550.0  # divides the two stages of Herron & Langway (1980)


def rates_herron_langway80(temperature_k):
    """Rate constants of both stages of densification, k0 [per m w.e.], k1 [per m w.e.^1/2 yr^1/2].

    ``k0 = 11 exp(-10160 / RT)``, ``k1 = 575 exp(-21400 / RT)``, Mg m-3: Herron & Langway (1980), J.
    Glaciol. 25, 373.
    """
    thermal = GAS_CONSTANT_J_MOL_K * np.asarray(temperature_k, dtype=float)
    return 11 * np.exp(-10160 / thermal), 575 * np.exp(-21400 / thermal)


def density_herron_langway80(water_m, accumulation_m, temperature_k, surface_density_kg_m3):
    """Steady-state density [kg m-3] under a mass of snow `water_m` [m w.e.].

    ``d rho / d age = k0 A (rho_ice - rho)`` below the critical density of 550 kg m-3 and ``k1 A^1/2
    (rho_ice - rho)`` above, with the mean accumulation A [m w.e. / yr]: Herron & Langway (1980), J.
    Glaciol. 25, 373-385. The mass `water_m` is A times the age, so that both stages integrate to an
    exponential approach to ice. The surface must be less dense than the critical density.
    """
    water_m = np.asarray(water_m, dtype=float)
    stages = _stages(accumulation_m, temperature_k, surface_density_kg_m3)
    ice = ICE_DENSITY_KG_M3
    first = ice - (ice - surface_density_kg_m3) * np.exp(-stages.k0 * water_m)
    beyond_m = np.maximum(water_m - stages.critical_water_m, 0)
    second_rate = stages.k1 * stages.inverse_root
    second = ice - (ice - CRITICAL_DENSITY_KG_M3) * np.exp(-second_rate * beyond_m)
    return np.where(water_m < stages.critical_water_m, first, second)


def depth_herron_langway80(water_m, accumulation_m, temperature_k, surface_density_kg_m3):
    """Depth [m] below a mass of snow; arguments as for `density_herron_langway80`.

    The closed depth-age relation of Herron & Langway (1980): ``ln(rho / (rho_ice - rho))`` grows
    linearly with depth, at the rate ``rho_ice k0`` where the density is below the critical one and
    ``rho_ice k1 / A^1/2`` where it is above, densities in Mg m-3.
    """
    stages = _stages(accumulation_m, temperature_k, surface_density_kg_m3)
    density = density_herron_langway80(
        water_m, accumulation_m, temperature_k, surface_density_kg_m3
    )
    ice = ICE_DENSITY_KG_M3 / WATER_DENSITY_KG_M3
    at_surface = _logit(surface_density_kg_m3)
    critical = _logit(CRITICAL_DENSITY_KG_M3)
    critical_depth_m = (critical - at_surface) / (ice * stages.k0)
    first = (_logit(density) - at_surface) / (ice * stages.k0)
    second_rate = ice * stages.k1 * stages.inverse_root
    second = critical_depth_m + (_logit(density) - critical) / second_rate
    return np.where(np.asarray(water_m) < stages.critical_water_m, first, second)


@dataclass(frozen=True)
class Stages:
    """Parameters of both stages of densification.

    `k0` and `k1` are the rate constants, `inverse_root` is A^-1/2, and `critical_water_m` is the
    mass of the first stage [m w.e.].
    """

    k0: float
    k1: float
    inverse_root: float
    critical_water_m: float


def _stages(accumulation_m, temperature_k, surface_density_kg_m3):
    k0, k1 = rates_herron_langway80(temperature_k)
    ice = ICE_DENSITY_KG_M3
    span = (ice - surface_density_kg_m3) / (ice - CRITICAL_DENSITY_KG_M3)
    return Stages(k0, k1, accumulation_m**-0.5, np.log(span) / k0)


def temperature_fausto09(elevation_m, latitude, longitude):
    """Annual mean air temperature over Greenland [K], from degrees north and east.

    ``41.83 - 6.309e-3 z - 0.7189 lat + 0.0672 lon_west`` in degrees Celsius, Fausto, Ahlstrom, van
    As, Boggild & Johnsen (2009), J. Glaciol. 55, 95-105.
    """
    return 273.15 + 41.83 - 6.309e-3 * elevation_m - 0.7189 * latitude + 0.0672 * -longitude


def _logit(density_kg_m3):
    return np.log(density_kg_m3 / (ICE_DENSITY_KG_M3 - density_kg_m3))


def refractive_index_kovacs95(density_kg_m3):
    """Refractive index of dry snow, in the shape of the densities [kg m-3].

    ``n = 1 + 0.845 rho``, rho in g cm-3, is the square root of the permittivity: Kovacs, Gow &
    Morey (1995), Cold Reg. Sci. Technol. 23, 245-256.
    """
    return 1 + KOVACS_M3_KG * np.asarray(density_kg_m3, dtype=float)


def travel_time_s(depth_m, water_m):
    """Two-way travel time [s] straight down from the snow surface to a depth [m].

    The mass above that depth is `water_m` [m w.e.]. The index n of Kovacs et al. (1995) is linear
    in density, so ``(2 / c) integral n dz`` is ``(2 / c) (depth + 0.845 water)`` for any profile.
    No integration step is needed, and fine layering of zero mean changes nothing.
    """
    optical_m = np.asarray(depth_m) + KOVACS_M3_KG * WATER_DENSITY_KG_M3 * np.asarray(water_m)
    return 2 * optical_m / SPEED_OF_LIGHT_M_S
