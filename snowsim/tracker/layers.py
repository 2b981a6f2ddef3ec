"""Layers datasets of frames, in Open Polar Radar's form, and the confidence of their picks.

Confidence is the probability that a layer lies within 2 rows of a pick: a logistic function of the
mean log-odds of the chain near the pick and in a wider neighbourhood. Its coefficients were fitted
on flights whose scores are not reported; a card may have its own.
"""

import numpy as np
import xarray as xr
from scipy.special import expit

from snowsim.alignment import FLAGGED_BY, flagged_lines
from snowsim.echogram import check_layers, crossing_layers
from snowsim.tracker.linking import LINKING

GOOD, MODERATE, BAD = 1, 2, 3
AUTOMATIC = 2
# Least confidence of a good pick, and of a moderate one.
QUALITY_LIMITS = (0.8, 0.5)
# Pieces with a lower mean confidence are left out, which raises F on tuning flights.
LEAST_CONFIDENCE = 0.4
# A line is faded, by a roll for instance, if its largest power is this far below the median of the
# frame.
FADE_DB = 6.0
CLOSE = 1.5  # times `LINKING.apart_rows`, at which years are merged in simulated firn
LEAST_ROWS = 0.5  # from the surface to a layer
LAYER_AXES = ("layer", "slow_time")
POSITIONS = ("Latitude", "Longitude", "Elevation")
NEAR_LINES = 8  # range lines to either side of a pick
FAR_LINES = 48
LARGEST = 3.0  # log-odds of a pick are clipped to this
# Nine of ten picks of this confidence that have a layer lie within this many rows of it.
SURE = (0.45, 0.55, 0.65, 0.75, 0.85, 0.95)
HALF_WIDTH_ROWS = (3.1, 2.8, 2.0, 1.5, 1.1, 0.9)


