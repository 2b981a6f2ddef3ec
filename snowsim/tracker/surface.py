"""Snow surface of an echogram: the range bin where power rises most above the air over it."""

import numpy as np
from scipy.ndimage import median_filter

from snowsim.compiling import compiled

AIR_BINS = 24  # bins of air above a surface that are averaged
# The rise at a surface exceeds the error of a mean of three bins, even with a single look.
LEAST_AIR_BINS = 3
SNOW_BINS = 3  # bins of snow below a surface that are averaged
LEAST_SNOW_BINS = 2
GUARD_BINS = 3  # between air and snow, for the edge of the echo
SMOOTH_LINES = 15  # of the running median
OUTLIER_BINS = 8.0  # largest distance from the running median
# A given surface that lies farther from the one found is wrong. If it is wrong on more than this
# share of the lines, it is not used at all.
WRONG_BINS = 15.0
WRONG_SHARE = 0.25
# A given surface may be wrong although it is near. The peak of an echo lies PEAK_BINS below the
# interface. A surface is biased if its median is more than OFF_BINS away from there and it either
# lies in the snow or sees less than RISE_SHARE of the largest rise of power [dB].
PEAK_BINS = 2.0
OFF_BINS = 3.0
RISE_SHARE = 1 / 3


def find_surface(power_db, given):
    """Surface found on every line, and share of its rise that power has at the given surface.

    `power_db` is (range_bin, range_line), `given` and both results are (range_line,). The surface
    is a range bin, NaN on lines without an echo: where the mean of the next bins exceeds the mean
    of the air above by most, it is the brightest of these bins. Lines on which too little air was
    recorded use the median air of other lines; without recorded snow there is no rise. A line far
    from the running median takes the median. The share is 1 where snow below the given surface was
    recorded but no air above it, and NaN where it is unknown.
    """
    n_bins, n_lines = power_db.shape
    known = np.isfinite(power_db).any(axis=0)
    if n_bins < AIR_BINS + GUARD_BINS + SNOW_BINS or not known.any():
        return np.full(n_lines, np.nan), np.full(n_lines, np.nan)
    # The least air is enough, and what lies above the first bin was not recorded.
    n_above = AIR_BINS - LEAST_AIR_BINS
    first = AIR_BINS + GUARD_BINS - n_above
    power_db = np.pad(power_db, ((n_above, 0), (0, 0)), constant_values=np.nan)
    snow = _means(power_db, SNOW_BINS, LEAST_SNOW_BINS)[first + n_above :]
    air = _means(power_db, AIR_BINS, LEAST_AIR_BINS)[: len(snow)]
    rise = snow - air
    unknown = np.isnan(rise)
    untold = unknown & np.isnan(air) & np.isfinite(snow)
    rise[unknown] = -np.inf
    steepest = rise.argmax(axis=0)[None]
    is_untold = untold.any()
    above = np.take_along_axis(air, steepest, axis=0)
    if is_untold and np.isfinite(above).any():
        rise = np.where(untold, snow - np.nanmedian(above), rise)
        steepest = rise.argmax(axis=0)[None]
    (largest,) = np.take_along_axis(rise, steepest, axis=0)
    at = first + steepest[0]
    near = at + n_above + np.arange(SNOW_BINS)[:, None]
    near_db = np.nan_to_num(np.take_along_axis(power_db, near, axis=0), nan=-np.inf)
    found = (at + near_db.argmax(axis=0)).astype(float)
    known &= np.isfinite(largest)
    found[known] = without_outliers(found[known])
    found[~known] = np.nan
    if is_untold:
        rise = np.where(untold, largest, rise)
    return found, _share_of_rise(rise, largest, given - first)


