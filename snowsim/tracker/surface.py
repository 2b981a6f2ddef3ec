"""The snow surface of an echogram: where power rises most over the air above it."""

import numpy as np
from scipy.ndimage import median_filter

AIR_BINS = 24  # whose mean is that of the air above
# A surface rises by more than such a mean of few bins errs, even of a single look.
LEAST_AIR_BINS = 3
SNOW_BINS = 3
LEAST_SNOW_BINS = 2
GUARD_BINS = 3  # between both: an echo has an edge
SMOOTH_LINES = 15
OUTLIER_BINS = 8.0
# A pick that lies farther off is wrong; where over a quarter of the lines are, all are.
WRONG_BINS = 15.0
WRONG_SHARE = 0.25
# Nearer ones may be, too. An echo is largest so far below the interface; a surface whose median
# lies so much farther off is wrong if it lies in the snow, or power hardly rises there: by less
# than this share of the largest rise [dB].
PEAK_BINS = 2.0
OFF_BINS = 3.0
RISE_SHARE = 1 / 3


def find_surface(power_db, given):
    """Range bin of the surface on every line of dB (range_bin, range_line), NaN without echo.

    It is the largest of the next few bins where their mean exceeds that of the air above by most,
    of what was recorded; where too little air was, its median above the surface of other lines
    counts; where too little snow was, nothing rises. A line that leaves the running median by more
    than a few bins takes the median. And by what share of that power rises at the surface given,
    (range_line,): all of it where the snow below was recorded but no air above, NaN where that is
    unknown.
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
    untold = np.isfinite(snow) & np.isnan(air)
    rise = np.nan_to_num(snow - air, nan=-np.inf)
    above = np.take_along_axis(air, rise.argmax(axis=0)[None], axis=0)
    if untold.any() and np.isfinite(above).any():
        rise = np.where(untold, snow - np.nanmedian(above), rise)
    at = first + rise.argmax(axis=0)
    near = at + n_above + np.arange(SNOW_BINS)[:, None]
    near_db = np.take_along_axis(np.nan_to_num(power_db, nan=-np.inf), near, axis=0)
    found = (at + near_db.argmax(axis=0)).astype(float)
    known &= np.isfinite(rise.max(axis=0))
    found[known] = without_outliers(found[known])
    found[~known] = np.nan
    rise = np.where(untold, rise.max(axis=0), rise)
    return found, _share_of_rise(rise, given - first)


def _means(power_db, n, n_least):
    """Means of `n` bins from each on, (place, range_line), NaN where too few are known."""
    present = np.isfinite(power_db)
    start = np.zeros((1, power_db.shape[1]))
    total = np.cumsum(np.r_[start, np.where(present, power_db, 0)], axis=0)
    count = np.cumsum(np.r_[start, present], axis=0)
    count = count[n:] - count[:-n]
    return np.where(count >= n_least, total[n:] - total[:-n], np.nan) / np.maximum(count, 1)


def _share_of_rise(rise, at):
    """Rise of dB (place, range_line) at places (range_line,), as a share of the line's largest."""
    largest = rise.max(axis=0)
    known = (at >= 0) & (at <= len(rise) - 1) & (largest > 0)
    lines = np.flatnonzero(known)
    share = np.full(at.size, np.nan)
    share[lines] = np.maximum(rise[np.rint(at[lines]).astype(int), lines], 0) / largest[lines]
    return share


def without_outliers(bins):
    """Bins by range line; one far from the running median is replaced by it."""
    smooth = median_filter(bins, SMOOTH_LINES, mode="nearest")
    return np.where(np.abs(bins - smooth) > OUTLIER_BINS, smooth, bins)


def chosen_surface(given, found, share, n_bins):
    """The surface given, if it lies near the one found, else the one found; and why, or None.

    Both are range bins by range line, NaN where unknown; gaps are bridged. `share` is that of
    `find_surface`.
    """
    if not np.isfinite(given).any():
        return gaps_filled(found), "the file has no surface, it was found in the echogram"
    known = np.isfinite(given) & (given >= 0) & (given <= n_bins - 1)
    both = known & np.isfinite(found)
    outside = np.isfinite(given) & ~known
    wrong = ~known | (both & _is_far_off(given, found, share))
    if outside.sum() > WRONG_SHARE * given.size:
        reason = f"the file's surface lies outside the window on {outside.sum()} of {given.size} "
        reason += "range lines, the strongest rise of power is taken for it"
        return gaps_filled(found), reason
    is_biased = _is_biased(given[both], found[both], share[both])
    if wrong.sum() <= WRONG_SHARE * given.size and not is_biased:
        return gaps_filled(np.where(wrong, found, given)), None
    n_wrong = (wrong | (both & (np.abs(found - given - PEAK_BINS) > OFF_BINS))).sum()
    reason = (
        f"the file's surface is wrong on {n_wrong} of {given.size} range lines "
        "(none is given, or no echo rises there), it was found in the echogram"
    )
    return gaps_filled(found), reason


def _is_far_off(given, found, share):
    """Whether a surface given lies far from the one found and is not to be believed, by line.

    Where an echo rises at it, and it is smooth, a brighter interface below is none to go by.
    """
    n = min(SMOOTH_LINES, given.size)
    rises = median_filter(np.nan_to_num(share), n, mode="nearest") >= RISE_SHARE
    smooth = without_outliers(given) == given
    below = found - given > WRONG_BINS
    return (given - found > WRONG_BINS) | (below & ~(rises & smooth))


def _is_biased(given, found, share):
    """Whether a surface given that lies near the one found is wrong all the same, in the median."""
    if given.size == 0:
        return False
    off = np.median(found - given) - PEAK_BINS
    # Above the surface given nothing rises; below a faint one, crusts may rise by more.
    return off < -OFF_BINS or (off > OFF_BINS and np.median(share) < RISE_SHARE)


def gaps_filled(bins):
    """Bins by range line, gaps filled in straight lines."""
    known = np.isfinite(bins)
    lines = np.arange(bins.size)
    return np.interp(lines, lines[known], bins[known])
