"""Elevation compensation as the archives store it, undone: every trace back to the travel times it was recorded at."""

import numpy as np

from snowsim.constants import SPEED_OF_LIGHT_M_S
from snowsim.io.guard import check_size, refusal


def undo_compensation(path, content, correction_bins, first_bin=None, n_recorded=None):
    """Shift every trace back by the bins that were inserted above it.

    Parameters
    ----------
    path : path_like
        For the message of a refusal.
    content : dict
        `Data` (range_bin, range_line) linear power, `twtt` (range_bin,) [s], `Elevation` [m], `Surface` and perhaps
        `Bottom` (range_line,) [s].
    correction_bins : array_like, (range_line,)
        `Elevation_Correction`: bins inserted above each trace to simulate level flight; whole, not negative.
    first_bin : int, optional
        Index, from 0, of the first kept row on the compensated travel-time axis (`Truncate_Bins`).
    n_recorded : int, optional
        Bins of a trace as recorded; where known, rows padded below it count as missing.

    Returns
    -------
    dict
        As `content`, with ``max(correction_bins)`` rows more; NaN where nothing was recorded.

    Notes
    -----
    ``twtt -= EC dt``, ``Surface -= EC dt``, ``Elevation -= EC dt c / 2``: the inverse of the CReSIS toolbox's
    compression, in which inserted bins hold zero power. They are NaN here, so that no zero passes for a measurement.
    """
    data, twtt = content["Data"], content["twtt"]
    correction_bins = np.asarray(correction_bins, dtype=float)
    whole = np.isfinite(correction_bins) & (correction_bins >= 0) & (correction_bins == np.floor(correction_bins))
    if not whole.all():
        found = f"{correction_bins[~whole][0]:g} at range_line {int(np.argmin(whole))}"
        raise refusal(path, "Elevation_Correction", "whole numbers of bins, not negative", found)
    n_rows, n_lines = data.shape
    n_extra = int(correction_bins.max(initial=0))
    check_size(path, "Elevation_Correction", (n_rows + n_extra, n_lines), data.dtype.itemsize)
    correction_bins = correction_bins.astype(int)

    shifted = np.full((n_rows + n_extra, n_lines), np.nan, dtype=data.dtype if data.dtype.kind == "f" else float)
    for line, bins in enumerate(correction_bins):
        start = 0 if first_bin is None else max(0, bins - first_bin)
        stop = n_rows if n_recorded is None else max(start, min(n_rows, n_recorded + bins - (first_bin or 0)))
        top = n_extra - bins
        shifted[top + start : top + stop, line] = data[start:stop, line]
    bin_size = (twtt[-1] - twtt[0]) / (twtt.size - 1)
    undone = {**content, "Data": shifted, "twtt": twtt[0] + bin_size * (np.arange(n_rows + n_extra) - n_extra)}
    undone["Elevation"] = content["Elevation"] - correction_bins * bin_size * SPEED_OF_LIGHT_M_S / 2
    for name in ("Surface", "Bottom"):
        if name in content:
            undone[name] = content[name] - correction_bins * bin_size
    return undone
