"""Depth, age and accumulation of the snow between picked layers."""

import warnings
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
import xarray as xr

from snowsim.alignment import order_from_surface, with_fixes
from snowsim.constants import KOVACS_M3_KG, WATER_DENSITY_KG_M3
from snowsim.echogram import (
    INVENTED_TIME,
    SURFACE_NAME,
    check_layers,
    crossing_layers,
    is_surface,
)
from snowsim.limits import check_values
from snowsim.snowpack.column import DensityProfile, column_of, temperature_k_of
from snowsim.snowpack.dating import HALF_SEPARATED
from snowsim.snowpack.horizons import NINE_IN_TEN_SD, date_layers, typical_mass_of_layers

YEAR_DAYS = 366
# Density at the surface if none is given. With it, the density of Herron & Langway's firn below 1 m
# is within 3 % of the medians of 391 Greenland cores from above 2500 m.
SURFACE_DENSITY_KG_M3 = 340.0
# Months from the end of a snow year, August in the north and February in the south, to December.
NORTH_MONTHS, SOUTH_MONTHS = 4, 10
# First guess of the mean accumulation [m w.e. / yr], on which firn denser than 550 kg m-3 depends.
FIRST_GUESS_M = 0.3
N_FIRN_ROUNDS = 2  # rounds of that firn and the mean accumulation; assumed, not measured
USUAL_CONFIDENCE = 0.9  # confidence of picks that come without one, as a person's do
AUTOMATIC = 2  # `type` of picks that no person set
BAD = 3  # `quality` of picks
MOST_NAMED = 5  # layers that a warning names
BOTTOM_NAME = "bottom"  # of the ice, in files of CReSIS
LEAST_DOUBT = 0.05  # least probability that no layer lies at a pick
EXPECTED_LIMITS_M = (0.001, 10)  # limits of an expected accumulation, those of `Climate`
LONG_YEARS = 12  # a warning is given if two picks lie more years apart
# Relative error of the typical mass from which on knowing it helps: half a year in three.
VAGUE_MASS_ERROR = 0.15
# Unit and meaning of every variable.
UNIT_AND_MEANING = {
    "year": ("1", "year of the autumn horizon; its snow lies below it"),
    "depth_m": ("m", "depth of the horizon"),
    "thickness_m": ("m", "thickness of the snow of the year"),
    "accumulation_m_we": ("m", "accumulation of the year in metres of water"),
    "low": ("m", "lower limit of accumulation, nine of ten lie between both"),
    "high": ("m", "upper limit of accumulation"),
    "error_picks": ("m", "part of the limits of accumulation that is of picks"),
    "error_density": ("m", "part of the limits of accumulation that is of density"),
    "n_years": ("1", "years between the picks that bound the year"),
    "year_confidence": ("1", "probability that the year of the horizon is right"),
    "age_low": ("1", "lower limit of years before the last autumn, nine of ten lie between both"),
    "age_high": ("1", "upper limit of years before the last autumn"),
    "flag": ("1", "1 where the horizon at either end of the year is right with less than 0.8"),
    "below_s": ("s", "two-way travel time below the surface"),
    "depth_at": ("m", "depth at two-way travel times below the surface"),
    "open_m_we": ("m", "mass above the horizon of the last autumn in metres of water"),
    "layer": ("1", "name of a layer that is used"),
    "layer_depth_m": ("m", "depth of a layer"),
    "layer_m_we": ("m", "mass above a layer in metres of water"),
    "layer_year": ("1", "year of the autumn horizon that a layer is, missing if it is none"),
}
N_TIMES = 500  # number of travel times at which depth is tabulated
# Standard deviation of the density of a year's snow about the profile; 18 to 39 in cores.
DENSITY_SD_KG_M3 = 30.0
LEAST_SURE = 0.8  # least confidence of a date without a flag


