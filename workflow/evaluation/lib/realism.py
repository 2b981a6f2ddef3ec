"""What echograms measure, by the same functions for the flight and for pictures of real Snow Radar.

Every function takes a `Picture`, or means over 100 m in decibels, and gives numbers by quantity.
"""

import numpy as np
from scipy.signal import find_peaks

from evaluation.lib.pictures import BINS_PER_ROW, PRODUCT_ROW_S
from snowsim.constants import SPEED_OF_LIGHT_M_S
from snowsim.echogram import to_db

# Below the surface.
TOP_BINS = (50, 650)
FIRST_STAGE_BINS = np.array([50, 800])
SECOND_STAGE_BINS = np.array([800, 2000])
DEEP_BINS = (2000, 4000)
# The length of a bin of the Greenland frames is not known: from that of the products of 2016 to
# that of 2012 [m].
BIN_AIR_M = (PRODUCT_ROW_S * SPEED_OF_LIGHT_M_S / 2, 2.886e-10 * SPEED_OF_LIGHT_M_S / 2)
PROMINENCE_DB = 0.3  # least of a peak of the mean profile
SHIFT_ROWS = 12  # of a window whose shift is sought [rows of 16.3 bins]
MOST_SHIFT = 4  # how far [rows]
COLUMN_LAGS = (1, 2, 3, 5, 10)
ROW_LAGS = (1, 2, 3)
AIR_LAGS = (1, 2, 3, 5, 10)  # [range lines]
SNOW_LAGS = (1, 2, 3, 5, 10, 50)
DELAYS_NS = (0.1, 0.2, 0.3, 0.4, 0.5)
PERCENTILES = (1, 5, 25, 50, 75, 95, 99)
SLOW_LINES = 31  # what is slower is no change from range line to range line
SIDELOBE_NS = (2, 4, 6)
SMOOTH_NS = 1.0
SNOW_NS = np.array([5, 30])
SNOW_WINDOW_NS = 5
SNOW_OVER_NOISE_DB = 6
KNOWN_SHARE = 0.8  # least of a row's range lines
LOOKED_LINES = 11  # a simulator's pixels are means of 55 looks, 11 range lines of 5


def named(name, keys, values):
    """Values by a quantity's name, an asterisk in it replaced by the key of each."""
    return {name.replace("*", str(key)): value for key, value in zip(keys, values, strict=True)}


def correlation(deviation, lags, *, axis):
    """Autocorrelation of a deviation from a mean at lags [pixels] along an axis, (lag,).

    NaN is left out.
    """
    along = np.moveaxis(deviation, axis, 0)
    pairs = [np.nanmean(along[: len(along) - lag] * along[lag:]) for lag in lags]
    return np.array(pairs) / np.nanmean(along**2)


def rows_between(means, bins):
    """Rows of 100 m means between two limits below the surface [bins]."""
    first, end = (int(limit / BINS_PER_ROW) for limit in bins)
    return means[first:end]


def trend(values, degree):
    """A polynomial fitted to a profile down the rows."""
    rows = np.arange(len(values))
    return np.polyval(np.polyfit(rows, values, degree), rows)


def describe_decay(means, bin_air_m):
    """Decay of 100 m means with depth [dB per m of air], bins of a length in air [m].

    NaN beyond the data. Limits of the two stages are depths, those of bins of the real frames if
    these are as short as in 2016.
    """

    def decay(bins):
        rows = rows_between(means, bins)
        too_few = len(rows) * BINS_PER_ROW < 0.9 * (bins[1] - bins[0])
        if too_few or not np.isfinite(rows).all():
            return np.nan
        depth_m = np.arange(len(rows)) * BINS_PER_ROW * bin_air_m
        slope, _ = np.polyfit(depth_m, rows.mean(axis=1), 1)
        return slope

    first = decay(FIRST_STAGE_BINS * BIN_AIR_M[0] / bin_air_m)
    second = decay(SECOND_STAGE_BINS * BIN_AIR_M[0] / bin_air_m)
    return {
        "Greenland, decay of bins 50 to 650": decay(TOP_BINS),
        "Greenland, decay of the second stage": second,
        "Greenland, ratio of the two stages of decay": first / second,
        "Greenland, decay of bins 2000 to 4000": decay(DEEP_BINS),
    }


