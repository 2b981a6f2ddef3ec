"""Layers picked at one place in two years: which of one year are found in the other.

A year's snow lies on top of the layers of the earlier pass, so they are shifted down before they
are compared. Layers are rows (layer, column), NaN without a pick, the surface not among them.

*The shift* is the same for all layers, so that it follows none of them, and a parabola along track.
All shifts on a grid are tried: their mean from 0 to two median spacings of the layers, tilt and
bend each up to a third of one. The best has the least mean square distance from the picks of the
earlier year to the nearest ones of the later, where distances over a third of a spacing count as
that: what has no counterpart has no say.

*A layer is found* where a single layer of the other year lies within a third of the median spacing
on at least half of its columns.

*The control* moves the layers of the earlier year down together by a random number of rows, farther
than any shift that is tried; what leaves the picture comes in at its top. Spacing and order stay,
and folds grow with depth as they do in the pictures. The same is measured then, its best shift and
all: a share of layers found is the largest over many shifts, and chance is given as many.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd
import xarray as xr

from snowsim.echogram import SURFACE_ROW

TOLERANCE_SPACINGS = 1 / 3
MOST_SPACINGS = 2.0  # of the mean shift
MEANS_PER_TOLERANCE = 6
N_TILTS = 7  # tried, and as many bends
TABLE_PER_TOLERANCE = 12  # distances are looked up at so many rows of a tolerance
FOUND_SHARE = 0.5  # of a layer's columns
N_LINES = 256  # as a scene that the tracker was trained on
FIRST_TIME = np.datetime64("2000-01-01", "ns")
INTERVAL = (2.5, 97.5)


@dataclass(frozen=True, eq=False)
class Found:
    """Layers of one year in the other: which are found, and how far picks lie from the nearest."""

    layers: np.ndarray
    distance_rows: float

    @property
    def share(self):
        """Of the layers, NaN without any."""
        return self.layers.mean() if self.layers.size else np.nan


@dataclass(frozen=True, eq=False)
class Comparison:
    """Two years after the best shift of the earlier (column,) [rows]; the earlier without it."""

    shift: np.ndarray
    earlier: Found
    later: Found
    unshifted: Found


def as_echogram(means_db, bin_s):
    """An echogram dataset of 100 m means (row, column) [dB], a row taken for a bin of `bin_s`.

    Air is put above the surface, which is row 0. Decibels are interpolated between columns to as
    many range lines as a scene has: the tracker asks for evidence on tens of them.
    """
    n_columns = means_db.shape[1]
    place = np.linspace(0, n_columns - 1, N_LINES)
    left = np.minimum(place.astype(int), n_columns - 2)
    share = place - left
    power_db = (1 - share) * means_db[:, left] + share * means_db[:, left + 1]
    air = np.full((SURFACE_ROW, N_LINES), np.nan)
    power = 10 ** (np.vstack([air, power_db]) / 10)
    unknown = ("slow_time", np.full(N_LINES, np.nan))
    content = dict.fromkeys(("Latitude", "Longitude", "Elevation"), unknown)
    content["Surface"] = ("slow_time", np.full(N_LINES, SURFACE_ROW * bin_s))
    content["Data"] = (("twtt", "slow_time"), power.astype(np.float32))
    coordinates = {
        "twtt": ("twtt", bin_s * np.arange(len(power)), {"units": "s"}),
        "slow_time": FIRST_TIME + np.arange(N_LINES) * np.timedelta64(1, "ms"),
    }
    return xr.Dataset(content, coordinates)


def picked_rows(layers, bin_s, n_columns):
    """Rows (layer, column) below the surface of layers picked in `as_echogram`."""
    rows = layers["twtt"].values[1:] / bin_s - SURFACE_ROW
    lines = np.rint(np.linspace(0, N_LINES - 1, n_columns)).astype(int)
    at_columns = rows[:, lines]
    return at_columns[np.isfinite(at_columns).any(axis=1)]


def median_spacing(*years):
    """Median distance of a pick to the next below it on its column, all years together [rows]."""
    steps = [np.diff(np.sort(rows, axis=0), axis=0).ravel() for rows in years]
    steps = np.concatenate(steps)
    steps = steps[np.isfinite(steps)]
    return np.median(steps) if steps.size else np.nan


def tried_shifts(spacing, n_columns):
    """Shifts of the grid (candidate, column) [rows]."""
    tolerance = TOLERANCE_SPACINGS * spacing
    n_means = round(MOST_SPACINGS / TOLERANCE_SPACINGS * MEANS_PER_TOLERANCE) + 1
    mean = np.linspace(0, MOST_SPACINGS * spacing, n_means)
    bent = np.linspace(-tolerance, tolerance, N_TILTS)
    grid = np.meshgrid(mean, bent, bent, indexing="ij")
    coefficients = np.stack(grid, axis=-1).reshape(-1, len(grid))
    along = np.linspace(-1, 1, n_columns)
    return coefficients @ np.polynomial.legendre.legvander(along, len(grid) - 1).T


def nearest(rows, others):
    """Distance (layer, column) to the nearest of other picks on a column, infinite without one."""
    distance = np.full(rows.shape, np.inf)
    for other in others:
        distance = np.fmin(distance, np.abs(rows - other))
    return distance


def best_shift(earlier, later, spacing):
    """The shift (column,) [rows] that brings the layers of the earlier year to the later one's.

    No shift at all where either year has no layers.
    """
    n_columns = earlier.shape[1]
    if 0 in (earlier.size, later.size):
        return np.zeros(n_columns)
    tolerance = TOLERANCE_SPACINGS * spacing
    step = tolerance / TABLE_PER_TOLERANCE
    shifts = tried_shifts(spacing, n_columns)
    lowest = np.nanmin(earlier) + shifts.min()
    n_steps = int((np.nanmax(earlier) + shifts.max() - lowest) / step) + 2
    places = lowest + step * np.arange(n_steps)
    table = nearest(np.tile(places[:, None], n_columns), later)
    cost = np.minimum(table, tolerance) ** 2
    layer, column = np.nonzero(np.isfinite(earlier))
    rows = earlier[layer, column] + shifts[:, column]
    at = np.rint((rows - lowest) / step).astype(int)
    return shifts[cost[at, column].mean(axis=1).argmin()]


def found_in(rows, others, spacing):
    """`Found`: layers of one year, already shifted, in the layers of the other."""
    near = np.abs(rows[:, None] - others) <= TOLERANCE_SPACINGS * spacing
    n_near = near.sum(axis=2).max(axis=1, initial=0)
    n_picks = np.isfinite(rows).sum(axis=1)
    distance = nearest(rows, others)[np.isfinite(rows)]
    median = np.median(distance) if distance.size else np.nan
    return Found(n_near >= FOUND_SHARE * n_picks, float(median))


def compare(earlier, later, spacing):
    """`Comparison` of the layers of two years, the earlier one's brought to the later's."""
    shift = best_shift(earlier, later, spacing)
    moved = earlier + shift
    of_earlier = found_in(moved, later, spacing)
    of_later = found_in(later, moved, spacing)
    return Comparison(shift, of_earlier, of_later, found_in(earlier, later, spacing))


def fold(*years):
    """How far layers lie off their mean row at each column (column,), as a share of that row."""
    rows = np.concatenate(years)
    level = np.nanmean(rows, axis=1, keepdims=True)
    known = np.isfinite(rows)
    weight = (level**2 * known).sum(axis=0)
    off = np.where(known, level * (rows - level), 0).sum(axis=0)
    return off / np.maximum(weight, np.finfo(float).tiny)


def moved_around(rows, by, depth, folds):
    """Layers moved down together by some rows, from below `depth` to the top, and folded there."""
    level = np.nanmean(rows, axis=1, keepdims=True)
    away = (level + by) % depth - level
    return rows + away * (1 + folds)


def control(earlier, later, spacing, n_draws, *, rng):
    """Comparisons after random shifts of the earlier year, a list of `n_draws`.

    Empty where a year has no layers, or the picture is no deeper than the shifts that are tried.
    """
    if 0 in (earlier.size, later.size):
        return []
    depth = max(np.nanmean(rows, axis=1).max() for rows in (earlier, later))
    margin = MOST_SPACINGS * spacing
    if not depth > 2 * margin:
        return []
    folds = fold(earlier, later)
    moves = rng.uniform(margin, depth - margin, n_draws)
    moved = [moved_around(earlier, by, depth, folds) for by in moves]
    return [compare(rows, later, spacing) for rows in moved]


def repeat_table(comparison, controls, spacing):
    """A row for each of the years: its layers found in the other, beside the control.

    Distances of picks to the nearest of the other year are medians, of the control the median of
    these; `unshifted_distance_rows` is that of the earlier year before the shift.
    """
    rows = []
    for year in ("earlier", "later"):
        found = getattr(comparison, year)
        of_control = [getattr(each, year) for each in controls]
        shares = np.array([each.share for each in of_control])
        distances = [each.distance_rows for each in of_control]
        low, high = np.percentile(shares, INTERVAL) if controls else (np.nan, np.nan)
        row = {
            "layers_of": year,
            "n_layers": found.layers.size,
            "n_found": int(found.layers.sum()),
            "share": found.share,
            "control": shares.mean() if controls else np.nan,
            "control_low": low,
            "control_high": high,
            "draws_as_high": int((shares >= found.share).sum()),
            "n_draws": len(controls),
            "distance_rows": found.distance_rows,
            "control_distance_rows": np.median(distances) if controls else np.nan,
            "unshifted_distance_rows": comparison.unshifted.distance_rows,
            "mean_shift_rows": comparison.shift.mean(),
            "spacing_rows": spacing,
        }
        rows.append(row)
    return pd.DataFrame(rows)


def picks_dataset(pictures, years, comparison):
    """Pictures (picture, row_of_picture, column) by name, the rows of their layers, those found.

    `years`: layers (layer, column) of the pictures in their order, the earlier first.
    """
    found = (comparison.earlier.layers, comparison.later.layers)
    n_layers = max(map(len, years))
    n_columns = comparison.shift.size
    rows = np.full((len(years), n_layers, n_columns), np.nan)
    in_both = np.zeros((len(years), n_layers), dtype=np.uint8)
    for year, (of_year, found_of_year) in enumerate(zip(years, found, strict=True)):
        rows[year, : len(of_year)] = of_year
        in_both[year, : len(of_year)] = found_of_year
    power_db = np.stack(list(pictures.values()))
    return xr.Dataset(
        {
            "power_db": (("picture", "row_of_picture", "column"), power_db, {"units": "dB"}),
            "row": (("picture", "layer", "column"), rows, {"units": "1"}),
            "found": (("picture", "layer"), in_both, {"units": "1"}),
            "shift": ("column", comparison.shift, {"units": "1"}),
        },
        {"picture": list(pictures)},
    )
