"""Layers on the range lines of an echogram, and as seen from its antenna."""

import numpy as np
import xarray as xr

from snowsim.constants import SPEED_OF_LIGHT_M_S
from snowsim.echogram import bin_size_s, check_layers


def align_layers(layers, echogram, where="layers"):
    """Layers on the range lines of an echogram, and as seen from its antenna.

    Parameters
    ----------
    layers, echogram : xarray.Dataset
        Of the Open Polar Radar convention, in UTC.
    where : str
        Names the layers in a message.

    Returns
    -------
    xarray.Dataset
        `twtt` (linear between neighbouring picks; NaN where either is missing), `quality` and `type` (of the nearer
        line) on (layer, slow_time) of the echogram.

    Raises
    ------
    ValueError
        If the layers do not cover the echogram's time span to within one of their own lines, if a layer lies outside
        the echogram's window, or if layers cross.

    Notes
    -----
    Layer files hold their own antenna elevation: ``t += 2 (z_echogram - z_layers) / c`` where both are known, as in
    the CReSIS toolbox. Without it nothing is added.
    """
    theirs, ours = layers["slow_time"].values, echogram["slow_time"].values
    left, weight = _between(theirs, ours, where)
    right = np.minimum(left + 1, theirs.size - 1)
    nearer = np.where(weight < 0.5, left, right)

    def at_lines(values):
        low, high = values[..., left], values[..., right]
        between = (1 - weight) * low + weight * high
        return np.where(weight == 0, low, np.where(weight == 1, high, between))

    twtt = at_lines(layers["twtt"].transpose("layer", "slow_time").values)
    if "Elevation" in layers:
        rise_m = echogram["Elevation"].values - at_lines(layers["Elevation"].values)
        twtt = twtt + np.where(np.isfinite(rise_m), rise_m, 0) * 2 / SPEED_OF_LIGHT_M_S
    _check_window(twtt, echogram, where)
    flags = {name: layers[name].transpose("layer", "slow_time") for name in ("quality", "type")}
    aligned = xr.Dataset(
        {
            "twtt": (("layer", "slow_time"), twtt, {"units": "s"}),
            **{name: (("layer", "slow_time"), flag.values[:, nearer], flag.attrs) for name, flag in flags.items()},
            "Elevation": ("slow_time", echogram["Elevation"].values, {"units": "m"}),
        },
        coords={"slow_time": ours, **{name: c for name, c in layers.coords.items() if c.dims == ("layer",)}},
        attrs=layers.attrs,
    )
    check_layers(aligned, where)
    return aligned


def _between(theirs, ours, where):
    """For every line of ours, the line of theirs before it and the share of the way to the next."""
    theirs_s = (theirs - theirs[0]) / np.timedelta64(1, "s")
    ours_s = (ours - theirs[0]) / np.timedelta64(1, "s")
    reach_s = np.median(np.diff(theirs_s)) if theirs_s.size > 1 else 0.0
    if ours_s[0] < -reach_s or ours_s[-1] > theirs_s[-1] + reach_s:
        msg = f"{where}: slow_time: expected to cover {ours[0]} to {ours[-1]}, found {theirs[0]} to {theirs[-1]}"
        raise ValueError(msg)
    # Beyond the ends, by less than a line: the outermost picks hold.
    ours_s = np.clip(ours_s, 0, theirs_s[-1])
    left = np.clip(np.searchsorted(theirs_s, ours_s, side="right") - 1, 0, max(theirs_s.size - 2, 0))
    if theirs_s.size == 1:
        return left, np.zeros(ours_s.size)
    return left, (ours_s - theirs_s[left]) / (theirs_s[left + 1] - theirs_s[left])


def _check_window(twtt, echogram, where):
    window = echogram["twtt"].values
    half_bin = bin_size_s(echogram) / 2
    outside = (twtt < window[0] - half_bin) | (twtt > window[-1] + half_bin)  # NaN is not outside
    if outside.any():
        layer, line = np.argwhere(outside)[0]
        msg = (
            f"{where}: twtt: expected layers within the echogram's window, {window[0]:.6g} to {window[-1]:.6g} s, "
            f"found {twtt[layer, line]:.6g} s at layer {layer}, range_line {line}"
        )
        raise ValueError(msg)
