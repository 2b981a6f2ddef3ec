"""Errors against what may cause them: depth, slope, curvature."""

import numpy as np
import pandas as pd


def error_by_band(error, value, edges):
    """Summarise errors in bands of another quantity.

    Parameters
    ----------
    error : array_like
        NaN where the thing sought was not found.
    value : array_like, the shape of `error`
        What the bands are of; entries with NaN count nowhere.
    edges : array_like, (band + 1,)
        Ascending; a band holds its lower edge, the last one both.

    Returns
    -------
    pandas.DataFrame
        A row per band: `low, high, n, share_found, mean, mean_absolute, rms`; `n` counts found and not found, the last
        three are NaN where nothing was found.

    Raises
    ------
    ValueError
        If shapes differ or edges do not ascend.
    """
    error, value, edges = (np.asarray(array, dtype=float) for array in (error, value, edges))
    if error.shape != value.shape:
        msg = f"error and value must have one shape, got {error.shape} and {value.shape}"
        raise ValueError(msg)
    if edges.ndim != 1 or edges.size < 2 or not (np.diff(edges) > 0).all():
        msg = f"edges must be two or more ascending numbers, got {edges.tolist()}"
        raise ValueError(msg)
    band = np.searchsorted(edges, value, side="right") - 1
    band[value == edges[-1]] = edges.size - 2
    rows = []
    for i in range(edges.size - 1):
        inside = error[band == i]
        found = inside[np.isfinite(inside)]
        none = found.size == 0
        rows.append(
            {
                "low": edges[i],
                "high": edges[i + 1],
                "n": inside.size,
                "share_found": found.size / inside.size if inside.size else np.nan,
                "mean": np.nan if none else found.mean(),
                "mean_absolute": np.nan if none else np.abs(found).mean(),
                "rms": np.nan if none else np.sqrt(np.mean(found**2)),
            }
        )
    return pd.DataFrame(rows)
