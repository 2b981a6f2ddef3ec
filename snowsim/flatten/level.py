"""Surface flattening and elevation compensation: traces shifted by whole bins, nothing lost."""

import numpy as np
import xarray as xr

from snowsim.constants import SPEED_OF_LIGHT_M_S
from snowsim.echogram import bin_size_s, layer_bins_of

METHODS = ("surface", "elevation", "none")


def flatten(echogram, layers, *, method="surface"):
    """Shift traces by whole bins so that the surface, or the aircraft, stays level.

    A frame that is level already comes back as it is, so files compensated before need no setting. Nothing is lost:
    rows are added at both ends, NaN where no trace reaches.

    Parameters
    ----------
    echogram, layers : xarray.Dataset
        On the same range lines (`align_layers`), layer 0 the snow surface.
    method : {"surface", "elevation", "none"}
        "surface" puts layer 0, or the line between its neighbours where it is not picked, into the row of its median;
        "elevation" takes out the aircraft's change of height above the ellipsoid, as the CReSIS toolbox does.

    Returns
    -------
    echogram, layers : xarray.Dataset
        Shifted alike; `Elevation`, `Surface` and `twtt` of the layers move along. Where the shift of a line is k bins,
        ``Elevation += k dt c / 2`` and ``t += k dt``.

    Raises
    ------
    ValueError
        If the method is unknown, or the surface is not picked at all.
    """
    if method not in METHODS:
        msg = f"method must be one of {', '.join(METHODS)}, got {method}"
        raise ValueError(msg)
    if method == "none":
        return echogram, layers
    bin_s = bin_size_s(echogram)
    if method == "surface":
        shift = _level(layer_bins_of(layers, echogram)[0], "layer 0 (the snow surface)")
    else:
        shift = _level(echogram["Elevation"].values / (SPEED_OF_LIGHT_M_S / 2 * bin_s), "Elevation")
    if not shift.any():
        return echogram, layers
    return _shifted(echogram, layers, shift, bin_s)


def _level(bins, what):
    """Whole shift of every line that puts `bins` into the row of their median; gaps are bridged."""
    known = np.isfinite(bins)
    if not known.any():
        msg = f"{what} is nowhere known, so the frame cannot be levelled"
        raise ValueError(msg)
    lines = np.arange(bins.size)
    # Halves go up, not to even: a shift by whole bins must not change how a row is rounded.
    rows = np.floor(np.interp(lines, lines[known], bins[known]) + 0.5).astype(int)
    return int(np.floor(np.median(rows))) - rows


def _shifted(echogram, layers, shift, bin_s):
    power = echogram["Data"].transpose("twtt", "slow_time").values
    n_bins, n_lines = power.shape
    lowest, highest = int(min(shift.min(), 0)), int(max(shift.max(), 0))
    moved = np.full((n_bins + highest - lowest, n_lines), np.nan, dtype=np.result_type(power.dtype, np.float32))
    for line, bins in enumerate(shift):
        moved[bins - lowest : bins - lowest + n_bins, line] = power[:, line]
    twtt = echogram["twtt"].values[0] + bin_s * (np.arange(moved.shape[0]) + lowest)
    level = echogram.drop_vars(["Data", "twtt"]).assign_coords(twtt=("twtt", twtt, {"units": "s"}))
    level["Data"] = (("twtt", "slow_time"), moved, echogram["Data"].attrs)
    delay = xr.DataArray(shift * bin_s, dims="slow_time")
    moved_layers = layers.copy()
    for dataset, names in ((level, ("Surface", "Bottom")), (moved_layers, ("twtt",))):
        for name in names:
            if name in dataset:
                dataset[name] = (dataset[name] + delay).transpose(*dataset[name].dims).assign_attrs(units="s")
    for dataset in (level, moved_layers):
        if "Elevation" in dataset:
            dataset["Elevation"] = (dataset["Elevation"] + delay * SPEED_OF_LIGHT_M_S / 2).assign_attrs(units="m")
    return level, moved_layers