def features(piece, n_lines):
    """Mean log-odds of a piece within `NEAR_LINES` and `FAR_LINES` of every pick, (2, pick).

    Lines without a candidate, and lines beyond the ends of the piece but within all `n_lines` range
    lines, count as zero.
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


def confident_pieces(pieces, n_lines, coefficients):
    """Pairs (piece, confidence of its picks) whose mean is at least `LEAST_CONFIDENCE`."""
    pairs = [(piece, confidence(piece, n_lines, coefficients)) for piece in pieces]
    return [(piece, sure) for piece, sure in pairs if sure.mean() >= LEAST_CONFIDENCE]


def half_width_rows(sure):
    """Rows to either side of a pick within which nine of ten layers lie, if there is a layer."""
    return np.interp(sure, SURE, HALF_WIDTH_ROWS)


def layers_of_frame(canonical, pieces, first_line):
    """Layers dataset of the frame whose image begins at range line `first_line` of the pieces.

    `pieces` are pairs (piece, confidence of its picks), the surface first, then downwards. The
    dataset has those with a pick in this frame; `layer` is their number among all pieces.
    """
    grid = canonical.grid
    lines = first_line + np.arange(grid.n_lines)
    place = grid.line
    numbers = []
    rows = []
    sure_of_rows = []
    for number, (piece, sure) in enumerate(pieces):
        first, stop = np.searchsorted(piece.line, [lines[0], lines[-1] + 1])
        if number > 0 and first == stop:
            continue
        numbers.append(number)
        rows.append(between_lines(on_lines(piece, piece.row, lines), place))
        sure_of_rows.append(between_lines(on_lines(piece, sure, lines), place))
    rows = np.array(rows)
    # A chain is interpolated over gaps, where it may touch a surface that jumps or another chain.
    rows[1:][rows[1:] <= rows[:1] + LEAST_ROWS] = np.nan
    rows[crossing_layers(rows)] = np.nan
    layers = _dataset(canonical, numbers, rows, np.array(sure_of_rows))
    check_layers(layers, "picks")
    return layers


def _dataset(canonical, numbers, rows, sure):
    """Layers dataset of picks at canonical rows with confidence `sure`, both (layer, range_line).

    Positions, times and attributes are those of the echogram.
    """
    half = half_width_rows(sure) * canonical.grid.bin_s
    twtt = canonical.grid.twtt(rows)
    quality = np.where(
        sure >= QUALITY_LIMITS[0], GOOD, np.where(sure >= QUALITY_LIMITS[1], MODERATE, BAD)
    )
    if canonical.outside:
        quality = np.maximum(quality, MODERATE)
    quality = np.where(close_layers(rows), np.maximum(quality, MODERATE), quality)
    quality[:, doubtful_lines(canonical)] = BAD
    picked = np.isfinite(twtt)
    flags = {"quality": np.where(picked, quality, GOOD), "type": np.full(twtt.shape, AUTOMATIC)}
    seconds = {"twtt": twtt, "twtt_low": twtt - half, "twtt_high": twtt + half}
    variables = {name: (LAYER_AXES, values, {"units": "s"}) for name, values in seconds.items()}
    variables["twtt"][-1]["place"] = "peak"  # of an echo, as `snowsim.io.read_layers` has it
    variables |= {name: (LAYER_AXES, values.astype(np.uint8)) for name, values in flags.items()}
    meaning = "probability that a layer lies within 2 range bins of the tracker"
    variables["confidence"] = (LAYER_AXES, sure, {"units": "1", "long_name": meaning})
    echogram = canonical.echogram
    for name in POSITIONS:
        variables[name] = ("slow_time", echogram[name].values, echogram[name].attrs)
    coordinates = {"layer": numbers, "slow_time": echogram["slow_time"].values}
    kept = ("season_name", "radar_name", "day_seg")
    attributes = {name: echogram.attrs[name] for name in kept if name in echogram.attrs}
    attributes["apart_s"] = LINKING.apart_rows * canonical.grid.bin_s
    return xr.Dataset(variables, coordinates, attributes)


def close_layers(rows):
    """Mask of layers (layer, range_line) that the tracker can barely separate from a neighbour.

    Between the two, further layers may be merged into them.
    """
    # Rows increase downwards: the nearest layer above is the deepest above, likewise below.
    gap = np.full((2, *rows.shape), np.nan)
    gap[0, :-1] = np.fmin.accumulate(rows[:0:-1], axis=0)[::-1] - rows[:-1]
    gap[1, 1:] = rows[1:] - np.fmax.accumulate(rows[:-1], axis=0)
    return np.fmin(*gap) < CLOSE * LINKING.apart_rows


def doubtful_lines(canonical):
    """Own range lines that are flagged or faded, bool (range_line,)."""
    surface_db = canonical.surface_db
    doubtful = surface_db < np.median(surface_db) - FADE_DB
    held = flagged_lines(canonical.echogram) or {}
    for name in FLAGGED_BY:
        doubtful = doubtful | held.get(name, False)
    if "flagged" in canonical.echogram:
        doubtful = doubtful | canonical.echogram["flagged"].values
    return doubtful


def on_lines(piece, values, lines):
    """Values of the picks of a piece on range lines of the image, NaN where it has no pick.

    Gaps of up to `LINKING.longest_lines` are filled linearly.
    """
    after = np.minimum(np.searchsorted(piece.line, lines).clip(1), piece.line.size - 1)
    gap = piece.line[after] - piece.line[after - 1]
    within = (lines >= piece.line[0]) & (lines <= piece.line[-1]) & (gap <= LINKING.longest_lines)
    has_pick = (piece.line[after] == lines) | (piece.line[after - 1] == lines)
    known = within | has_pick
    return np.where(known, np.interp(lines, piece.line, values), np.nan)


def between_lines(values, place):
    """Values interpolated at fractional range lines, NaN where a neighbour is NaN."""
    if np.array_equal(place, np.arange(values.size)):
        return values
    left = np.floor(place).astype(int)
    right = np.minimum(left + 1, values.size - 1)
    share = place - left
    between = (1 - share) * values[left] + share * values[right]
    return np.where(share == 0, values[left], between)
