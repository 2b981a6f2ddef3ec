"""Profiles of density against depth as text: pits, cores, penetrometers."""

import io
import re
from dataclasses import dataclass
from pathlib import Path
from unicodedata import normalize

import numpy as np
import pandas as pd

from snowsim.echogram import check_choice
from snowsim.io.files import content_of, library_errors, listed, refusal

FACTORS = {"m": 1.0, "cm": 0.01, "mm": 0.001, "kg m-3": 1.0, "g cm-3": 1000.0}
# Largest densities that fit one unit alone.
MOST_G_CM3 = 1.0
LEAST_KG_M3 = 60.0
# Words of columns' names.
DENSITY = r"\b(density|dens|rho|ρ)\b"
THICKNESS = r"\bthickness\b"
TOP = r"\b(top|upper|from|start)\b"
BOTTOM = r"\b(bottom|bot|base|lower|to|stop|end)\b"
MIDDLE = r"\b(mid|middle|midpoint|centre|center)\b"
DEPTH = rf"\bdepth\b|{TOP}|{BOTTOM}|{MIDDLE}"
NOT_MEANT = r"\b(err|error|std|stdev|sd|sigma|unc|uncertainty|flag|quality)\b"
# Of water, or of ice, equivalent: no depth in snow.
EQUIVALENT = r"water|equiv|h2o|\b(eqv?|[cm]?m?(s?w|i) ?e(qv?)?|kg ?m ?2)\b"
# A block of remarks in front of the header, as PANGAEA has it; a number that stands for none.
REMARKS = re.compile(r"\A\s*/\*.*?\*/\s*", re.DOTALL)
MISSING = -9999
# What a header says of a column, or an option in its place.
CHOICES = {
    "depth_unit": {"m": r"\bm\b", "cm": r"\bcm\b", "mm": r"\bmm\b"},
    "density_unit": {"kg m-3": "kg ?m ?3", "g cm-3": r"\bg ?c(m ?3|c)"},
    "depth_of": {"top": TOP, "bottom": BOTTOM, "middle": MIDDLE},
}
# A first depth up to this share of the first sample is of a middle.
MOST_OF_MIDDLE = 0.75


@dataclass(frozen=True)
class Profile:
    """Samples of one profile, (sample,); density is NaN where it is missing."""

    depth_m: np.ndarray  # of the middle
    density_kg_m3: np.ndarray
    note: str  # what was read, in one line
    thickness_m: np.ndarray | None = None  # None: samples reach half-way to their neighbours


def read_profile(
    path,
    *,
    depth_unit=None,
    density_unit=None,
    depth_column=None,
    density_column=None,
    depth_of=None,
):
    """The `Profile` of a table with a header, its fields divided by commas, semicolons or blanks.

    Columns are found by words of their names, such as ``depth_cm``, ``Density (kg/m³)``, ``rho``,
    ``top [m]``, ``bottom [m]``, ``thickness``, or named. Units stand there, or in a row below the
    header, or are given; density without a unit takes the one that its values fit. Depths are of
    the top, bottom or middle of samples, as the name or `depth_of` says; where neither does, of
    tops if the first is 0, of middles if it is about half the first sample, else they are refused.
    Rows may run from the bottom up, numbers have a decimal comma, -9999 is none; lines that begin
    with ``#`` and a block ``/* */`` above the header are remarks. Depth in water equivalent is
    refused.
    """
    table = _table(path)
    density = _column(path, table, "density", DENSITY, density_column)
    others = table.drop(columns=density)
    tops = _named(others, TOP)
    bottoms = _named(others, BOTTOM)
    of_both_ends = depth_column is None and len(tops) == len(bottoms) == 1
    if of_both_ends:
        depth, *beside = tops + bottoms
    else:
        beside = _named(others, THICKNESS)[:1]
        depth = _column(path, others.drop(columns=beside), "depth", DEPTH, depth_column)
    values, below = _numbers(path, table[[depth, density, *beside]])
    told = {name: f"{name} {below.get(name, '')}" for name in values}
    fitting = _fitting(values[density])
    density_unit = _choice(path, told[density], "density_unit", density_unit, fitting)
    density_kg_m3 = FACTORS[density_unit] * values[density].to_numpy()
    depth_unit = _choice(path, told[depth], "depth_unit", depth_unit)
    depth_m = FACTORS[depth_unit] * values[depth].to_numpy()
    thickness_m = None
    for name in beside:
        unit = _choice(path, told[name], "depth_unit", None, depth_unit)
        thickness_m = FACTORS[unit] * values[name].to_numpy()
    if of_both_ends:
        thickness_m = thickness_m - depth_m
    place = _choice(path, depth, "depth_of", depth_of, _likely_place(depth_m, thickness_m))
    middle_m, thickness_m = _middles(depth_m, thickness_m, place)
    n_missing = np.isnan(density_kg_m3).sum()
    note = (
        f"{path}: {depth_m.size} samples down to {depth_m[-1]:.4g} m, {n_missing} missing, "
        f"depths of the {place} of each, depth in {depth_unit}, density in {density_unit}"
    )
    return Profile(middle_m, density_kg_m3, note, thickness_m)