def accumulation(
    layers: xr.Dataset,
    density: float | DensityProfile | None = None,
    *,
    year: int | Mapping[str, int] | None = None,
    annual: bool | None = None,
    expected_m: float | None = None,
    expected_error: float = 0.3,
    temperature_k: float | None = None,
    density_error: float = 0.05,
    least_confidence: float = 0.5,
) -> xr.Dataset:
    """Accumulation of every year between picked layers, along the track.

    Parameters
    ----------
    layers : xarray.Dataset
        Layers as `snowsim track` writes them, or as `snowsim.io.open_segment` joins them. `twtt`
        (layer, slow_time) [s] is that of the surface and of layers below it, in any order, and a
        name stays with the same horizon along the track. `twtt_low`, `twtt_high` and `confidence`
        [0, 1] are used if present.
    density : float or snowsim.io.profiles.Profile, optional
        Density of the snow [kg m-3], 50 to 917, or a profile of density; picks below the end of
        the profile are not used. By default density grows from 340 by Herron & Langway (1980),
        under the mean accumulation found here.
    year : int or mapping of str to int, optional
        Year of the first layer below the surface that is used, or years of layers by name:
        ``{"snow_3": 2008}``. The snow of a year lies below the horizon of that year. By default the
        newest horizon is that of the last autumn before the first range line, and years above the
        first layer are counted, too. From September on (in the south, March) the last autumn is
        that of the same year. Where times are invented, as of images, the year of the first layer
        must be given.
    annual : bool, optional
        Whether every layer is one autumn horizon, and none is missing; else years are counted. By
        default layers are annual if they have no `confidence`, and either not every pick is
        automatic by its `type`, as where a person picked, or they are the interfaces of `simulate`.
    expected_m, expected_error : float, optional
        Accumulation known for the place [m w.e. / yr], and its relative standard deviation.
    temperature_k : float, optional
        Annual mean temperature of the firn; by default, in Greenland, that of Fausto et al. (2009).
        If given, `density` is that at the surface, below 550, and grows with depth.
    density_error : float
        Relative standard deviation of the density.
    least_confidence : float
        Picks of lower confidence are not used.

    Returns
    -------
    xarray.Dataset
        Variables on (year, slow_time) are NaN where picks do not bound a year:

        - `depth_m` of the year's horizon and `thickness_m` of its snow;
        - `accumulation_m_we` [m w.e. / yr], and its limits `low` and `high`, which hold it in nine
          of ten cases and include the doubt in the number of years; `error_picks` and
          `error_density` are parts of these limits;
        - `year_confidence`, the probability that the horizon's year is the one stated; it rises
          downwards only towards a named layer;
        - `age_low` and `age_high`, limits of the horizon's age in years before the last autumn,
          which hold it in nine of ten cases;
        - `n_years`, the number of years between the two picks that bound the year: thickness and
          accumulation are means over these years;
        - `flag`: 1 where `year_confidence` is below .8, else 0.

        If a typical year may be so thin that the tracker misses half of the horizons, less than 2.5
        times what it separates, nothing is dated: the result has no year, and a warning says so.

        `open_m_we` (slow_time) is the mass above the horizon of the last autumn. `layer_depth_m`
        and `layer_m_we` (layer, slow_time) are the depth of every layer that is used, and the mass
        above it; `layer_year` (layer) is its year, NaN if it is no horizon. `depth_at` (below_s) is
        the depth [m] at travel times below the surface.

        Attributes are `uppermost`, the newest dated horizon and its year, ``snow_2=2011``;
        `last_autumn`, the year of age 0; `annual`, 1 if every layer was taken for a year, else 0;
        `surety`, a line on how many dates are sure; `typical_m`,
        the mass of a typical year; `no_horizon`, the names of layers that are probably crusts;
        `n_below_profile`, the number of picks below the end of a profile; and
        `surface_density_kg_m3` and `temperature_k` of firn.

    Raises
    ------
    ValueError
        If layers are no dataset, the surface is missing, layers cross, a confidence or a density is
        out of range, no range line has two horizons within the profile, no layer has a given name,
        years contradict one another, or times are invented and the first layer has no year.

    Notes
    -----
    The travel time to depth z below the mass w [m w.e.] is ``t = (2 / c) (z + 0.845 w)`` (Kovacs,
    Gow & Morey 1995). Ages follow from the masses between layers, by `snowsim.snowpack.dating`. A
    layer has one age along the whole track. The stated ages increase downwards, and their expected
    number of right ones is largest. Layers that no range line shares may have the same age.

    Four errors add in squares: that of both picks, each half of ``twtt_high - twtt_low``; that of
    density; the scatter of a year about the mean of m years, ``s (1 - 1 / m)^(1/2)``; and the doubt
    in the number of years, which is the spread of mean accumulation over all sequences of horizons.
    A relative error e of density counts as ``e / n`` with the refractive index n. The whole profile
    has the relative error `density_error`, and the snow of each year one of 30 kg m-3, as in cores.

    Picks lie 1.2 to 1.7 range bins below their interface. This cancels in a year's mass, but not in
    `open_m_we`.
    """
    layers = _checked(layers)
    picks = _picks(layers, least_confidence, year)
    check_values("density_error", density_error, 0, 1)
    check_values("expected_error", expected_error, 0, above=True, number=True)
    if expected_m is not None:
        check_values("expected_m", expected_m, *EXPECTED_LIMITS_M, number=True)
    annual = _every_one_a_year(layers) if annual is None else annual
    firn = {}
    if density is None or temperature_k is not None:
        density = SURFACE_DENSITY_KG_M3 if density is None else density
        temperature_k = temperature_k_of(layers) if temperature_k is None else temperature_k
        firn = {"surface_density_kg_m3": density, "temperature_k": temperature_k}
    mean_m = FIRST_GUESS_M if expected_m is None else expected_m
    for rounds_left in reversed(range(N_FIRN_ROUNDS if firn else 1)):
        column = column_of(density, temperature_k, mean_m)
        used = picks.down_to(column)
        expected = (expected_m, expected_error)
        water_m = column.at(column.water_m, used.below_s)
        separable_m = column.at(column.water_m, used.below_s + used.separable_s) - water_m
        known = (water_m, used, year, annual, expected, np.nanmedian(separable_m[1:]))
        if rounds_left:
            mean_m = typical_mass_of_layers(*known)
    dated = date_layers(*known)
    _warn(used, dated, annual)
    n_below = int((picks.below_s > column.twtt_s[-1]).sum())
    return _yearly(layers, used, column, dated, density_error).assign_attrs(
        n_below_profile=n_below, annual=int(annual), **firn
    )


