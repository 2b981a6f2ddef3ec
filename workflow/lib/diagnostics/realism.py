"""What echograms measure, by one set of functions for frames of the flight and for pictures of real Snow Radar.

Every function takes a `Picture`, or means over 100 m in decibels, and gives numbers by quantity.
"""

import numpy as np
from scipy.signal import find_peaks

from lib.diagnostics.pictures import BINS_PER_ROW, PRODUCT_ROW_S
from snowsim.constants import SPEED_OF_LIGHT_M_S
from snowsim.echogram import to_db

TOP_BINS, STAGES_BINS, DEEP_BINS = (
    (50, 650),
    ((50, 800), (800, 2000)),
    (2000, 4000),
)  # below the surface
# The length of a bin of the Greenland frames is not known: from that of the products of 2016 to
# that of 2012 [m].
BIN_AIR_M = (PRODUCT_ROW_S * SPEED_OF_LIGHT_M_S / 2, 2.886e-10 * SPEED_OF_LIGHT_M_S / 2)
PROMINENCE_DB = 0.3  # least of a peak of the mean profile
SHIFT_ROWS, MOST_SHIFT = 12, 4  # [rows of 16.3 bins] of a window whose shift is sought, and how far
COLUMN_LAGS, ROW_LAGS = (1, 2, 3, 5, 10), (1, 2, 3)
AIR_LAGS, SNOW_LAGS = (1, 2, 3, 5, 10), (1, 2, 3, 5, 10, 50)  # [range lines]
DELAYS_NS = (0.1, 0.2, 0.3, 0.4, 0.5)
PERCENTILES = (1, 5, 25, 50, 75, 95, 99)
SLOW_LINES = 31  # what is slower is no change from range line to range line
SIDELOBE_NS, SMOOTH_NS = (2, 4, 6), 1.0
SNOW_NS, SNOW_WINDOW_NS, SNOW_OVER_NOISE_DB = (5, 30), 5, 6
KNOWN_SHARE = 0.8  # least of a row's range lines
LOOKED_LINES = 11  # a simulator's pixels are means of 55 looks, 11 range lines of 5


def named(name, keys, values):
    """Values by a quantity's name, an asterisk in it replaced by the key of each."""
    return {name.replace("*", str(key)): value for key, value in zip(keys, values, strict=True)}


def correlation(deviation, lags, *, axis):
    """Autocorrelation at lags [pixels] along an axis of a deviation from a mean, NaN left out, (lag,)."""
    along = np.moveaxis(deviation, axis, 0)
    pairs = [np.nanmean(along[: len(along) - lag] * along[lag:]) for lag in lags]
    return np.array(pairs) / np.nanmean(along**2)


def rows_between(means, bins):
    """Rows of 100 m means between two limits below the surface [bins]."""
    return means[slice(*(int(limit / BINS_PER_ROW) for limit in bins))]


def describe_decay(means, bin_air_m):
    """Decay of 100 m means with depth [dB per m of air] for bins of a length in air [m]; NaN beyond the data.

    Limits of the two stages are depths, those of bins of the real frames if these are as short as
    in 2016.
    """

    def decay(bins):
        rows = rows_between(means, bins)
        if len(rows) * BINS_PER_ROW < 0.9 * (bins[1] - bins[0]) or not np.isfinite(rows).all():
            return np.nan
        return np.polyfit(np.arange(len(rows)) * BINS_PER_ROW * bin_air_m, rows.mean(axis=1), 1)[0]

    stages = [decay(np.array(bins) * BIN_AIR_M[0] / bin_air_m) for bins in STAGES_BINS]
    return {
        "Greenland, decay of bins 50 to 650": decay(TOP_BINS),
        "Greenland, decay of the second stage": stages[1],
        "Greenland, ratio of the two stages of decay": stages[0] / stages[1],
        "Greenland, decay of bins 2000 to 4000": decay(DEEP_BINS),
    }


def describe_means(means):
    """Texture of 100 m means less their cubic fall, peaks of their mean profile, and how smooth layers are."""
    rows = rows_between(means, TOP_BINS)
    depth_rows = np.arange(len(rows))
    texture = rows - np.polyval(np.polyfit(depth_rows, rows.mean(axis=1), 3), depth_rows)[:, None]
    prominence = find_peaks(texture.mean(axis=1), prominence=PROMINENCE_DB)[1]["prominences"]
    along, down = (
        correlation(texture, lags, axis=axis) for lags, axis in ((COLUMN_LAGS, 1), (ROW_LAGS, 0))
    )
    metres = [100 * lag for lag in COLUMN_LAGS]
    return {
        "Greenland, texture s.d.": texture.std(),
        **named("Greenland, autocorrelation along track at * m", metres, along),
        **named("Greenland, autocorrelation down at * rows", ROW_LAGS, down),
        "Greenland, peaks": 1e3 * prominence.size / (TOP_BINS[1] - TOP_BINS[0]),
        "Greenland, prominence of peaks, median": np.median(prominence) if prominence.size else 0,
        "Greenland, prominence of peaks, largest": prominence.max(initial=0),
        **named(
            "Greenland, shift of layers at * m",
            metres,
            [shift_bins(texture, lag) for lag in COLUMN_LAGS],
        ),
    }