def describe_means(means):
    """Texture of 100 m means less their cubic fall, peaks of the mean profile, shift of layers."""
    rows = rows_between(means, TOP_BINS)
    texture = rows - trend(rows.mean(axis=1), 3)[:, None]
    _, peaks = find_peaks(texture.mean(axis=1), prominence=PROMINENCE_DB)
    prominence = peaks["prominences"]
    metres = [100 * lag for lag in COLUMN_LAGS]
    along = correlation(texture, COLUMN_LAGS, axis=1)
    down = correlation(texture, ROW_LAGS, axis=0)
    shifts = [shift_bins(texture, lag) for lag in COLUMN_LAGS]
    numbers = {"Greenland, texture s.d.": texture.std()}
    numbers |= named("Greenland, autocorrelation along track at * m", metres, along)
    numbers |= named("Greenland, autocorrelation down at * rows", ROW_LAGS, down)
    first, end = TOP_BINS
    numbers["Greenland, peaks"] = 1e3 * prominence.size / (end - first)
    median = np.median(prominence) if prominence.size else 0
    numbers["Greenland, prominence of peaks, median"] = median
    numbers["Greenland, prominence of peaks, largest"] = prominence.max(initial=0)
    numbers |= named("Greenland, shift of layers at * m", metres, shifts)
    return numbers


def shift_bins(texture, lag):
    """Median shift between columns at a lag [bins], sizes alone: where windows are most alike."""
    shifts = []
    for first in range(0, len(texture) - SHIFT_ROWS + 1, SHIFT_ROWS):
        window = texture[first : first + SHIFT_ROWS]
        columns = (window - window.mean(axis=0)).T
        for one, other in zip(columns[:-lag], columns[lag:], strict=True):
            alike = np.correlate(one, other, "full")
            alike = alike[SHIFT_ROWS - 1 - MOST_SHIFT : SHIFT_ROWS + MOST_SHIFT]
            best = int(np.argmax(alike))
            if 0 < best < 2 * MOST_SHIFT:  # no peak at an end of the reach
                left, middle, right = alike[best - 1 : best + 2]
                away = 0.5 * (left - right) / (left - 2 * middle + right)
                shifts.append(best - MOST_SHIFT + away)
    return BINS_PER_ROW * np.median(np.abs(shifts)) if shifts else np.nan


def describe_air(picture):
    """Noise: its distribution [dB], along track, and what lines and rows share beyond speckle."""
    air = picture.power_db[picture.air]
    known = np.isfinite(air).mean(axis=0) > KNOWN_SHARE
    air = air[:, known]
    deviation = air - np.nanmean(air)
    power = 10 ** (air / 10)
    percentiles = np.nanpercentile(deviation, PERCENTILES)
    along = correlation(deviation, AIR_LAGS, axis=1)
    numbers = {
        "air, s.d.": np.nanstd(air),
        "air, looks": np.nanmean(power) ** 2 / np.nanvar(power),
        "air, gain from line to line": common_sd(air, axis=0, slow=SLOW_LINES),
        "air, power from row to row": common_sd(air, axis=1),
    }
    numbers |= named("air, percentile *", PERCENTILES, percentiles)
    return numbers | named("air, autocorrelation along track at * lines", AIR_LAGS, along)


