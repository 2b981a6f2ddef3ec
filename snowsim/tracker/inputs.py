"""Canonical images: echograms in the form that the tracker was trained on.

Range bins have the tracker's size, range lines are averaged to its spacing, the surface lies in row
50, and decibels become 8 bits by the rule of the benchmark's scenes.
"""

from dataclasses import dataclass, fields

import numpy as np
import pandas as pd
import xarray as xr

from snowsim.alignment import (
    along_track_m,
    bin_size_s,
    contradictions,
    levelled,
    resample_range,
)
from snowsim.constants import BLOCK_LINES
from snowsim.echogram import (
    DB_BELOW_NOISE_FLOOR,
    SURFACE_ROW,
    as_recorded,
    check_echogram,
    to_grey,
)
from snowsim.limits import check_count, check_values
from snowsim.tracker.surface import SMOOTH_LINES, find_surface, select_surface, without_outliers

# A line whose maximum exceeds the median of maxima by more is saturated; the scale ignores it.
SATURATED_DB = 10.0
# Outside these limits, positions repeat or jump, and the spacing is unknown.
SPACINGS_M = (0.01, 1e4)
MOST_RESAMPLED = 32  # largest ratio of range bins, of an echogram and of the tracker
LEAST_LINES = 32  # range lines that must be left after averaging
AIR_ABOVE = 10  # range bins above the surface from which on there is only air
LEAST_AIR = 12  # range bins of air that are needed to estimate looks
LEAST_SHARE_EMPTY = 0.01  # of range lines without power; radars lose single lines
SINGLE_LOOK = 1.5  # an estimate below this means one look


