"""An echogram as the tracker was trained to see it, and the way back.

Range bins of the tracker's size, lines averaged to its spacing, the surface in row 50, decibels as
8 bits by the rule of the benchmark's scenes.
"""

from dataclasses import dataclass, fields

import numpy as np
import pandas as pd
import xarray as xr

from snowsim.alignment import along_track_m, bin_size_s, levelled, resample_range
from snowsim.constants import BLOCK_LINES
from snowsim.echogram import DB_BELOW_NOISE_FLOOR, SURFACE_ROW, check_echogram, to_db, to_grey
from snowsim.limits import check_count, check_values
from snowsim.tracker.surface import SMOOTH_LINES, chosen_surface, find_surface, without_outliers

# A line whose maximum exceeds that of the middle line by so much is saturated: it has no say in the
# scale.
SATURATED_DB = 10.0
# Positions repeat or jump where the spacing is no distance.
SPACINGS_M = (0.01, 1e4)
MOST_RESAMPLED = 32  # a range bin so many times another is no echogram of snow
LEAST_LINES = 32  # that tell how lines are averaged
# Rows above the surface that are air alone, how many of them tell looks, and what one look is.
AIR_ABOVE = 10
LEAST_AIR = 12
SINGLE_LOOK = 1.5


@dataclass(frozen=True, eq=False)
class Grid:
    """Where pixels of a canonical image lie in the echogram.

    Attributes
    ----------
    first_s, bin_s : float
        Two-way travel time of row 0 of a line that is not shifted, and of a row [s].
    top : ndarray of int, (range_line,)
        Rows by which each of the echogram's own lines is shifted.
    surface_row : ndarray, (range_line,)
        Row of the surface on these lines.
    n_rows : int
    n_averaged : int
        Own lines in one of the image.
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
        """Rows (range_bin, range_line) of travel times (range_bin,) [s] on own lines."""
        return (twtt[:, None] - self.first_s) / self.bin_s - self.top

    @property
    def bottom(self):
        """Row after the last one recorded, on range lines of the image."""
        n_bins = self.n_rows + self.top.min()
        return self.averaged(n_bins - self.top)

    @property
    def line(self):
        """Place of the own lines among those of the image, (range_line,)."""
        within = (np.arange(self.top.size) + 0.5) / self.n_averaged - 0.5
        return np.clip(within, 0, self.n_lines - 1)

    def averaged(self, values):
        """Mean over the own lines (range_line,) in each line of the image."""
        return _mean_of_lines(values[None], self.n_averaged)[0]


@dataclass(frozen=True, eq=False)
class Canonical:
    """An echogram with its `Grid` and scale; images are made when asked for, by range lines.

    `noise_floor_db` and `maximum_db` are those of `snowsim.echogram.to_uint8`, `surface_db` is the
    largest power of every own line, `notes` what a reader of the result should know, `outside`
    whether the echogram is none that the tracker was made for.
    """

    echogram: xr.Dataset
    grid: Grid
    noise_floor_db: float
    maximum_db: float
    surface_db: np.ndarray
    notes: tuple
    outside: bool

    @property
    def recorded(self):
        """Whether anything was, bool by range line of the image."""
        return self.grid.averaged(np.isfinite(self.surface_db)) > 0

    def grey(self, above_db):
        """Grey of power so far above the noise floor."""
        span_db = self.maximum_db - self.noise_floor_db + DB_BELOW_NOISE_FLOOR
        return (DB_BELOW_NOISE_FLOOR + above_db) * 255 / span_db

    def image(self, first, stop):
        """8-bit image (row, range_line) of range lines `first` to before `stop`.

        What was not recorded has the grey of the noise floor.
        """
        grid = self.grid
        own = slice(first * grid.n_averaged, stop * grid.n_averaged)
        power = _resampled(self.echogram, own, grid.bin_s)
        power_db = _level_db(power, grid.top[own], grid.n_rows, grid.n_averaged)
        power_db = np.nan_to_num(power_db, nan=self.noise_floor_db)
        return to_grey(power_db, self.noise_floor_db, self.maximum_db)


def canonical(echogram, card, where="echogram"):
    """`Canonical` of an echogram dataset for the tracker of a `Card`.

    The file's surface counts where it lies near the rise of power, else that rise. Scale: medians,
    over blocks of 256 range lines, of what the benchmark's rule makes of each. ValueError if
    nothing was recorded, or the echogram has no contrast.
    """
    _check(echogram, card, where)
    echogram = echogram.transpose("twtt", "slow_time", ...)
    first_s = float(echogram["twtt"].values[0])
    # Zero, where nobody tracked it, is NaN.
    given_s = echogram["Surface"].where(echogram["Surface"] > 0).values.astype(float)
    given = (given_s - first_s) / card.bin_s
    survey, n_averaged, notes, outside = _surveyed(echogram, given, card)
    n_bins = int((echogram["twtt"].size - 1) * bin_size_s(echogram) / card.bin_s) + 1
    n_known = np.isfinite(survey.surface).sum()
    check_count(f"{where}: range lines with 30 range bins or more of measured power", n_known)
    surface, reason = chosen_surface(given, survey.surface, survey.rise_share, n_bins)
    noise_floor_db = float(np.nanmedian(survey.noise_floor_db))
    maximum_db = float(np.nanmedian(survey.maximum_db))
    check_values(f"{where}: contrast [dB]", maximum_db - noise_floor_db, 1e-3)
    top = _tops(surface)
    grid = Grid(first_s, card.bin_s, top, surface - top, int(n_bins - top.min()), n_averaged)
    notes = tuple(note for note in (*notes, reason) if note is not None)
    surface_db = survey.largest_db
    return Canonical(echogram, grid, noise_floor_db, maximum_db, surface_db, notes, outside)


def _check(echogram, card, where):
    """Refuse what is no echogram, has no samples, or bins of another order of magnitude."""
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
    """What range lines tell of surface [range bins], (range_line,), and of scale, (block,)."""

    surface: np.ndarray
    rise_share: np.ndarray
    largest_db: np.ndarray
    noise_floor_db: np.ndarray | tuple = (np.nan,)
    maximum_db: np.ndarray | tuple = (np.nan,)
    n_looks: np.ndarray | tuple = (np.nan,)


def _surveyed(echogram, given, card):
    """`_Survey`, how many own lines are averaged, notes, and whether the card knows such."""
    spacing_m = _line_spacing_m(echogram)
    n_averaged = max(1, round(card.line_spacing_m / spacing_m)) if spacing_m else 1
    survey = _survey(echogram, given, card.bin_s, n_averaged)
    looks = pd.Series(survey.n_looks).median()
    needed = _lines_for_looks(looks, n_averaged, spacing_m, given.size, card)
    notes = [] if spacing_m else ["no positions: range lines are used as they are"]
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
    """`_Survey` of an echogram, block by block."""
    n_lines = BLOCK_LINES * n_averaged
    stretches = [slice(first, first + n_lines) for first in range(0, given.size, n_lines)]
    blocks = [_of_block(echogram, lines, given, bin_s, n_averaged) for lines in stretches]
    names = [each.name for each in fields(_Survey)]
    return _Survey(*(np.concatenate([getattr(block, name) for block in blocks]) for name in names))


def _of_block(echogram, lines, given, bin_s, n_averaged):
    """`_Survey` of some range lines."""
    power = _resampled(echogram, lines, bin_s)
    power_db = _in_db(power)
    surface, share = find_surface(power_db, given[lines])
    largest_db = np.nanmax(power_db, axis=0, initial=-np.inf)
    if not np.isfinite(surface).any():
        return _Survey(surface, share, largest_db)
    top = _tops(np.where(np.isfinite(surface), surface, np.nanmedian(surface)))
    level_db = _level_db(power, top, int(len(power) - top.min()), n_averaged)
    level_db = level_db[:, np.isfinite(level_db).any(axis=0)]
    filled = np.isfinite(level_db).mean(axis=1) > 0.5
    if not filled.any():
        return _Survey(surface, share, largest_db)
    noise_floor_db = np.nanmean(level_db[filled], axis=1, dtype=float).min()
    maxima = np.nanmax(level_db, axis=0, initial=-np.inf)
    maximum_db = maxima[maxima <= np.median(maxima) + SATURATED_DB].max()
    own = echogram["Data"].values[:, lines]
    n_looks = _looks_in_air(own, surface * (bin_s / bin_size_s(echogram)))
    return _Survey(surface, share, largest_db, [noise_floor_db], [maximum_db], [n_looks])


def _tops(surface):
    """Whole rows by which lines are shifted: a smooth surface comes to row 50."""
    padded = np.pad(without_outliers(surface), SMOOTH_LINES // 2, mode="edge")
    smooth = np.convolve(padded, np.full(SMOOTH_LINES, 1 / SMOOTH_LINES), "valid")
    return np.floor(smooth + 0.5).astype(int) - SURFACE_ROW


def _resampled(echogram, lines, bin_s):
    """Power (range_bin, range_line) of some own lines, in bins of the tracker's size."""
    part = echogram[["Data"]].isel(slow_time=lines)
    return resample_range(part, bin_s)["Data"].values


