"""Stand-in until the module of that name is merged."""

import numpy as np

from snowsim.statistics.blocks import thickness_blocks
from snowsim.statistics.surface import surface_statistics
from snowsim.statistics.zones import MINIMUM_BLOCKS, as_variables, zone_statistics


def thickness_statistics(frames, n_layers, *, estimator, zone_edge_bins=None):
    """Variables and counts of thickness."""
    thickness = thickness_blocks(frames, n_layers)
    zones = zone_statistics(thickness, zone_edge_bins, tapered=estimator != "paper")
    variables = as_variables(zones) | surface_statistics(frames, MINIMUM_BLOCKS)
    variables = {k: v for k, v in variables.items() if not k.endswith("_standard_error")}
    return variables, {k: v for k, v in zones.items() if not np.ndim(v)}