@dataclass(frozen=True, eq=False)
class Grid:
    """Positions of the pixels of a canonical image in its echogram.

    The echogram's *own* range lines are those before averaging.

    Attributes
    ----------
    first_s, bin_s : float
        Two-way travel time of row 0 of an unshifted line, and height of a row [s].
    top : ndarray of int, (range_line,)
        Rows by which each own line is shifted up.
    surface_row : ndarray, (range_line,)
        Row of the surface on each own line.
    n_rows : int
    n_averaged : int
        Number of own lines averaged in one line of the image.
    """

    first_s: float
    bin_s: float
    top: np.ndarray
    surface_row: np.ndarray
    n_rows: int
    n_averaged: int

    @property
    def n_lines(self):
        """Range lines of the image."""
        return -(-self.top.size // self.n_averaged)

    def twtt(self, row):
        """Two-way travel time [s] of rows (..., range_line) on the echogram's own lines."""
        return self.first_s + (row + self.top) * self.bin_s

    def row(self, twtt):
        """Rows (range_bin, range_line) of travel times (range_bin,) [s] on the own lines."""
        return (twtt[:, None] - self.first_s) / self.bin_s - self.top

    @property
    def bottom(self):
        """Row after the last recorded one, on range lines of the image."""
        n_bins = self.n_rows + self.top.min()
        return self.averaged(n_bins - self.top)

    @property
    def line(self):
        """Fractional line of the image at each own line, (range_line,)."""
        within = (np.arange(self.top.size) + 0.5) / self.n_averaged - 0.5
        return np.clip(within, 0, self.n_lines - 1)

    def averaged(self, values):
        """Mean of values (range_line,) over the own lines of each line of the image."""
        return _mean_of_lines(values[None], self.n_averaged)[0]


@dataclass(frozen=True, eq=False)
class Canonical:
    """An echogram with its `Grid` and grey scale; `image` makes parts of the canonical image.

    `noise_floor_db` and `maximum_db` are those of `snowsim.echogram.to_uint8`. `surface_db` is the
    largest power of every own line. `notes` say what limits the layers of this echogram. `outside`
    is whether no pick may have quality 1, as of echograms outside the ranges of the tracker's card.
    `surface_found` is whether the surface is that of the rise of power and not of the file.
    """

    echogram: xr.Dataset
    grid: Grid
    noise_floor_db: float
    maximum_db: float
    surface_db: np.ndarray
    notes: tuple
    outside: bool
    surface_found: bool

    @property
    def recorded(self):
        """Lines of the image on which something was recorded, bool (range_line,)."""
        return self.grid.averaged(np.isfinite(self.surface_db)) > 0

    def grey(self, above_db):
        """Grey level of power `above_db` above the noise floor."""
        span_db = self.maximum_db - self.noise_floor_db + DB_BELOW_NOISE_FLOOR
        return (DB_BELOW_NOISE_FLOOR + above_db) * 255 / span_db

    def image(self, first, stop):
        """8-bit image (row, range_line) of range lines `first` to before `stop`.

        Pixels that were not recorded have the grey of the noise floor.
        """
        grid = self.grid
        own = slice(first * grid.n_averaged, stop * grid.n_averaged)
        power = _resampled(self.echogram, own, grid.bin_s)
        power_db = _level_db(power, grid.top[own], grid.n_rows, grid.n_averaged)
        np.copyto(power_db, np.float32(self.noise_floor_db), where=np.isnan(power_db))
        return to_grey(power_db, self.noise_floor_db, self.maximum_db)


def canonical(echogram, card, where="echogram"):
    """`Canonical` form of an echogram dataset for the tracker of a `Card`.

    The surface is that of the file where power rises near it, else the rise of power. The noise
    floor and the maximum are medians over blocks of 256 range lines. ValueError if nothing was
    recorded, or the echogram has no contrast.
    """
    _check(echogram, card, where)
    echogram = as_recorded(echogram.transpose("twtt", "slow_time", ...))
    first_s = float(echogram["twtt"].values[0])
    # Files have zero where the surface was not tracked.
    given_s = echogram["Surface"].where(echogram["Surface"] > 0).values.astype(float)
    given = (given_s - first_s) / card.bin_s
    survey, n_averaged, notes, outside = _survey_and_averaging(echogram, given, card)
    n_bins = int((echogram["twtt"].size - 1) * bin_size_s(echogram) / card.bin_s) + 1
    n_known = np.isfinite(survey.surface).sum()
    check_count(f"{where}: range lines with 30 range bins or more of measured power", n_known)
    # Echoes of a radar with coarser bins are as much wider.
    coarseness = max(1.0, bin_size_s(echogram) / card.bin_s) if outside else 1.0
    surface, reason = select_surface(given, survey.surface, survey.rise_share, n_bins, coarseness)
    noise_floor_db = float(np.nanmedian(survey.noise_floor_db))
    maximum_db = float(np.nanmedian(survey.maximum_db))
    check_values(f"{where}: contrast [dB]", maximum_db - noise_floor_db, 1e-3)
    top = _shifts(surface)
    grid = Grid(first_s, card.bin_s, top, surface - top, int(n_bins - top.min()), n_averaged)
    surface_db = survey.largest_db
    notes = (*contradictions(echogram, where), *notes, reason, _note_of_gaps(surface_db))
    notes = tuple(note for note in notes if note is not None)
    return Canonical(
        echogram,
        grid,
        noise_floor_db,
        maximum_db,
        surface_db,
        notes,
        outside,
        surface_found=reason is not None,
    )


def _note_of_gaps(largest_db):
    """Note on range lines without power, as an unfinished copy of a file has; None for few."""
    n_empty = int((~np.isfinite(largest_db)).sum())
    if n_empty <= LEAST_SHARE_EMPTY * largest_db.size:
        return None
    return f"{n_empty} of {largest_db.size} range lines hold no power"


def _check(echogram, card, where):
    """Refuse a dataset that is no echogram, is empty, or has far larger or smaller range bins."""
    if not isinstance(echogram, xr.Dataset) or 0 in echogram.sizes.values():
        wanted = "expected an echogram dataset, as snowsim.io.read_echogram reads it from a file"
        got = dict(getattr(echogram, "sizes", {})) or type(echogram).__name__
        msg = f"{where}: {wanted}, got {got}"
        raise ValueError(msg)
    check_echogram(echogram, where)
    shortest_s = card.bin_s / MOST_RESAMPLED
    longest_s = card.bin_s * MOST_RESAMPLED
    check_values(f"{where}: twtt: range bins", bin_size_s(echogram), shortest_s, longest_s)


@dataclass(frozen=True, eq=False)
class _Survey:
    """Surface [range bins] and largest power by own line; scale and looks by block of lines."""

    surface: np.ndarray
    rise_share: np.ndarray
    largest_db: np.ndarray
    noise_floor_db: np.ndarray | tuple = (np.nan,)
    maximum_db: np.ndarray | tuple = (np.nan,)
    n_looks: np.ndarray | tuple = (np.nan,)


def _survey_and_averaging(echogram, given, card):
    """`_Survey`, number of own lines to average, notes, and whether the card excludes these."""
    spacing_m = _line_spacing_m(echogram)
    n_averaged = max(1, round(card.line_spacing_m / spacing_m)) if spacing_m else 1
    survey = _survey(echogram, given, card.bin_s, n_averaged)
    looks = pd.Series(survey.n_looks).median()
    needed = _lines_for_looks(looks, n_averaged, spacing_m, given.size, card)
    notes = [] if spacing_m else [_why_no_spacing(echogram)]
    if looks < SINGLE_LOOK:
        notes.append("single look: the tracker was trained on averages of several")
    if needed != n_averaged:
        notes.append(f"{needed} range lines are averaged for as many looks as the tracker knows")
        survey = _survey(echogram, given, card.bin_s, needed)
    known = {"bin_s": bin_size_s(echogram), "n_looks": looks * needed}
    known |= {"line_spacing_m": spacing_m * needed} if spacing_m else {}
    outside = [f"{line}: no pick has quality 1" for line in card.outside(known)]
    return survey, needed, notes + outside, bool(outside)


def _survey(echogram, given, bin_s, n_averaged):
    """`_Survey` of an echogram, made block by block to save memory."""
    n_lines = BLOCK_LINES * n_averaged
    stretches = [slice(first, first + n_lines) for first in range(0, given.size, n_lines)]
    blocks = [_survey_of_block(echogram, lines, given, bin_s, n_averaged) for lines in stretches]
    names = [each.name for each in fields(_Survey)]
    return _Survey(*(np.concatenate([getattr(block, name) for block in blocks]) for name in names))


def _survey_of_block(echogram, own_lines, given, bin_s, n_averaged):
    """`_Survey` of one block, which has its own scale."""
    power = _resampled(echogram, own_lines, bin_s)
    power_db = _in_db(power)
    surface, share = find_surface(power_db, given[own_lines])
    largest_db = np.nanmax(power_db, axis=0, initial=-np.inf)
    if not np.isfinite(surface).any():
        return _Survey(surface, share, largest_db)
    top = _shifts(np.where(np.isfinite(surface), surface, np.nanmedian(surface)))
    n_rows = int(len(power) - top.min())
    # Decibels are those that are known already, unless power is averaged.
    is_known = n_averaged == 1
    level_db = (
        levelled(power_db, top, n_rows) if is_known else _level_db(power, top, n_rows, n_averaged)
    )
    present = np.isfinite(level_db)
    lines = present.any(axis=0)
    if not lines.all():
        level_db = level_db[:, lines]
        present = present[:, lines]
    filled = 2 * np.count_nonzero(present, axis=1) > present.shape[1]
    if not filled.any():
        return _Survey(surface, share, largest_db)
    noise_floor_db = np.nanmean(level_db[filled], axis=1, dtype=float).min()
    maxima = np.nanmax(level_db, axis=0, initial=-np.inf)
    maximum_db = maxima[maxima <= np.median(maxima) + SATURATED_DB].max()
    own = echogram["Data"].values[:, own_lines]
    n_looks = _looks_in_air(own, surface * (bin_s / bin_size_s(echogram)))
    return _Survey(surface, share, largest_db, [noise_floor_db], [maximum_db], [n_looks])


def _shifts(surface):
    """Rows by which lines are shifted up, int, so that their smoothed surface lies in row 50."""
    padded = np.pad(without_outliers(surface), SMOOTH_LINES // 2, mode="edge")
    smooth = np.convolve(padded, np.full(SMOOTH_LINES, 1 / SMOOTH_LINES), "valid")
    return np.floor(smooth + 0.5).astype(int) - SURFACE_ROW


def _resampled(echogram, lines, bin_s):
    """Power (range_bin, range_line) of some own lines in range bins of the tracker's size."""
    part = echogram[["Data"]].isel(slow_time=lines)
    return resample_range(part, bin_s)["Data"].values


def _in_db(power):
    """Decibels of linear power, float32, NaN where it is not positive."""
    power = np.asarray(power, dtype=np.float32)
    with np.errstate(divide="ignore", invalid="ignore"):
        power_db = np.log10(power)
    power_db *= 10
    np.copyto(power_db, np.float32(np.nan), where=np.isneginf(power_db))  # of zero
    return power_db


def _level_db(power, top, n_rows, n_averaged):
    """Decibels (row, range_line) of lines shifted by `top` and averaged, NaN where not recorded."""
    level = levelled(power.astype(np.float32, copy=False), top, n_rows)
    if n_averaged > 1:
        level = _mean_of_lines(level, n_averaged)
    return _in_db(level)


def _mean_of_lines(values, n_averaged):
    """Mean of known values over every `n_averaged` lines; the last mean may have fewer."""
    firsts = np.arange(0, values.shape[1], n_averaged)
    present = np.isfinite(values)
    sums = np.add.reduceat(np.where(present, values, 0), firsts, axis=1)
    counts = np.add.reduceat(present.astype(np.int32), firsts, axis=1)
    return np.where(counts > 0, sums / np.maximum(counts, 1), np.nan)


def _line_spacing_m(echogram):
    """Median distance between range lines [m], 0 if it is unknown."""
    spacing_m = pd.Series(np.diff(along_track_m(echogram))).median()
    return float(spacing_m) if SPACINGS_M[0] < spacing_m < SPACINGS_M[1] else 0.0


def _why_no_spacing(echogram):
    """Note on an echogram whose line spacing is unknown."""
    known = np.isfinite(along_track_m(echogram)).any()
    reason = "positions repeat or jump" if known else "no positions"
    return f"{reason}: range lines are used as they are"


def _lines_for_looks(n_looks, n_averaged, spacing_m, n_lines, card):
    """Own lines to average for the number of looks that the card asks for.

    It is `n_averaged` where more would leave too few lines, or lines too far apart for the card.
    """
    least, _ = card.ranges.get("n_looks", (0, 0))
    if not n_looks * n_averaged < least:
        return n_averaged
    needed = int(np.ceil(least / n_looks))
    _, farthest_m = card.ranges.get("line_spacing_m", (0, np.inf))
    fits = needed * LEAST_LINES <= n_lines and needed * spacing_m <= farthest_m
    return needed if fits else n_averaged


def _looks_in_air(power, surface):
    """Equivalent number of looks of the noise above the surface, NaN if there is too little of it.

    For M looks, the difference of the logarithms of the noise of two lines has the variance
    2 trigamma(M), about ``2 / M + 1 / M^2``. A difference of level between lines cancels.
    """
    n_rows = max(int(np.ceil(np.nanmax(surface, initial=0) - AIR_ABOVE)), 0)
    power = power[:n_rows]
    air = (np.arange(len(power))[:, None] < surface - AIR_ABOVE) & (power > 0)
    logs = np.log(np.where(air, power, 1))
    both = air[:, 1:] & air[:, :-1]
    ratio = np.where(both, logs[:, 1:] - logs[:, :-1], 0)
    count = both.sum(axis=0)
    enough = count >= LEAST_AIR
    if enough.sum() < LEAST_LINES // 2:
        return np.nan
    ratio, both, count = ratio[:, enough], both[:, enough], count[enough]
    away = np.where(both, ratio - ratio.sum(axis=0) / count, 0)
    variance = np.median((away * away).sum(axis=0) / (count - 1))
    return 1 / (np.sqrt(1 + variance) - 1) if variance > 0 else np.nan
