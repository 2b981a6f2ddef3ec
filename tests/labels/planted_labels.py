"""Statistics of a flight with known thickness, relief and radiometry."""

import numpy as np
import xarray as xr

from snowsim.constants import STATISTICS_CONTENT

N_LINES = 256
SPACING_M = 5.0
RELIEF = {
    "relief_variance_bins2": [0.4, 0.6, 0.8, 1.0],
    "relief_length_m": [30.0, 40.0, 50.0, 60.0],
    "relief_exponent": [1.8, 1.5, 1.0, 2.0],
    "slab_change_bins2": [4.0, 3.0, 2.0, 1.0],
    "slab_exponent": [1.5, 1.2, 1.0, 0.8],
}
NUMBERS = {
    "noise_power": 1e-3,
    "surface_error_bins": 0.8,
    "surface_error_length_m": 200.0,
    "surface_movement_bins": 0.4,
    "surface_movement_length_m": 40.0,
    "surface_spread_db": 1.5,
    "common_spread_db": 3.0,
    "layer_spread_db": 2.0,
    "background_spread_db": 1.0,
    "further_spacing_bins": 30.0,
    "further_rise_db": 1.0,
}
PLAIN_RELIEF = dict.fromkeys(("relief_variance_bins2", "slab_change_bins2"), np.zeros(4))


def law(relief, lag_m):
    """Mean square change of a layer by itself, and of a slab, by the formulas of the relief."""
    falls = np.exp(-((lag_m / relief["relief_length_m"]) ** relief["relief_exponent"]))
    of_slab = relief["slab_change_bins2"] * (lag_m / 1000) ** relief["slab_exponent"]
    return 2 * relief["relief_variance_bins2"] * (1 - falls), of_slab


def planted(n_slabs=20, n_layers=(3, 8), **changes):
    """Statistics of four zones whose slabs thin with depth; variables may be changed."""
    slab = np.arange(n_slabs)
    by_layers = np.zeros((4, n_slabs + 1))
    by_layers[:, n_layers[0] : n_layers[1] + 1] = 10
    peak_power = 0.3 * 0.8 ** np.arange(8)
    peak_power[0] = 1
    variables = {
        "zone_edge_bins": ("edge", [15.0, 20, 25, 30, 40]),
        "first_thickness_quantile_bins": ("quantile", np.linspace(15, 40, 33)),
        "relative_thickness_mean": (("zone", "slab"), np.tile(1 - 0.02 * slab, (4, 1))),
        "relative_thickness_variance": (("zone", "slab"), np.full((4, n_slabs), 0.01)),
        "n_blocks_by_layers": (("zone", "n_layers"), by_layers),
        "peak_power": ("layer", peak_power),
        "variance_bins2": ("layer", np.full(8, 0.6)),
        "decay_rate": ("layer", np.full(8, 0.1)),
        "background_power": ("fall", [0.0, 5e-3, 1e-3]),
    }
    variables |= {name: ("zone", values) for name, values in RELIEF.items()}
    dataset = xr.Dataset(variables | NUMBERS, coords={"fall": [30.0, 100.0, 1000.0]})
    for name, values in changes.items():
        dataset[name] = dataset[name].dims, values
    attrs = {"content": STATISTICS_CONTENT, "n_looks": 1000.0, "line_spacing_m": SPACING_M}
    return dataset.assign_attrs(attrs)
