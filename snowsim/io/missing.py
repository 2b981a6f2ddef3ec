"""What the attributes of a stored variable declare as missing, in NetCDF and in Zarr."""

import math
import warnings
from dataclasses import dataclass

import numpy as np
import xarray as xr

from snowsim.io.files import refusal

FILLS = ("_FillValue", "missing_value")
# Attributes that hold limits: the least value, the largest, or both.
LIMITS = {"valid_range": ("least", "largest"), "valid_min": ("least",), "valid_max": ("largest",)}


def with_one_fill(path, name, stored):
    """Variable of a file with one fill value for all that is missing, for xarray to decode.

    Missing are values that equal `_FillValue` or one of `missing_value`, or lie outside
    `valid_range`, `valid_min` or `valid_max`. Warns if a range leaves nothing, and refuses one that
    holds no numbers. A variable whose attributes declare nothing is returned as it is.
    """
    declared = {key: stored.attrs[key] for key in (*FILLS, *LIMITS) if key in stored.attrs}
    if stored.dtype.kind not in "iuf" or not declared or _is_decoded(declared, stored.dtype):
        return stored
    values = np.array(stored.values)
    attrs = {key: value for key, value in stored.attrs.items() if key not in declared}
    numbers = _Numbers(values, attrs)
    missing = np.isnan(values) if values.dtype.kind == "f" else np.zeros(values.shape, dtype=bool)
    for key in declared.keys() & {*FILLS}:
        for number in _numbers_of(declared[key]):
            missing |= numbers.equal(number)
    outside = np.zeros(values.shape, dtype=bool)
    for key in declared.keys() & LIMITS.keys():
        limits = _numbers_of(declared[key])
        if len(limits) != len(LIMITS[key]) or numbers.in_disorder(limits):
            expected = "two numbers, the lesser first" if len(LIMITS[key]) == 2 else "one number"
            raise refusal(path, f"{name}: {key}", expected, declared[key])
        for end, limit in zip(LIMITS[key], limits, strict=True):
            outside |= numbers.beyond(limit, end)
    if not missing.all() and outside[~missing].all():
        limits = ", ".join(f"{key} {declared[key]}" for key in LIMITS if key in declared)
        msg = f"{path}: {name}: no value lies within its {limits}: all are taken as missing"
        warnings.warn(msg, UserWarning, stacklevel=2)
    missing |= outside
    if missing.any():
        # A number that is missing is so everywhere in the variable: it may stand for all others.
        fill = np.nan if values.dtype.kind == "f" else values[missing][0]
        values[missing] = fill
        attrs["_FillValue"] = values.dtype.type(fill)
    return xr.Variable(stored.dims, values, attrs, stored.encoding)


def _is_decoded(declared, dtype):
    """Whether xarray decodes all that is declared: a fill value of the type of the file."""
    return declared.keys() == {"_FillValue"} and np.asarray(declared["_FillValue"]).dtype == dtype


def _numbers_of(declared):
    """Numbers (number,) of an attribute; text that is no number gives none."""
    if isinstance(declared, str):
        try:
            return np.array([float(declared)])
        except ValueError:
            return np.empty(0)
    numbers = np.ravel(declared)
    return numbers if numbers.dtype.kind in "iuf" else np.empty(0)


@dataclass(frozen=True, eq=False)
class _Numbers:
    """Values as a file holds them, to compare with numbers that their attributes declare.

    A declared number is one of the file, unless its type shows that it is one after scaling: it is
    a float where the file holds whole numbers, or a longer float (NetCDF User's Guide, attribute
    conventions). A missing value to which no whole number of the file is scaled is one of the file.
    Numbers are compared in the type of the file, for arrays may fill half of the memory.
    """

    stored: np.ndarray
    attrs: dict

    @property
    def values(self):
        """Values of the file; bytes that are declared as unsigned are."""
        if str(self.attrs.get("_Unsigned", "")).lower() != "true":
            return self.stored
        return self.stored.view(self.stored.dtype.str.replace("i", "u"))

    @property
    def is_whole(self):
        return self.values.dtype.kind != "f"

    @property
    def scale(self):
        return float(np.ravel(self.attrs.get("scale_factor", 1))[0])

    def is_scaled(self, number):
        """Whether a declared number is one after scaling."""
        if self.attrs.keys().isdisjoint({"scale_factor", "add_offset"}):
            return False
        is_longer = self.is_whole or number.itemsize > self.values.itemsize
        return number.dtype.kind == "f" and is_longer

    def unscaled(self, number):
        """The number before scaling: of the type of the file, or for whole numbers any."""
        if self.is_scaled(number):
            number = (number - float(np.ravel(self.attrs.get("add_offset", 0))[0])) / self.scale
        dtype = self.values.dtype
        if not self.is_whole:
            return _as_type(number, dtype)
        if dtype.kind == "u" and number.dtype.kind == "i" and number.itemsize == dtype.itemsize:
            return int(number.astype(dtype))  # attributes have the sign that the file stores
        return int(number) if number.dtype.kind in "iu" else float(number)

    def in_disorder(self, limits):
        """Whether the least number is larger than the largest, or one of them is NaN."""
        return not self.unscaled(limits[0]) * self.sign(limits[0]) <= (
            self.unscaled(limits[-1]) * self.sign(limits[-1])
        )

    def sign(self, number):
        """-1 where scaling turns the order of numbers round and the number is scaled, else 1."""
        return -1 if self.is_scaled(number) and self.scale < 0 else 1

    def equal(self, number):
        """Where values equal a number, bool."""
        meant = self.unscaled(number)
        if not self.is_whole:
            same = self.values == _as_type(number, self.values.dtype)
            # Values that equal a declared number by chance are rare: both readings count.
            return same | (np.abs(self.values - meant) <= 1e-6 * abs(meant))
        limits = np.iinfo(self.values.dtype)
        is_near = np.isfinite(meant) and abs(meant - np.rint(meant)) < 1e-3 + 1e-6 * abs(meant)
        if self.is_scaled(number) and not (is_near and limits.min <= np.rint(meant) <= limits.max):
            meant = float(number)
            is_near = meant == np.rint(meant)
        return self.values == int(np.rint(meant)) if is_near else np.zeros(self.values.shape, bool)

    def beyond(self, limit, end):
        """Where values lie beyond a limit, bool; scaled whole numbers by more than half a step."""
        bound = self.unscaled(limit)
        is_least = (end == "least") == (self.sign(limit) == 1)
        if self.is_whole and np.isfinite(bound):
            margin = 0.5 if self.is_scaled(limit) else 0
            bound = math.ceil(bound - margin) if is_least else math.floor(bound + margin)
        return self.values < bound if is_least else self.values > bound


def _as_type(number, dtype):
    with np.errstate(over="ignore"):
        return np.asarray(number).astype(dtype)[()]
