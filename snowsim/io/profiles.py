"""Profiles of density against depth as text: pits, cores, penetrometers."""

import re
from dataclasses import dataclass

import numpy as np
import pandas as pd

from snowsim.io.guard import existing, library_errors, listed, refusal

# As their letters and digits are in a column's name or an option.
UNITS = {
    "depth": {"m": 1.0, "cm": 0.01, "mm": 0.001},
    "density": {"kgm3": 1.0, "gcm3": 1000.0},
}
NAMES = {"depth": "m, cm or mm", "density": "kg m-3 or g cm-3"}
MOST_G_CM3 = 5.0  # no snow is as light in kg m-3


@dataclass(frozen=True)
class Profile:
    """Samples of one profile, (sample,); density is NaN where it is missing."""

    depth_m: np.ndarray
    density_kg_m3: np.ndarray
    note: str  # what was read, in one line


def read_profile(path, *, depth_unit=None, density_unit=None):
    """The `Profile` of a table with a header, its fields divided by commas, semicolons or blanks.

    One column's name has `depth` in it, of the middle of each sample, and one has `density`; what
    follows that is the unit, as in ``depth_cm`` or ``Density (kg/m^3)``, if none is given. Density
    without a unit takes the one that its values fit. Lines that begin with # are remarks.
    """
    path = existing(path)
    with library_errors(path, "table", "text with a header and columns"):
        table = pd.read_csv(path, sep=None, engine="python", comment="#", encoding="utf-8-sig")
    columns = {quantity: _column(path, quantity, table) for quantity in UNITS}
    values = {quantity: _numbers(path, table[name]) for quantity, name in columns.items()}
    if depth_unit is None:
        depth_unit = _unit(path, "depth", columns["depth"])
    if density_unit is None:
        density_unit = _unit(path, "density", columns["density"], values["density"])
    missing = np.isnan(values["depth"])
    if missing.any():
        found = f"none in row {np.flatnonzero(missing)[0] + 1}"
        raise refusal(path, columns["depth"], "a depth in every row", found)
    n_missing = np.isnan(values["density"]).sum()
    depth_m = values["depth"] * UNITS["depth"][_letters(depth_unit)]
    note = f"{path}: {depth_m.size} samples down to {depth_m[-1]:.4g} m, {n_missing} missing, "
    note += f"depth in {depth_unit}, density in {density_unit}"
    factor = UNITS["density"][_letters(density_unit)]
    return Profile(depth_m, values["density"] * factor, note)


def _column(path, quantity, table):
    """Name of the one column of a quantity."""
    names = [str(name) for name in table.columns]
    found = [name for name in names if quantity in name.lower()]
    if len(found) != 1 or table.empty:
        has = f"{len(table)} rows of {listed(names)}"
        raise refusal(path, quantity, f"rows and one column with {quantity} in its name", has)
    return found[0]


def _numbers(path, column):
    """Values of a column, NaN where there are none."""
    numbers = pd.to_numeric(column, errors="coerce")
    bad = numbers.isna() & column.notna()
    if bad.any():
        row = np.flatnonzero(bad)[0]
        raise refusal(path, column.name, "numbers", f"{column.iloc[row]!r} in row {row + 1}")
    return numbers.to_numpy(dtype=float)


def _unit(path, quantity, name, values=None):
    """Unit in a column's name; where there is none, told from values if they are given."""
    _, _, after = name.lower().partition(quantity)
    letters = _letters(after)
    for unit in re.split(", | or ", NAMES[quantity]):
        if _letters(unit) == letters:
            return unit
    if letters or values is None:
        expected = f"the unit in the column's name, {NAMES[quantity]}, or --{quantity}-unit"
        raise refusal(path, quantity, expected, name)
    light = not np.nanmax(values, initial=-np.inf) >= MOST_G_CM3
    return "g cm-3" if light else "kg m-3"


def _letters(unit):
    return re.sub("[^a-z0-9]", "", unit.lower())
