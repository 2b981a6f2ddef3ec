"""Travel times in snow, by a sum of their own."""

import numpy as np

from snowsim.constants import KOVACS_M3_KG, SPEED_OF_LIGHT_M_S


def depth_to_delay(snow, depth_m):
    """Two-way travel time from the surface [s]."""
    index = 1 + KOVACS_M3_KG * snow.density_kg_m3[:, 0]
    interface_m = np.append(snow.depth_m[:, 0], 100.0)
    optical_m = np.append(0, np.cumsum(index * np.diff(interface_m)))
    return np.interp(depth_m, interface_m, 2 * optical_m / SPEED_OF_LIGHT_M_S)
