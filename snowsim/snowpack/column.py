"""Depth and mass below the snow surface, for one density, for a profile, or for firn."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from snowsim.constants import ICE_DENSITY_KG_M3, SPEED_OF_LIGHT_M_S, WATER_DENSITY_KG_M3
from snowsim.limits import check_values
from snowsim.snowpack.firn import (
    depth_herron_langway80,
    temperature_fausto09,
    travel_time_s,
)
from snowsim.snowpack.profile import interfaces

SNOW_DENSITIES_KG_M3 = (50, ICE_DENSITY_KG_M3)
GREENLAND_LIMITS_DEG = ((59, 84), (-74, -10))  # latitude and longitude
GROUND_LIMITS_M = (-100, 3800)  # heights of its surface above the ellipsoid
DEEPEST_M = 500.0  # snow of one density ends at this depth
DEEPEST_FIRN_M_WE = 200.0  # Herron & Langway's firn ends below this mass


class DensityProfile(Protocol):
    """What a measured profile of density has, such as `snowsim.io.profiles.Profile`."""

    depth_m: NDArray[np.floating]
    density_kg_m3: NDArray[np.floating]
    thickness_m: NDArray[np.floating] | None


def temperature_k_of(layers):
    """Mean annual temperature [K] along a track in Greenland, at the height of its surface."""
    latitude, east, height_m = (
        layers.get(name, np.nan) for name in ("Latitude", "Longitude", "Elevation")
    )
    longitude = (east + 180) % 360 - 180
    ground_m = height_m - SPEED_OF_LIGHT_M_S / 2 * layers["twtt"].isel(layer=0)
    temperature_k = float(temperature_fausto09(ground_m, latitude, longitude).median())
    inside = [
        low < pd.Series(np.ravel(degrees)).median() < high  # NaN, without a warning, of none
        for degrees, (low, high) in zip((latitude, longitude), GREENLAND_LIMITS_DEG, strict=True)
    ]
    if not (all(inside) and np.isfinite(temperature_k)):
        msg = (
            "density: unknown outside Greenland, or without positions: give temperature_k, "
            "a density or a profile"
        )
        raise ValueError(msg)
    middle_m = float(pd.Series(np.ravel(ground_m)).median())
    if not GROUND_LIMITS_M[0] < middle_m < GROUND_LIMITS_M[1]:
        msg = (
            "layers: Elevation: expected heights of the radar over Greenland's snow, whose surface "
            f"is then at {GROUND_LIMITS_M[0]} to {GROUND_LIMITS_M[1]} m, found it at "
            f"{middle_m:.4g} m: correct it, or give temperature_k, a density or a profile"
        )
        raise ValueError(msg)
    return temperature_k


@dataclass(frozen=True, eq=False)
class Column:
    """Depth [m] and the mass above it [m w.e.], (sample,), down to the end of the density."""

    depth_m: np.ndarray
    water_m: np.ndarray

    @property
    def twtt_s(self):
        """Two-way travel time to every depth [s]."""
        return travel_time_s(self.depth_m, self.water_m)

    def at(self, values, below_s):
        """Values (sample,) at travel times below the surface [s], NaN below the column's end."""
        return np.interp(below_s, self.twtt_s, values, right=np.nan)


def column_of(density, temperature_k, mean_m):
    """`Column` of one density [kg m-3], of a profile, or of firn.

    Firn has a temperature [K], and `density` at its surface; `mean_m` is its mean accumulation
    [m w.e. / yr].
    """
    if hasattr(density, "density_kg_m3"):
        if temperature_k is not None:
            msg = "temperature_k: expected none beside a profile, whose density is known at depth"
            raise ValueError(msg)
        upper_m, density_kg_m3 = interfaces(
            density.depth_m, density.density_kg_m3, density.thickness_m
        )
        check_values("profile: density [kg m-3]", density_kg_m3, *SNOW_DENSITIES_KG_M3)
        # The last sample extends as far below its middle as above it.
        depth_m = np.append(upper_m, 2 * density.depth_m[-1] - upper_m[-1])
        slab_m = density_kg_m3 * np.diff(depth_m) / WATER_DENSITY_KG_M3
        return Column(depth_m, np.append(0, np.cumsum(slab_m)))
    check_values("density [kg m-3]", density, *SNOW_DENSITIES_KG_M3, number=True)
    if temperature_k is None:
        depth_m = np.array([0, DEEPEST_M])
        return Column(depth_m, depth_m * density / WATER_DENSITY_KG_M3)
    check_values("temperature_k", temperature_k, 200, 273.15, number=True)
    check_values("density of the surface [kg m-3]", density, 50, 549)
    # Samples are finest near the surface, where density changes fastest.
    water_m = np.linspace(0, np.sqrt(DEEPEST_FIRN_M_WE), 2000) ** 2
    return Column(depth_herron_langway80(water_m, mean_m, temperature_k, density), water_m)