def _checked(layers):
    """Layers from the surface down, without fixes that are none; ValueError if they are refused."""
    if not isinstance(layers, xr.Dataset):
        expected = "a dataset, as snowsim.io.open_segment reads it from files"
        msg = f"layers: expected {expected}, got {type(layers).__name__}"
        raise ValueError(msg)
    layers = _from_surface_down(_of_snow(with_fixes(layers)))
    check_layers(layers)
    _warn_of_bad(layers)
    if "confidence" in layers:
        known = layers["confidence"].values
        check_values("layers: confidence", known[np.isfinite(known)], 0, 1)
    return layers


def _of_snow(layers):
    """Layers without one named bottom, which is no horizon of snow, and without picks at time 0."""
    if not {"layer", "twtt"} <= set(layers.variables):
        return layers  # which is refused
    names = [str(name) for name in layers.get_index("layer")]
    of_bottom = [name.rpartition(":")[2].lower() == BOTTOM_NAME for name in names]
    if any(of_bottom):
        warnings.warn(
            "layers: the layer bottom is left out: by its name it is no horizon of snow",
            stacklevel=4,
        )
    layers = layers.isel(layer=~np.array(of_bottom))
    # Zero means that nobody picked.
    return layers.assign(twtt=layers["twtt"].where(layers["twtt"] != 0))


def _warn_of_bad(layers):
    """Warn of picks that are bad by their quality and have no confidence, which would count."""
    bad = (layers["quality"] == BAD) & layers["twtt"].notnull()
    if "confidence" in layers:
        bad &= layers["confidence"].isnull()
    names = layers["layer"].values[bad.any("slow_time").values]
    if names.size:
        warnings.warn(
            f"layers: {int(bad.sum())} picks have quality {BAD}, bad, and are used as others are, "
            f"of {', '.join(map(str, names[:MOST_NAMED]))}: correct them, or leave them out",
            stacklevel=4,
        )


def _from_surface_down(layers):
    """Layers in order from the surface down, as ages are counted.

    Names need not be in this order: layers that a person added come last, and those behind a gap of
    a track go on with numbers of their own.
    """
    if {"layer", "slow_time"} != set(layers.get("twtt", xr.DataArray()).dims):
        return layers  # which is refused
    twtt = layers["twtt"].transpose("layer", "slow_time").values
    names = [str(name) for name in layers.get_index("layer")]
    names[:1] = [SURFACE_NAME if name == "0" else name for name in names[:1]]
    below = pd.DataFrame(twtt - twtt[0]).median(axis=1).dropna()
    if below.is_monotonic_increasing and not crossing_layers(twtt).any():
        return layers
    return layers.isel(layer=order_from_surface(twtt, names))