def common_sd(image, *, axis, slow=None):
    """Standard deviation [dB] of what means of both halves along an axis share.

    Speckle is independent and drops out. What changes over more than `slow` pixels is taken out
    first.
    """
    deviations = []
    for half in np.array_split(image, 2, axis=axis):
        mean = np.nanmean(half, axis=axis)
        if slow:
            padded = np.pad(mean, slow // 2, mode="edge")
            mean = mean - np.convolve(padded, np.full(slow, 1 / slow), "valid")
        deviations.append(mean - mean.mean())
    one, other = deviations
    return np.sqrt(max(0, np.mean(one * other)))


def describe_response(picture):
    """Autocorrelation of noise down range at equal delays, between rows on a straight line."""
    air = picture.power_db[picture.air]
    n_lags = int(max(DELAYS_NS) * 1e-9 / picture.row_s) + 2
    lag_ns = np.arange(n_lags) * picture.row_s * 1e9
    found = correlation(air - np.nanmean(air), range(n_lags), axis=0)
    values = np.interp(DELAYS_NS, lag_ns, found)
    return named("air, autocorrelation down at * ns", DELAYS_NS, values)


def describe_sidelobes(picture):
    """Power before the surface relative to it, noise taken off [dB].

    Nothing where the surface is rough: ridges within the footprint come before the nadir point and
    are no sidelobes.
    """
    row_ns = picture.row_s * 1e9
    if np.std(np.diff(picture.surface_row)) * row_ns > SMOOTH_NS:
        return {}
    n_before = int(max(SIDELOBE_NS) / row_ns) + 1
    power = 10 ** (picture.below_surface(-n_before, 1) / 10)
    power = np.nanmean(power, axis=1) - picture.noise()
    upwards = np.maximum(power / power[-1], 0)[::-1]
    before_ns = row_ns * np.arange(n_before + 1)
    levels = to_db(np.interp(SIDELOBE_NS, before_ns, upwards))
    return named("sidelobes, level before the surface at * ns", SIDELOBE_NS, levels)


def homogeneous_snow(picture):
    """The stretch of 5 ns whose mean profile is nearest to a straight line, (row, range_line).

    It lies well above noise; None where there is no such stretch.
    """
    first, end = (round(ns * 1e-9 / picture.row_s) for ns in SNOW_NS)
    length = round(SNOW_WINDOW_NS * 1e-9 / picture.row_s)
    below = picture.below_surface(first, end)
    # Not where picks are drawn over much of a row, or the picture ends for many range lines.
    known = np.isfinite(below).mean(axis=1) > KNOWN_SHARE
    below = below[known]
    level = to_db(np.nanmean(10 ** (below / 10), axis=1))
    floor_db = to_db(picture.noise()) + SNOW_OVER_NOISE_DB
    best = None
    least = np.inf
    for start in range(0, len(below) - length + 1, max(1, length // 5)):
        profile = level[start : start + length]
        uneven = np.std(profile - trend(profile, 1))
        if uneven < least and profile.min() > floor_db:
            best = below[start : start + length]
            least = uneven
    return best


def describe_snow(picture):
    """Speckle and texture of homogeneous snow about the mean of every row, if there is any."""
    snow = homogeneous_snow(picture)
    if snow is None:
        return {}
    deviation = snow - np.nanmean(snow, axis=1, keepdims=True)
    along = correlation(deviation, SNOW_LAGS, axis=1)
    numbers = {"snow, s.d.": np.nanstd(deviation)}
    return numbers | named("snow, autocorrelation along track at * lines", SNOW_LAGS, along)


def layer_power_correlation(power, layer_bins):
    """Correlation from one to the next of a layer's power averaged over 11 range lines [dB].

    All layers below the surface are pooled.
    """
    layer_bins = layer_bins[1:]
    rows = np.rint(np.nan_to_num(layer_bins)).astype(int)
    at_layers = np.take_along_axis(power, rows, axis=0)
    tracked = np.where(np.isfinite(layer_bins), at_layers, np.nan)
    n_layers, n_lines = tracked.shape
    n_means = n_lines // LOOKED_LINES
    in_groups = tracked[:, : n_means * LOOKED_LINES].reshape(n_layers, n_means, LOOKED_LINES)
    means = to_db(in_groups.mean(axis=2))
    known = means[np.isfinite(means).mean(axis=1) > 0.5]
    if known.size == 0:
        return np.nan
    deviation = known - np.nanmean(known, axis=1, keepdims=True)
    return correlation(deviation, (1,), axis=1)[0]