def _in_db(power):
    power = np.asarray(power, dtype=np.float32)
    return np.where(power > 0, to_db(np.where(power > 0, power, 1)), np.nan)


def _level_db(power, top, n_rows, n_averaged):
    """Decibels (row, range_line) of lines shifted by `top` and averaged, NaN where not recorded."""
    level = levelled(power.astype(np.float32, copy=False), top, n_rows)
    if n_averaged > 1:
        level = _mean_of_lines(level, n_averaged)
    return _in_db(level)


def _mean_of_lines(values, n_averaged):
    """Mean over as many lines of what is known; the last may have fewer."""
    firsts = np.arange(0, values.shape[1], n_averaged)
    present = np.isfinite(values)
    sums = np.add.reduceat(np.where(present, values, 0), firsts, axis=1)
    counts = np.add.reduceat(present.astype(np.int32), firsts, axis=1)
    return np.where(counts > 0, sums / np.maximum(counts, 1), np.nan)


def _line_spacing_m(echogram):
    """Median distance of range lines [m], 0 where positions are missing or tell none."""
    spacing_m = pd.Series(np.diff(along_track_m(echogram))).median()
    return float(spacing_m) if SPACINGS_M[0] < spacing_m < SPACINGS_M[1] else 0.0


def _lines_for_looks(n_looks, n_averaged, spacing_m, n_lines, card):
    """Own lines to average so that a line has the looks that the card asks for, if that may be.

    Lines must not become too few, nor farther apart than the card allows.
    """
    least, _ = card.ranges.get("n_looks", (0, 0))
    if not n_looks * n_averaged < least:
        return n_averaged
    needed = int(np.ceil(least / n_looks))
    _, farthest_m = card.ranges.get("line_spacing_m", (0, np.inf))
    fits = needed * LEAST_LINES <= n_lines and needed * spacing_m <= farthest_m
    return needed if fits else n_averaged


def _looks_in_air(power, surface):
    """Equivalent number of looks of the noise above the surface, NaN where that is not known.

    The difference of the logarithms of two lines' noise has the variance 2 trigamma(M), about
    ``2 / M + 1 / M^2``; what a line is brighter all along does not count.
    """
    air = (np.arange(len(power))[:, None] < surface - AIR_ABOVE) & (power > 0)
    logs = np.ma.log(np.ma.array(power, mask=~air))
    ratio = logs[:, 1:] - logs[:, :-1]
    variance = ratio.var(axis=0, ddof=1)[ratio.count(axis=0) >= LEAST_AIR]
    if variance.size < LEAST_LINES // 2:
        return np.nan
    variance = np.median(variance.filled(0))
    return 1 / (np.sqrt(1 + variance) - 1) if variance > 0 else np.nan