def _every_one_a_year(layers):
    """Whether layers are a person's, or the interfaces of simulated snow, and not a tracker's."""
    if "confidence" in layers:
        return False
    below = layers.isel(layer=slice(1, None))  # a person may have picked the surface alone
    by_hand = ((below["type"] != AUTOMATIC) & below["twtt"].notnull()).any()
    if by_hand or layers["twtt"].attrs.get("place") == "interface":
        return True
    warnings.warn(
        "layers: all picks are automatic by their type, so years are counted; say if a person "
        "made every layer one year (annual=True, --annual)",
        stacklevel=3,
    )
    return False


def _latitudes(layers):
    """Known latitudes of range lines [degrees]."""
    latitudes = np.asarray(layers.get("Latitude", []), dtype=float)
    return latitudes[np.isfinite(latitudes)]


@dataclass(frozen=True, eq=False)
class _Picks:
    """The surface and the picks that are used, and the names of their layers.

    `below_s` is the travel time below the surface, `error_s` its error, and `doubt` the probability
    that no layer lies there, all (layer, range_line). `left_out` names layers above the first one
    used. `last_autumn` is the year of the last autumn before the first range line, and `elapsed`
    the share of the snow year that had elapsed since.
    `separable_s` is the least time between two layers that the tracker separates, 0 if unknown.
    """

    names: np.ndarray
    below_s: np.ndarray
    error_s: np.ndarray
    doubt: np.ndarray
    left_out: str
    last_autumn: int
    elapsed: float
    separable_s: float

    def down_to(self, column):
        """The layers above the end of a `Column`; ValueError unless two are left on a line."""
        end_s = column.twtt_s[-1]
        inside = (self.below_s <= end_s).any(axis=1)
        if (self.below_s <= end_s).sum(axis=0).max() < 3:
            msg = (
                "layers: expected two horizons on a range line above "
                f"{column.depth_m[-1]:.4g} m, where density ends, found none"
            )
            raise ValueError(msg)
        names = ("names", "below_s", "error_s", "doubt")
        return replace(self, **{name: getattr(self, name)[inside] for name in names})


def _picks(layers, least_confidence, year):
    """`_Picks` of a dataset, without the layers that are missing or faint on most lines."""
    layers = layers.transpose("layer", "slow_time", ...).dropna("layer", how="all", subset=["twtt"])
    names = np.array([str(name).rpartition(":")[2] for name in layers.get_index("layer")])
    twtt = layers["twtt"]
    # Joined frames may be with and without confidence.
    sure = layers.get("confidence", np.nan * twtt).fillna(USUAL_CONFIDENCE).where(twtt.notnull())
    sure[:1] = [1 if is_surface(name) or name == "0" else np.nan for name in names[:1]]
    error = ((layers.get("twtt_high", twtt) - layers.get("twtt_low", twtt)) / 2).fillna(0)
    below = (twtt - twtt[0]).where(sure >= least_confidence)
    doubt = (1 - sure).clip(LEAST_DOUBT)
    # A layer that is faint on most lines, as in the tail of the surface's echo, would shift dates.
    kept = np.flatnonzero(sure.median("slow_time") >= least_confidence)
    if 0 not in kept[:-1]:
        unnamed = all(name.startswith("id ") for name in names)
        remedy = ": no organizer file layer_SEGMENT.mat beside them names layers" * unnamed
        msg = (
            "layers: expected the surface first, with travel times, and others below it of "
            f"confidence {least_confidence:g} or more, found {', '.join(names)}{remedy}"
        )
        raise ValueError(msg)
    values = (each.values[kept] for each in (below, error, doubt))
    left_out = ", ".join(names[1 : kept[1]])
    names = names[kept]
    separable_s = float(layers.attrs.get("apart_s", 0))
    return _Picks(names, *values, left_out, *_season(layers, year, names[1]), separable_s)


