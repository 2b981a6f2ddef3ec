"""Layers of a frame, as Open Polar Radar has them, from pieces of canonical rows."""

import numpy as np
import xarray as xr

from snowsim.echogram import check_layers, crossing_layers
from snowsim.frames import FLAGGED_BY, flagged_lines
from snowsim.picking.confidence import half_width_rows

GOOD, MODERATE, BAD = 1, 2, 3
AUTOMATIC = 2
# Confidence from which a pick is good, and moderate.
QUALITY = (0.8, 0.5)
# A line whose largest power lies so far below that of the frame's middle line was flown in a roll,
# or recorded nothing.
FADE_DB = 6.0
LEAST_ROWS = 0.5  # below the surface
ALONG = ("layer", "slow_time")
ALONG_TRACK = ("Latitude", "Longitude", "Elevation")


def layers_of(canonical, pieces, first_line, longest):
    """Layers dataset of the frame whose image begins at range line `first_line` of the pieces.

    `pieces` are pairs of a `Piece` and how sure its picks are, the surface first; those with a pick
    in this frame have a row, called by their number. Gaps within a chain, up to `longest` lines,
    are filled straight, longer ones stay NaN.
    """
    grid = canonical.grid
    lines = first_line + np.arange(grid.n_lines)
    numbers = []
    rows = []
    sure = []
    for number, (piece, of_piece) in enumerate(pieces):
        first, stop = np.searchsorted(piece.line, [lines[0], lines[-1] + 1])
        if number > 0 and first == stop:
            continue
        row, of_pick = on_lines(piece, of_piece, lines, longest)
        numbers.append(number)
        rows.append(between_lines(row, grid.line))
        sure.append(between_lines(of_pick, grid.line))
    rows = np.array(rows)
    sure = np.array(sure)
    # A chain straight across a gap may touch a surface that jumps, or another chain.
    rows[1:][rows[1:] <= rows[:1] + LEAST_ROWS] = np.nan
    rows[crossing_layers(rows)] = np.nan
    layers = _dataset(_variables(canonical, rows, sure), numbers, canonical.echogram)
    check_layers(layers, "picks")
    return layers


def _variables(canonical, rows, sure):
    """Variables of picks at canonical rows, and of how sure they are, (layer, range_line)."""
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
    return variables


def _dataset(variables, numbers, echogram):
    """Variables with the positions, times and attributes of their echogram."""
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


def on_lines(piece, of_pick, lines, longest):
    """Rows of a piece and how sure they are, on range lines of the image, NaN where it has none."""
    after = np.minimum(np.searchsorted(piece.line, lines).clip(1), piece.line.size - 1)
    gap = piece.line[after] - piece.line[after - 1]
    within = (lines >= piece.line[0]) & (lines <= piece.line[-1]) & (gap <= longest)
    known = within | np.isin(lines, piece.line)
    return tuple(
        np.where(known, np.interp(lines, piece.line, values), np.nan)
        for values in (piece.row, of_pick)
    )


def between_lines(values, place):
    """Values at places between range lines, NaN where one of the two has none."""
    left = np.floor(place).astype(int)
    right = np.minimum(left + 1, values.size - 1)
    share = place - left
    between = (1 - share) * values[left] + share * values[right]
    return np.where(share == 0, values[left], between)