def shift_bins(texture, lag):
    """Median shift between columns at a lag [bins], sizes alone: where windows of 12 rows are most alike."""
    shifts = []
    for window in (
        texture[i : i + SHIFT_ROWS] for i in range(0, len(texture) - SHIFT_ROWS + 1, SHIFT_ROWS)
    ):
        window = window - window.mean(axis=0)
        for one, other in zip(window.T[:-lag], window.T[lag:], strict=True):
            alike = np.correlate(one, other, "full")[
                SHIFT_ROWS - 1 - MOST_SHIFT : SHIFT_ROWS + MOST_SHIFT
            ]
            best = int(np.argmax(alike))
            if 0 < best < 2 * MOST_SHIFT:  # no peak at an end of the reach
                left, middle, right = alike[best - 1 : best + 2]
                shifts.append(
                    best - MOST_SHIFT + 0.5 * (left - right) / (left - 2 * middle + right)
                )
    return BINS_PER_ROW * np.median(np.abs(shifts)) if shifts else np.nan


def describe_air(picture):
    """Noise: its distribution in decibels, along track, and what range lines and rows differ by beyond speckle."""
    air = picture.power_db[picture.air]
    air = air[:, np.isfinite(air).mean(axis=0) > KNOWN_SHARE]
    deviation = air - np.nanmean(air)
    power = 10 ** (air / 10)
    return {
        "air, s.d.": np.nanstd(air),
        "air, looks": np.nanmean(power) ** 2 / np.nanvar(power),
        "air, gain from line to line": common_sd(air, axis=0, slow=SLOW_LINES),
        "air, power from row to row": common_sd(air, axis=1),
        **named("air, percentile *", PERCENTILES, np.nanpercentile(deviation, PERCENTILES)),
        **named(
            "air, autocorrelation along track at * lines",
            AIR_LAGS,
            correlation(deviation, AIR_LAGS, axis=1),
        ),
    }


def common_sd(image, *, axis, slow=None):
    """Standard deviation [dB] of what means of both halves along an axis share: speckle, independent, drops out.

    What changes over more than `slow` pixels is taken out first.
    """
    means = [np.nanmean(half, axis=axis) for half in np.array_split(image, 2, axis=axis)]
    if slow:
        kernel = np.full(slow, 1 / slow)
        means = [
            mean - np.convolve(np.pad(mean, slow // 2, mode="edge"), kernel, "valid")
            for mean in means
        ]
    one, other = (mean - mean.mean() for mean in means)
    return np.sqrt(max(0, np.mean(one * other)))


def describe_response(picture):
    """Autocorrelation of noise down range at equal delays, between rows on a straight line."""
    air = picture.power_db[picture.air]
    n_lags = int(max(DELAYS_NS) * 1e-9 / picture.row_s) + 2
    found = correlation(air - np.nanmean(air), range(n_lags), axis=0)
    values = np.interp(DELAYS_NS, np.arange(n_lags) * picture.row_s * 1e9, found)
    return named("air, autocorrelation down at * ns", DELAYS_NS, values)


def describe_sidelobes(picture):
    """Power before the surface relative to it, noise taken off [dB]; nothing where the surface is rough.

    Ridges within the footprint come before the nadir point and are no sidelobes.
    """
    row_ns = picture.row_s * 1e9
    if np.std(np.diff(picture.surface_row)) * row_ns > SMOOTH_NS:
        return {}
    first = -int(max(SIDELOBE_NS) / row_ns) - 1
    power = np.nanmean(10 ** (picture.below_surface(first, 1) / 10), axis=1) - picture.noise()
    values = np.interp(
        SIDELOBE_NS, -row_ns * np.arange(first, 1)[::-1], np.maximum(power / power[-1], 0)[::-1]
    )
    return named("sidelobes, level before the surface at * ns", SIDELOBE_NS, to_db(values))


def homogeneous_snow(picture):
    """The stretch of 5 ns whose mean profile is nearest to a straight line, well above noise, (row, range_line).

    None where there is no such stretch.
    """
    first, end, length = (round(ns * 1e-9 / picture.row_s) for ns in (*SNOW_NS, SNOW_WINDOW_NS))
    below = picture.below_surface(first, end)
    # Not where picks are drawn over much of a row, or the picture ends for many range lines.
    below = below[np.isfinite(below).mean(axis=1) > KNOWN_SHARE]
    level = to_db(np.nanmean(10 ** (below / 10), axis=1))
    best, least, rows = None, np.inf, np.arange(length)
    for start in range(0, len(below) - length + 1, max(1, length // 5)):
        profile = level[start : start + length]
        uneven = np.std(profile - np.polyval(np.polyfit(rows, profile, 1), rows))
        if uneven < least and profile.min() > to_db(picture.noise()) + SNOW_OVER_NOISE_DB:
            best, least = below[start : start + length], uneven
    return best


def describe_snow(picture):
    """Speckle and texture of homogeneous snow about the mean of every row; nothing where all of it is near noise."""
    snow = homogeneous_snow(picture)
    if snow is None:
        return {}
    deviation = snow - np.nanmean(snow, axis=1, keepdims=True)
    along = correlation(deviation, SNOW_LAGS, axis=1)
    return {
        "snow, s.d.": np.nanstd(deviation),
        **named("snow, autocorrelation along track at * lines", SNOW_LAGS, along),
    }


def layer_power_correlation(power, layer_bins):
    """Correlation from one to the next of a layer's power averaged over 11 range lines [dB], all layers pooled."""
    rows = np.rint(np.nan_to_num(layer_bins[1:])).astype(int)
    tracked = np.where(np.isfinite(layer_bins[1:]), np.take_along_axis(power, rows, axis=0), np.nan)
    n_means = tracked.shape[1] // LOOKED_LINES
    means = to_db(
        tracked[:, : n_means * LOOKED_LINES]
        .reshape(len(tracked), n_means, LOOKED_LINES)
        .mean(axis=2)
    )
    known = means[np.isfinite(means).mean(axis=1) > 0.5]
    return (
        correlation(known - np.nanmean(known, axis=1, keepdims=True), (1,), axis=1)[0]
        if known.size
        else np.nan
    )
