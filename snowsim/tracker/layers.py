"""Layers of a frame, as Open Polar Radar has them, from pieces, and how sure they are.

The probability that a layer lies within 2 rows of a pick is a logistic function of the mean
log-odds of its chain near it and farther around. The coefficients are those of flights that no
score is reported of, and a card may bring its own.
"""

import numpy as np
import xarray as xr
from scipy.special import expit

from snowsim.alignment import FLAGGED_BY, flagged_lines
from snowsim.echogram import check_layers, crossing_layers
from snowsim.tracker.linking import LINKING

GOOD, MODERATE, BAD = 1, 2, 3
AUTOMATIC = 2
# Confidence from which a pick is good, and moderate.
QUALITY = (0.8, 0.5)
# Mean confidence of a piece, below which leaving it out raises F on tuning flights.
LEAST_CONFIDENCE = 0.4
# A line whose largest power lies so far below that of the frame's middle line was flown in a roll,
# or recorded nothing.
FADE_DB = 6.0
LEAST_ROWS = 0.5  # below the surface
ALONG = ("layer", "slow_time")
ALONG_TRACK = ("Latitude", "Longitude", "Elevation")
NEAR_LINES = 8
FAR_LINES = 48
LARGEST = 3.0  # log-odds that count on a line
# Confidence, and the rows that hold nine tenths of the errors of such picks where there is a layer.
SURE = (0.45, 0.55, 0.65, 0.75, 0.85, 0.95)
HALF_WIDTH_ROWS = (3.1, 2.8, 2.0, 1.5, 1.1, 0.9)


def features(piece, n_lines):
    """Mean log-odds of a piece within `NEAR_LINES` and `FAR_LINES` of every pick, (2, pick).

    Of all `n_lines` range lines, those without a candidate and those beyond the ends of the piece
    count as none for and none against.
    """
    first = piece.line[0]
    size = piece.line[-1] - first + 1
    excess = np.zeros(size + 1)
    excess[piece.line - first + 1] = np.clip(piece.excess, -LARGEST, LARGEST)
    total = np.cumsum(excess)
    means = []
    for reach in (NEAR_LINES, FAR_LINES):
        start = np.maximum(piece.line - reach, 0)
        stop = np.minimum(piece.line + reach + 1, n_lines)
        within = np.clip(np.array([start, stop]) - first, 0, size)
        means.append((total[within[1]] - total[within[0]]) / (stop - start))
    return np.array(means)


def confidence(piece, n_lines, coefficients):
    """Probability that a layer lies within 2 rows of each pick of a piece, (pick,)."""
    offset, near, far = coefficients
    of_near, of_far = features(piece, n_lines)
    return expit(offset + near * of_near + far * of_far)


def likely(pieces, n_lines, coefficients):
    """Pieces of `LEAST_CONFIDENCE` or more in the mean, each with how sure its picks are, pairs."""
    pairs = [(piece, confidence(piece, n_lines, coefficients)) for piece in pieces]
    return [(piece, sure) for piece, sure in pairs if sure.mean() >= LEAST_CONFIDENCE]


def half_width_rows(sure):
    """Rows to either side of a pick that hold nine of ten layers, where there is one."""
    return np.interp(sure, SURE, HALF_WIDTH_ROWS)


def layers_of_frame(canonical, pieces, first_line):
    """Layers dataset of the frame whose image begins at range line `first_line` of the pieces.

    `pieces` are the surface and all others, downwards, each with how sure its picks are. Those with
    a pick in this frame have a row, called by their number.
    """
    grid = canonical.grid
    lines = first_line + np.arange(grid.n_lines)
    numbers = []
    rows = []
    sure_of_rows = []
    for number, (piece, sure) in enumerate(pieces):
        first, stop = np.searchsorted(piece.line, [lines[0], lines[-1] + 1])
        if number > 0 and first == stop:
            continue
        numbers.append(number)
        rows.append(between_lines(on_lines(piece, piece.row, lines), grid.line))
        sure_of_rows.append(between_lines(on_lines(piece, sure, lines), grid.line))
    rows = np.array(rows)
    # A chain straight across a gap may touch a surface that jumps, or another chain.
    rows[1:][rows[1:] <= rows[:1] + LEAST_ROWS] = np.nan
    rows[crossing_layers(rows)] = np.nan
    layers = _dataset(canonical, numbers, rows, np.array(sure_of_rows))
    check_layers(layers, "picks")
    return layers


def _dataset(canonical, numbers, rows, sure):
    """Picks at canonical rows, and how sure they are, (layer, range_line), as layers by number.

    Positions, times and attributes are those of their echogram.
    """
    half = half_width_rows(sure) * canonical.grid.bin_s
    twtt = canonical.grid.twtt(rows)
    quality = np.where(sure >= QUALITY[0], GOOD, np.where(sure >= QUALITY[1], MODERATE, BAD))
    if canonical.outside:
        quality = np.maximum(quality, MODERATE)
    quality[:, doubtful_lines(canonical)] = BAD
    picked = np.isfinite(twtt)
    flags = {"quality": np.where(picked, quality, GOOD), "type": np.full(twtt.shape, AUTOMATIC)}
    seconds = {"twtt": twtt, "twtt_low": twtt - half, "twtt_high": twtt + half}
    variables = {name: (ALONG, values, {"units": "s"}) for name, values in seconds.items()}
    variables |= {name: (ALONG, values.astype(np.uint8)) for name, values in flags.items()}
    meaning = "probability that a layer lies within 2 range bins of the tracker"
    variables["confidence"] = (ALONG, sure, {"units": "1", "long_name": meaning})
    echogram = canonical.echogram
    for name in ALONG_TRACK:
        variables[name] = ("slow_time", echogram[name].values, echogram[name].attrs)
    coordinates = {"layer": numbers, "slow_time": echogram["slow_time"].values}
    kept = ("season_name", "radar_name", "day_seg")
    attributes = {name: echogram.attrs[name] for name in kept if name in echogram.attrs}
    return xr.Dataset(variables, coordinates, attributes)


def doubtful_lines(canonical):
    """Own range lines that are flagged, or on which all power fades, bool (range_line,)."""
    surface_db = canonical.surface_db
    doubtful = surface_db < np.median(surface_db) - FADE_DB
    held = flagged_lines(canonical.echogram) or {}
    for name in FLAGGED_BY:
        doubtful = doubtful | held.get(name, False)
    if "flagged" in canonical.echogram:
        doubtful = doubtful | canonical.echogram["flagged"].values
    return doubtful


def on_lines(piece, values, lines):
    """Values of the picks of a piece on range lines of the image, NaN where it has none.

    Lines that its chain skips, `LINKING.longest_lines` at most, are filled straight.
    """
    after = np.minimum(np.searchsorted(piece.line, lines).clip(1), piece.line.size - 1)
    gap = piece.line[after] - piece.line[after - 1]
    within = (lines >= piece.line[0]) & (lines <= piece.line[-1]) & (gap <= LINKING.longest_lines)
    known = within | np.isin(lines, piece.line)
    return np.where(known, np.interp(lines, piece.line, values), np.nan)


def between_lines(values, place):
    """Values at places between range lines, NaN where one of the two has none."""
    left = np.floor(place).astype(int)
    right = np.minimum(left + 1, values.size - 1)
    share = place - left
    between = (1 - share) * values[left] + share * values[right]
    return np.where(share == 0, values[left], between)
