"""From snow and a radar to the terms of eq. (1)."""

import numpy as np

from snowsim.constants import KOVACS_M3_KG, SPEED_OF_LIGHT_M_S


def physical_parameters(snowpack, radar):
    """What PHY renders of a snowpack: travel time [s] below the level of the mean surface, and parameters.

    Travel times (layer, range_line); `peak_power` (layer, range_line) relative to a flat mirror at the radar's height,
    `variance_bins2` and `decay_rate` (layer,). They are meant for ``normalise="none"`` and ``align="gaussian"``: the
    Gaussian lies at the interface's own travel time, and what width and tail spread is taken off its height.

    Interfaces are incoherent with each other, multiples are left out. Power: Fresnel at normal incidence with ``n = 1 +
    0.845 rho``, Kovacs et al. (1995), losses at the interfaces above, attenuation, spherical spreading, and the share
    that the beam takes in of what slopes scatter. Width: a Gaussian of the range response's height and area, wider by
    the roughness, ``2 n r / c``. Tail: `Radar.tail`.
    """
    index = 1 + KOVACS_M3_KG * np.r_[0 * snowpack.density_kg_m3[:1], snowpack.density_kg_m3]
    above, below = index[:-1], index[1:]
    depth_m = snowpack.depth_m
    below_s = 2 / SPEED_OF_LIGHT_M_S * np.cumsum(np.r_[depth_m[:1], above[1:] * np.diff(depth_m, axis=0)], axis=0)

    reflected = ((above - below) / (above + below)) ** 2
    passed = np.cumprod(np.r_[np.ones_like(reflected[:1]), (1 - reflected[:-1]) ** 2], axis=0)
    buried_m = depth_m - depth_m[:1]
    lost = 10 ** (-snowpack.attenuation_db_m * buried_m / 10) * (radar.height_m / (radar.height_m + depth_m)) ** 2

    response = (radar.cell_s / radar.bin_s) ** 2 / (2 * np.pi)
    rough = (2 * above.mean(axis=1) * snowpack.roughness_m / SPEED_OF_LIGHT_M_S / radar.bin_s) ** 2
    decay_per_s, share = radar.tail(snowpack.slope, radar.height_m + depth_m.mean(axis=1))
    decay = decay_per_s * radar.bin_s
    height = share * decay * np.sqrt(response / (response + rough))
    parameters = {
        "peak_power": reflected * passed * lost * height[:, None],
        "variance_bins2": response + rough,
        "decay_rate": decay,
    }
    return below_s, parameters
