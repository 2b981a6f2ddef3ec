"""Profiles of density against depth as CSV: snow pits, cores, penetrometers."""

import io
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from snowsim.io.files import content_of, library_errors, listed, refusal

# Each name of a column with the factor that brings its values to metres or to kg m-3.
DEPTHS = {"depth_m": 1.0, "depth_cm": 0.01}
EXTENTS = {("top_m", "bottom_m"): 1.0, ("top_cm", "bottom_cm"): 0.01}
DENSITIES = {"density_kg_m3": 1.0, "density_g_cm3": 1000.0}
HEADER = (
    "a header, divided by commas, with depth_m or depth_cm (the middle of each sample), or top_m "
    "and bottom_m, or top_cm and bottom_cm; and with density_kg_m3 or density_g_cm3"
)


@dataclass(frozen=True)
class Profile:
    """Samples of one profile from the top down, three (sample,)."""

    depth_m: np.ndarray  # of the middle of each sample
    density_kg_m3: np.ndarray
    note: str  # one line on what was read
    thickness_m: np.ndarray | None = None  # None: samples reach half-way to their neighbours


def read_profile(path):
    """Read a `Profile` from a CSV with commas and decimal points.

    Its header names the quantities and their units: ``depth_m`` or ``depth_cm``, the middle of each
    sample, or ``top_m`` and ``bottom_m``, or ``top_cm`` and ``bottom_cm``; and ``density_kg_m3`` or
    ``density_g_cm3``. Other columns are ignored, and what follows a ``#`` is a comment. Rows
    without a depth or a density are left out; the note counts them. ValueError, in one line, for
    any other header, for text in place of a number, or if no row has both.
    """
    table = _texts(path)
    names = set(table.columns)
    middles = [name for name in DEPTHS if name in names]
    extents = [both for both in EXTENTS if names.issuperset(both)]
    densities = [name for name in DENSITIES if name in names]
    # pandas numbers the second column of a name.
    twice = [name for name in (*DEPTHS, *sum(EXTENTS, ()), *DENSITIES) if f"{name}.1" in names]
    if len(middles) + len(extents) != 1 or len(densities) != 1 or twice:
        raise refusal(path, "header", HEADER, listed(table.columns))
    [density] = densities
    depths = list(*extents) or middles
    values = _numbers(path, table[[*depths, density]])
    measured = values.dropna()
    if measured.empty:
        raise refusal(path, "rows", "some with a depth and a density", "none")
    density_kg_m3 = DENSITIES[density] * measured[density].to_numpy()
    thickness_m = None
    if extents:
        top_m, base_m = EXTENTS[extents[0]] * measured[depths].to_numpy().T
        depth_m = (top_m + base_m) / 2
        thickness_m = base_m - top_m
    else:
        depth_m = DEPTHS[depths[0]] * measured[depths[0]].to_numpy()
    note = f"{path}: {depth_m.size} samples from {depth_m[0]:.4g} to {depth_m[-1]:.4g} m"
    n_left_out = len(values) - len(measured)
    if n_left_out:
        note += f"; rows without a number, left out: {n_left_out}"
    return Profile(depth_m, density_kg_m3, note, thickness_m)


def _texts(path):
    """Table of the texts of a CSV, named by its header."""
    with library_errors(path, "table: expected text with a header and columns"):
        # Names of places in other columns may be in any encoding.
        text = content_of(Path(path)).decode("utf-8-sig", errors="replace")
        table = pd.read_csv(io.StringIO(text), comment="#", dtype=str, skipinitialspace=True)
    if not isinstance(table.index, pd.RangeIndex):
        raise refusal(path, "rows", "as many fields as the header has", "more: decimal commas?")
    return table.rename(columns=str.strip)


def _numbers(path, texts):
    """Columns as numbers, NaN where a field is empty; ValueError names the first other text."""
    numbers = texts.apply(lambda column: pd.to_numeric(column, "coerce"))
    rows, columns = np.nonzero((numbers.isna() & texts.notna()).to_numpy())
    if rows.size:
        found = f"{texts.iloc[rows[0], columns[0]]!r} in row {rows[0] + 1}"
        raise refusal(path, texts.columns[columns[0]], "numbers", found)
    return numbers
