"""What frames tell against themselves before statistics are made of them."""

import numpy as np

from snowsim.echogram import layer_bins_of, own_surface_bins
from snowsim.statistics.summaries import AIR_MARGIN_BINS

LEAST_AIR_BINS = 32
# Of skewness over coefficient of variation, between amplitude and power.
LEAST_OF_POWER = 1.4


def looks_like_amplitude(echogram, layers):
    """Whether noise above the surface is skewed as amplitude is, and enough of it is there to tell.

    Skewness over coefficient of variation is 2 for power of any number of looks, more for means of
    it with unequal weights and for mixtures; 1.2 for the amplitude of one look, 1 for that of many.
    """
    power = echogram["Data"].transpose("twtt", "slow_time").values
    # Layer 0 may be another layer.
    surface_bins = np.fmin(layer_bins_of(layers, echogram)[0], own_surface_bins(echogram))
    if not np.isfinite(surface_bins).any():
        return False
    air = power[: max(int(np.nanmin(surface_bins)) - AIR_MARGIN_BINS, 0)]
    air = air[:, (air > 0).all(axis=0)].astype(float)
    if len(air) < LEAST_AIR_BINS or air.size == 0:
        return False
    relative = air / air.mean(axis=0) - 1
    deviation = relative.std()
    skewness_error = np.sqrt(6 / relative.size)
    if deviation < 6 * skewness_error:
        return False
    skewness = (relative**3).mean() / deviation**3
    return skewness < LEAST_OF_POWER * deviation