@compiled()
def _means(power_db, n, n_least):
    """Means of `n` bins from each bin on, (place, range_line), NaN if too few are known."""
    n_bins, n_lines = power_db.shape
    means = np.empty((n_bins - n + 1, n_lines))
    # Sums and numbers of known bins above the last rows, in a ring.
    total = np.zeros((n + 1, n_lines))
    count = np.zeros((n + 1, n_lines), np.int64)
    for row in range(n_bins):
        last = row % (n + 1)
        here = (row + 1) % (n + 1)
        start = (row + 1 - n) % (n + 1)
        for line in range(n_lines):
            known = np.isfinite(power_db[row, line])
            total[here, line] = total[last, line] + (power_db[row, line] if known else 0.0)
            count[here, line] = count[last, line] + known
        if row + 1 < n:
            continue
        for line in range(n_lines):
            n_known = count[here, line] - count[start, line]
            mean = np.nan
            if n_known >= n_least:
                mean = (total[here, line] - total[start, line]) / n_known
            means[row + 1 - n, line] = mean
    return means


def _share_of_rise(rise, largest, at):
    """Rise [dB] at one place of every line, (range_line,), as a share of the line's `largest`."""
    known = (at >= 0) & (at <= len(rise) - 1) & (largest > 0)
    lines = np.flatnonzero(known)
    share = np.full(at.size, np.nan)
    share[lines] = np.maximum(rise[np.rint(at[lines]).astype(int), lines], 0) / largest[lines]
    return share


def without_outliers(bins):
    """Bins by range line; those far from the running median are replaced by it."""
    smooth = median_filter(bins, SMOOTH_LINES, mode="nearest")
    return np.where(np.abs(bins - smooth) > OUTLIER_BINS, smooth, bins)


def select_surface(given, found, share, n_bins, coarseness=1.0):
    """Surface to use, and a note if it is not the given one, else None.

    The given surface is used where it agrees with the one found. Both are range bins by range
    line, NaN where unknown; gaps are filled. `share` is that of `find_surface`. Where the
    echogram's range bins are `coarseness` times larger than the tracker's, so are tolerances.
    """
    if not np.isfinite(given).any():
        return gaps_filled(found), "the file has no surface, it was found in the echogram"
    known = np.isfinite(given) & (given >= 0) & (given <= n_bins - 1)
    both = known & np.isfinite(found)
    outside = np.isfinite(given) & ~known
    wrong = ~known | (both & _is_far_off(given, found, share, coarseness))
    if outside.sum() > WRONG_SHARE * given.size:
        reason = (
            f"the file's surface lies outside the window on {outside.sum()} of {given.size} "
            "range lines, the strongest rise of power is taken for it"
        )
        return gaps_filled(found), reason
    biased = _is_biased(given[both], found[both], share[both], coarseness)
    if wrong.sum() <= WRONG_SHARE * given.size and not biased:
        return gaps_filled(np.where(wrong, found, given)), None
    n_wrong = (wrong | (both & (np.abs(found - given - PEAK_BINS) > OFF_BINS * coarseness))).sum()
    reason = (
        f"the file's surface is wrong on {n_wrong} of {given.size} range lines "
        "(none is given, or no echo rises there), it was found in the echogram"
    )
    return gaps_filled(found), reason


def _is_far_off(given, found, share, coarseness):
    """Lines on which the given surface is wrong because it is far from the one found, bool.

    It is not wrong where it is smooth and an echo rises at it: the surface found is then a brighter
    interface below.
    """
    n = min(SMOOTH_LINES, given.size)
    rises = median_filter(np.nan_to_num(share), n, mode="nearest") >= RISE_SHARE
    smooth = without_outliers(given) == given
    farthest = WRONG_BINS * coarseness
    below = found - given > farthest
    return (given - found > farthest) | (below & ~(rises & smooth))


def _is_biased(given, found, share, coarseness):
    """True if the given surface is near the one found but wrong in the median, see `OFF_BINS`."""
    if given.size == 0:
        return False
    off = np.median(found - given) - PEAK_BINS
    # No echo lies above a true surface. Below a faint one, a crust may be brighter.
    most = OFF_BINS * coarseness
    return off < -most or (off > most and np.median(share) < RISE_SHARE)


def gaps_filled(bins):
    """Bins by range line with gaps filled linearly."""
    known = np.isfinite(bins)
    lines = np.arange(bins.size)
    return np.interp(lines, lines[known], bins[known])