def _season(layers, year, first):
    """Year of the last autumn before the flight, and share of the snow year elapsed since.

    Where times are invented, the last autumn is that of the layer named `first`, whose year is
    given; else ValueError.
    """
    latitudes = _latitudes(layers)
    if year is None and not latitudes.size:
        warnings.warn(
            "layers: no positions: snow years are taken to end in August, as in the north",
            stacklevel=4,
        )
    is_south = latitudes.size > 0 and np.median(latitudes) < 0
    time = layers.get_index("slow_time")[0]
    in_years = time + pd.DateOffset(months=SOUTH_MONTHS if is_south else NORTH_MONTHS)
    last_autumn = in_years.year - 1
    if time == INVENTED_TIME:
        last_autumn = year.get(first) if isinstance(year, Mapping) else year
        if last_autumn is None:
            msg = (
                "layers: slow_time: expected the time of the flight, from which years are counted, "
                f"found invented ones: give the year of {first} (year, --year {first}=2011)"
            )
            raise ValueError(msg)
    return last_autumn, in_years.day_of_year / YEAR_DAYS


def _warn(picks, dated, annual):
    """Warn of doubt that all dates share, and of spans of very many years."""
    if not dated.resolved:
        warnings.warn(
            "layers: nothing is dated, rows have depth and mass between layers: a typical year "
            f"may span less than {HALF_SEPARATED:g} times the {1e9 * picks.separable_s:.2g} ns "
            "within which the tracker separates no layers; then it misses half of the horizons or "
            "more; name a layer, or give the accumulation that is expected",
            stacklevel=3,
        )
        return
    first = dated.first
    longest = np.diff(dated.age[dated.age >= 0]).max(initial=0)
    open_years = dated.above_m[first - 1] / dated.typical_m
    hangs_on = (
        f"{picks.names[first]}, the first horizon, taken for that of "
        f"{dated.last_autumn - dated.age[first]:g} with a probability of {dated.sure[first]:.2g}: "
        "all dates hang on it, unless a layer is named"
    )
    warned = {
        f"faint {picks.left_out} left out above {hangs_on}": picks.left_out,
        f"snow of {open_years:.2g} typical years lies above {hangs_on}": (
            dated.sure[first] < LEAST_SURE and not annual
        ),
        f"up to {longest:g} years lie between two picks, and have one mean": longest > LONG_YEARS,
    }
    for text, applies in warned.items():
        if applies:
            warnings.warn(f"layers: {text}", stacklevel=3)


def _surety(dated):
    """A line that states how many dates are sure, and what would help most."""
    of_horizons = dated.sure[1:][dated.age[1:] >= 0]
    n_sure = int((of_horizons >= LEAST_SURE).sum())
    share = f"{n_sure} of {of_horizons.size} dates are right with a probability of {LEAST_SURE:g}"
    if not dated.resolved or n_sure == of_horizons.size:
        return share + " or more"
    remedy = "a core, or the name of a layer whose year is known, would help most"
    if dated.sure[dated.first] < LEAST_SURE:
        remedy = "the name of a layer whose year is known (--year NAME=YEAR) would help most"
    elif dated.posterior.mass_error > VAGUE_MASS_ERROR:
        remedy = "the accumulation of the place (--expected) would help most"
    return f"{share} or more: {remedy}"


def _yearly(layers, picks, column, dated, density_error):
    """Dataset of `accumulation`; each span is divided into equal years."""
    depth_m = column.at(column.depth_m, picks.below_s)
    water_m = column.at(column.water_m, picks.below_s)
    spans = _spans(picks, depth_m, water_m, dated, density_error)
    spans["slow_time"] = layers["slow_time"].values[spans.pop("line")]
    rows = spans.loc[np.repeat(spans.index, spans["n_years"])]
    within = rows.groupby(level=0).cumcount()
    rows["year"] -= within
    rows["depth_m"] += within * rows["thickness_m"]
    # A horizon without a pick is as sure as the less sure of the picks that bound it.
    sure_below = rows.pop("sure_below")
    rows["year_confidence"] = rows["year_confidence"].where(within == 0, sure_below)
    # A year whose lower end is unsure may be more years, or less than one.
    unsure = np.minimum(rows["year_confidence"], sure_below) < LEAST_SURE
    rows["flag"] = unsure.astype(int)
    for name in ("age_low", "age_high"):
        rows[name] += within
    found = _dataset(layers, rows)
    times_s = np.linspace(0, min(1.1 * np.nanmax(picks.below_s), column.twtt_s[-1]), N_TIMES)
    found["depth_at"] = ("below_s", column.at(column.depth_m, times_s))
    newest = np.append(-1, dated.age[1:]) == 0
    found["open_m_we"] = ("slow_time", np.fmin.reduce(np.where(newest[:, None], water_m, np.nan)))
    found["layer_depth_m"] = (("layer", "slow_time"), depth_m)
    found["layer_m_we"] = (("layer", "slow_time"), water_m)
    found["layer_year"] = ("layer", np.where(dated.age < 0, np.nan, dated.last_autumn - dated.age))
    found = found.assign_coords(below_s=times_s, layer=picks.names)
    for name, (units, meaning) in UNIT_AND_MEANING.items():
        found[name].attrs |= {"units": units, "long_name": meaning}
    first = dated.first
    uppermost = f"{picks.names[first]}={dated.last_autumn - dated.age[first]:g}"
    return found.assign_attrs(
        uppermost=uppermost if dated.resolved else "none",
        no_horizon=", ".join(picks.names[1:][dated.age[1:] < 0]) if dated.resolved else "",
        last_autumn=dated.last_autumn,
        typical_m=dated.typical_m,
        surety=_surety(dated),
    )


