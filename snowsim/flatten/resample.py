"""Echograms at one bin size, since it differs by year and product."""

import numpy as np

from snowsim.echogram import bin_size_s


def resample_range(echogram, bin_s):
    """Echogram at another bin size.

    Larger bins hold the mean power of what they cover, smaller ones the power interpolated between bin centres; the
    first bin keeps its travel time. NaN spreads to every bin it touches. A file that has the bin size to within a
    millionth comes back as it is.

    Parameters
    ----------
    echogram : xarray.Dataset
    bin_s : float
        Wanted bin size in two-way travel time [s].

    Returns
    -------
    xarray.Dataset

    Raises
    ------
    ValueError
        If the bin size is not positive, or two of them do not fit into the echogram.
    """
    present_s = bin_size_s(echogram)
    if not bin_s > 0:
        msg = f"bin_s must be positive, got {bin_s}"
        raise ValueError(msg)
    if abs(bin_s / present_s - 1) < 1e-6:
        return echogram
    power = echogram["Data"].transpose("twtt", "slow_time").values
    ratio = bin_s / present_s
    n_rows = int((power.shape[0] - 1) / ratio) + 1
    if n_rows < 2:
        msg = f"bin_s {bin_s:g} s leaves fewer than two bins of {power.shape[0]} at {present_s:g} s"
        raise ValueError(msg)
    # To a millionth of a bin: a centre that falls on another must not lean on its neighbour, which may be missing.
    centres = np.round(ratio * np.arange(n_rows), 6)
    resampled = _box_means(power, centres, ratio) if ratio > 1 else _interpolated(power, centres)
    first_s = float(echogram["twtt"].values[0])
    dataset = echogram.drop_vars(["Data", "twtt"]).assign_coords(
        twtt=("twtt", first_s + bin_s * np.arange(n_rows), {"units": "s"})
    )
    dataset["Data"] = (("twtt", "slow_time"), resampled.astype(power.dtype, copy=False), echogram["Data"].attrs)
    return dataset.assign_attrs(resampled_from_bin_size_s=present_s)


def _box_means(power, centres, ratio):
    """Mean over boxes of `ratio` bins about `centres`, by differences of the running integral."""
    missing = ~np.isfinite(power)
    edges = np.clip(np.concatenate([centres - ratio / 2, [centres[-1] + ratio / 2]]) + 0.5, 0, power.shape[0])

    def between_edges(values):
        integral = np.concatenate([np.zeros((1, values.shape[1])), np.cumsum(values, axis=0, dtype=float)])
        whole = np.minimum(edges.astype(int), values.shape[0] - 1)
        return np.diff(integral[whole] + (edges - whole)[:, None] * values[whole], axis=0)

    means = between_edges(np.where(missing, 0, power)) / np.diff(edges)[:, None]
    means[between_edges(missing.astype(float)) > 1e-9] = np.nan
    return np.maximum(means, 0)  # the integral's rounding can leave -1e-17 of what stands above


def _interpolated(power, centres):
    left = np.minimum(centres.astype(int), power.shape[0] - 2)
    weight = (centres - left)[:, None]
    low, high = power[left], power[left + 1]
    return np.where(weight == 0, low, (1 - weight) * low + weight * high)