def _table(path):
    """Table of texts."""
    with library_errors(path, "table: expected text with a header and columns"):
        # Spreadsheets write a raised 3 as no UTF-8.
        text = content_of(Path(path)).decode("utf-8-sig", errors="replace")
        text = REMARKS.sub("", text, count=1)
        separator = "\t" if "\t" in text.partition("\n")[0] else None
        file = io.StringIO(text)
        table = pd.read_csv(file, sep=separator, engine="python", comment="#", dtype=str)
    if table.empty or not isinstance(table.index, pd.RangeIndex):
        found = "no row" if table.empty else "more: decimal commas?"
        raise refusal(path, "rows", "as many fields as the header has", found)
    return table


def _words(name):
    """Letters and digits of a name, in lower case, with a blank for anything else."""
    return re.sub("[^a-zρ0-9]+", " ", normalize("NFKC", str(name)).lower())


def _named(table, pattern):
    """Columns whose names have one of the words, and none that tells another quantity."""
    found = [name for name in table.columns if re.search(pattern, _words(name))]
    return [name for name in found if not re.search(f"{NOT_MEANT}|{EQUIVALENT}", _words(name))]


def _column(path, table, quantity, pattern, name):
    """The column of a name; without one, that of a quantity."""
    found = _named(table, pattern) if name is None else [name]
    if len(found) != 1 or found[0] not in table:
        expected = (
            f"one column with {quantity} in its name (but of water equivalent), "
            f"or --{quantity}-column"
        )
        raise refusal(path, name or quantity, expected, listed(table.columns))
    return found[0]


def _numbers(path, texts):
    """Columns as numbers from the top down, NaN where there are none; and units by column.

    Those stand where the first row has text alone. The first column has a number in every row.
    """
    numbers = texts.apply(lambda column: pd.to_numeric(column.str.replace(",", "."), "coerce"))
    bad = numbers.isna() & texts.notna()
    numbers = numbers.mask(numbers == MISSING)
    below = texts.iloc[0].to_dict() if bad.iloc[0].all() else {}
    bad.iloc[:, 0] = numbers.iloc[:, 0].isna()
    if below:
        texts, numbers, bad = (table.iloc[1:] for table in (texts, numbers, bad))
    rows, columns = np.nonzero(bad.to_numpy())
    if rows.size:
        found = f"{texts.iloc[rows[0], columns[0]]!r} in row {rows[0] + 1}"
        raise refusal(path, texts.columns[columns[0]], "numbers", found)
    falls = (numbers.iloc[:, 0].diff()[1:] < 0).all()
    return (numbers[::-1] if falls else numbers), below


def _choice(path, column, option, given, likely=None):
    """One of the choices as the header tells, an option says, or is likely, in this order.

    Refused where header and option differ, or none says it.
    """
    choices = CHOICES[option]
    column = column.strip()
    words = _words(column)
    if re.search(EQUIVALENT, words):
        raise refusal(path, column, "depth in snow", "water equivalent")
    told = [choice for choice, pattern in choices.items() if re.search(pattern, words)]
    if given is not None:
        check_choice(option, given, choices)
    option = option.replace("_", "-")
    in_header = told[-1] if told else None
    if None not in (given, in_header) and given != in_header:
        raise refusal(path, column, f"--{option} {in_header}, as the header says", given)
    chosen = in_header or given or likely
    if chosen is None:
        expected = f"{', '.join(choices)} in the header, or --{option}"
        raise refusal(path, column, expected, "none")
    return chosen


def _fitting(density):
    """The one unit that values of density can have, or None."""
    most = density.max()
    if most <= MOST_G_CM3:
        return "g cm-3"
    return "kg m-3" if most >= LEAST_KG_M3 else None


def _likely_place(depth_m, thickness_m):
    """Place in samples that depths are given for, as the first of them tells, or None."""
    first_m = depth_m[0]
    sample_m = np.diff(depth_m, append=np.inf)[0] if thickness_m is None else thickness_m[0]
    if first_m == 0:
        return "top"
    return "middle" if 0 < first_m <= MOST_OF_MIDDLE * sample_m else None


def _middles(depth_m, thickness_m, place):
    """Depth of the middle of every sample and its thickness [m]; None where neighbours tell it."""
    if place == "middle":
        return depth_m, thickness_m
    if thickness_m is None and place == "bottom":
        thickness_m = np.diff(depth_m, prepend=0)
    elif thickness_m is None:
        # The last one is as thick as the one above it; of one sample alone any thickness will do.
        step_m = np.diff(depth_m)
        thickness_m = np.append(step_m, step_m[-1] if step_m.size else 1)
    half_m = thickness_m / 2
    return depth_m + (half_m if place == "top" else -half_m), thickness_m