def _spans(picks, depth_m, water_m, dated, density_error):
    """Table of the spans between horizons that follow each other on a range line."""
    above = _horizon_above(dated.age, np.isfinite(water_m))
    layer, line = base = np.nonzero(above > 0)
    upper = above[base]
    top = (upper, line)
    n_years = (dated.age[layer] - dated.age[upper]).astype(int)
    thickness_m = depth_m[base] - depth_m[top]
    span_m = water_m[base] - water_m[top]
    of_picks = np.hypot(picks.error_s[base], picks.error_s[top])
    of_picks /= picks.below_s[base] - picks.below_s[top]
    density = WATER_DENSITY_KG_M3 * span_m / thickness_m
    # Years that share one mean scatter about it, and so does the density of each.
    of_year = dated.scatter * np.sqrt(1 - 1 / n_years)
    of_snow = DENSITY_SD_KG_M3 / density / np.sqrt(n_years)
    of_density = np.hypot(density_error, of_snow) / (1 + KOVACS_M3_KG * density)
    relative = np.hypot(of_picks, NINE_IN_TEN_SD * np.hypot(of_density, of_year))
    pairs, which = np.unique([upper, layer], axis=1, return_inverse=True)
    limits = np.array([dated.relative_limits(*pair) for pair in pairs.T]).reshape(-1, 2)
    low, high = limits[which.ravel()].T
    mean_m = span_m / n_years
    return pd.DataFrame(
        {
            "line": line,
            "year": (dated.last_autumn - dated.age[upper]).astype(int),
            "depth_m": depth_m[top],
            "thickness_m": thickness_m / n_years,
            "accumulation_m_we": mean_m,
            "low": mean_m * np.maximum(1 - np.hypot(relative, 1 - low), 0),
            "high": mean_m * (1 + np.hypot(relative, high - 1)),
            "error_picks": mean_m * of_picks,
            "error_density": mean_m * NINE_IN_TEN_SD * of_density,
            "n_years": n_years,
            "year_confidence": dated.sure[upper],
            "sure_below": np.minimum(dated.sure[upper], dated.sure[layer]),
            "age_low": dated.age_low[upper],
            "age_high": dated.age_high[upper],
        }
    )


def _horizon_above(age, there):
    """Number of the next horizon above each horizon, (layer, range_line), 0 for the surface.

    It is -1 where a layer is no horizon, has no pick, or has the age of the horizon above it.
    """
    above = np.full(there.shape, -1)
    last = np.zeros(there.shape[1], dtype=int)
    for layer in np.flatnonzero(age >= 0):
        lines = np.flatnonzero(there[layer] & ((last == 0) | (age[layer] > age[last])))
        above[layer, lines] = last[lines]
        last[lines] = layer
    return above


def _dataset(layers, rows):
    """Dataset of rows on (year, slow_time), with the positions of the layers."""
    years = np.arange(rows["year"].max(), rows["year"].min() - 1, -1) if len(rows) else []
    found = rows.set_index(["year", "slow_time"]).to_xarray()
    found = found.reindex(year=np.array(years, int), slow_time=layers["slow_time"])
    for name in ("Latitude", "Longitude", "frame"):
        if name in layers:
            found[name] = ("slow_time", layers[name].values, layers[name].attrs)
            found[name].attrs = {
                "units": "1" if name == "frame" else "degrees",
                "long_name": name,
            } | found[name].attrs
    return found
