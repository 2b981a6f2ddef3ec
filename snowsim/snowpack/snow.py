"""Snow between picked layers: its depth, age and accumulation."""

import warnings
from dataclasses import dataclass

import numpy as np
import pandas as pd

from snowsim.constants import KOVACS_M3_KG, WATER_DENSITY_KG_M3
from snowsim.echogram import check_layers
from snowsim.limits import check_count, check_values
from snowsim.snowpack.column import column_of, temperature_k_of

SURFACE = "surface"
# Density at the surface where none is given: with it, Herron & Langway's firn agrees below 1 m to 3
# % with the medians of 391 Greenland cores from above 2500 m.
SURFACE_DENSITY_KG_M3 = 340.0
# Months from the end of a snow year, August in the north and February in the south, to December.
NORTH_MONTHS, SOUTH_MONTHS = 4, 10
YEAR_DAYS = 366
FIRST_GUESS_M = 0.3  # mean accumulation [m w.e. / yr], on which that firn's density depends
N_ROUNDS = 3  # rounds in which typical mass, ages and mean accumulation adapt to each other
TYPICAL_LINES = 601  # range lines, whose median mass of a year is the typical one in the middle
# Standard deviation of a year's mass over the typical one: years differ (by .13 to .31 in cores),
# and picks and the typical mass have errors.
SPREAD = 0.3
# Share of spans over more than a year, chosen on half of the cores, a fifth of horizons missing.
MISSED = 0.3
# Odds that a pick is no horizon, over the probability that no layer lies there.
NO_HORIZON = 0.4
USUAL_CONFIDENCE = 0.9  # of picks that come without one, as a person's
LEAST_DOUBT = 0.05  # smallest probability that no layer lies at a pick
KNOWN_DOUBT = 1e-9  # that of layers whose year is given
# Where horizons are missing, the typical mass is so many times the median of spans; how many spans
# tell.
SCALES = np.geomspace(0.35, 1.1, 24)
N_SPANS = 1000
LEAST_RATIO = 0.01  # of mass to that of a typical year
IMPOSSIBLE = -30.0  # log-likelihood of a negative number of years
# Mass of a year over the typical one, beyond which its span is doubtful.
THIN = 0.4
THICK = 1.7
CONTRADICTION = 4  # factor of mass, likewise, from which on years of names are refused
MISCOUNT = 0.5  # years above the first horizon, or their error, from which on a warning says so
LONG_YEARS = 12  # number of years between two picks from which on a warning says so
N_TIMES = 500  # travel times at which depth is tabulated
DENSITY_SD_KG_M3 = 30.0  # of a year's snow about the profile: cores, 18-39
NINE_OF_TEN = 1.645  # standard deviations to either side that hold nine of ten
LEAST_SURE = 0.8  # smallest confidence in a count of years without a flag


def accumulation(
    layers,
    density=None,
    *,
    year=None,
    annual=None,
    temperature_k=None,
    density_error=0.05,
    least_confidence=0.5,
):
    """Accumulation of every year between picked layers, along the track.

    Parameters
    ----------
    layers : xarray.Dataset
        Layers as `snowsim track` writes them, or as `snowsim.io.open_segment` joins them. `twtt`
        (layer, slow_time) [s] runs from the surface down, and a name stays with the same horizon
        along the track. `twtt_low`, `twtt_high` and `confidence` are used where present.
    density : float or snowsim.io.profiles.Profile, optional
        Density of the snow [kg m-3], 50 to 917; or a profile of density, below whose end no pick is
        used. By default density grows from 340 by Herron & Langway (1980), under the mean
        accumulation found here.
    year : int or mapping of str to int, optional
        Year of the first layer below the surface that is used, or years of layers by name:
        ``{"snow_3": 2008}``. The snow of a year lies below the horizon of that year. By default the
        newest horizon is of the last autumn before the first range line, from September (in the
        south, March) on of the same year, and years above the first layer are counted, too.
    annual : bool, optional
        Whether every layer is one autumn horizon, and none is missing; else years are counted. By
        default annual where layers have no `confidence`: a person picked them.
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
        - `accumulation_m_we` [m w.e. / yr], and `low` and `high`, the limits that hold it in nine
          of ten years that are counted rightly; `error_picks` and `error_density` are parts of it;
        - `n_years`, the number of years between the picks that bound it: thickness and accumulation
          are means over these years; and `confidence`, the probability of this number;
        - `age_error_years` of the horizon, 0 at layers that are named;
        - `flag`: 1 where the number of years is doubtful, else 0.

        `open_m_we` (slow_time) is the mass above the first horizon, not a whole year. `depth_at`
        (below_s) is the depth [m] at travel times below the surface. `attrs` hold `uppermost`, the
        horizon that is uppermost on most range lines, with its year, ``snow_2=2011``; `no_horizon`,
        names of layers that are taken for none; `n_below_profile`, the number of picks below the
        end of a profile; of firn `surface_density_kg_m3` and `temperature_k`.

    Raises
    ------
    ValueError
        If the surface is missing, layers cross, a density is out of range, no range line has two
        horizons within the profile, a name is no layer's, or years contradict one another.

    Notes
    -----
    The travel time to depth z below the mass w [m w.e.] is ``t = (2 / c) (z + 0.845 w)`` (Kovacs,
    Gow & Morey 1995). The number of years between two picks follows from their mass over the
    typical annual mass, a median along track and in depth, or, where most horizons are missing, the
    share of it that makes all masses most probable. The mass of n years is lognormal and scatters
    by s n^(1/2), where s is the scatter of single years. A layer has one age along the whole track.
    Range lines on which different layers lie above it vote for this age, by their log-likelihood. A
    pick that is more probably no horizon is left out. Then all is repeated with the typical mass
    that these ages give. Where most picks are of crusts between horizons, half a year counts as
    one, and accumulation is halved without a flag: compare a core, or a layer of known age.

    A layer that is as probably none is counted as 1/2 +- 1/2 year, as in ice cores (Rasmussen et
    al. 2006, J. Geophys. Res. 111, D06102): the expected miscount, at most 1/2 for one of two. Its
    sum from the surface, or from a named layer, is `age_error_years`. Where nothing is counted, a
    span above 1.7 or below .4 typical years is doubtful.

    The errors of both picks, each half of ``twtt_high - twtt_low``, of density, and of a year about
    the mean of m years, ``s (1 - 1 / m)^(1/2)``, add in squares; a relative error e of density
    counts as ``e / n`` with the refractive index n. Of density, the whole profile is off by
    `density_error`, and the snow of each year by 30 kg m-3, as in cores. Picks lie 1.2 to 1.7 range
    bins below their interface. This cancels in a year's mass, but not in `open_m_we`.
    """
    picks = _picks(layers, least_confidence)
    check_values("density_error", density_error, 0, 1)
    annual = "confidence" not in layers if annual is None else annual
    year = {picks.names[0]: picks.flown.year} if year is None else year
    firn = {}
    if density is None or temperature_k is not None:
        density = SURFACE_DENSITY_KG_M3 if density is None else density
        temperature_k = temperature_k_of(layers) if temperature_k is None else temperature_k
        firn = {"surface_density_kg_m3": density, "temperature_k": temperature_k}
    mean_m = FIRST_GUESS_M
    for _ in range(N_ROUNDS if firn else 1):
        column = column_of(density, temperature_k, mean_m)
        dated = _dated(column.at(column.water_m, picks.below_s), picks, year, annual)
        if not dated.whole.any():
            msg = (
                "layers: expected two horizons on a range line above "
                f"{column.depth_m[-1]:.4g} m, where density ends, found none"
            )
            raise ValueError(msg)
        mean_m = np.nanmean(dated.span_m / dated.n_years)
    _warn(picks, dated)
    return _by_year(layers, picks, column, dated, density_error).assign_attrs(firn)


@dataclass(frozen=True, eq=False)
class _Picks:
    """The surface and the picks that are used, and the names of their layers.

    On (layer, range_line): `below_s` is the travel time below the surface, `error_s` its error, and
    `doubt` the probability that no layer lies there. `left_out` names layers above the first
    that is used; `flown` is the time of the first range line, in years that begin with an autumn.
    """

    names: np.ndarray
    below_s: np.ndarray
    error_s: np.ndarray
    doubt: np.ndarray
    left_out: str
    flown: pd.Timestamp


def _picks(layers, least_confidence):
    """`_Picks` of a dataset; layers are left out where most picks are missing or faint."""
    check_layers(layers)
    layers = layers.transpose("layer", "slow_time", ...).dropna("layer", how="all", subset=["twtt"])
    names = np.array([str(name).rpartition(":")[2] for name in layers.get_index("layer")])
    twtt = layers["twtt"]
    # Of frames that are joined, one may have none.
    sure = layers.get("confidence", np.nan * twtt).fillna(USUAL_CONFIDENCE).where(twtt.notnull())
    sure[:1] = np.where(np.isin(names[:1], (SURFACE, "0")), 1, np.nan)
    error = ((layers.get("twtt_high", twtt) - layers.get("twtt_low", twtt)) / 2).fillna(0)
    below = (twtt - twtt[0]).where(sure >= least_confidence)
    doubt = (1 - sure).clip(LEAST_DOUBT)
    # A layer that is faint on most lines, as in the tail of the surface's echo, would date others.
    kept = np.flatnonzero(sure.median("slow_time") >= least_confidence)
    if 0 not in kept[:-1]:
        msg = (
            "layers: expected the surface first, with travel times, and others below it of "
            f"confidence {least_confidence:g} or more, found {', '.join(names)}"
        )
        raise ValueError(msg)
    values = (each.values[kept] for each in (below, error, doubt))
    months = SOUTH_MONTHS if np.any(layers.get("Latitude", 0) < 0) else NORTH_MONTHS
    flown = layers.get_index("slow_time")[0] + pd.DateOffset(months=months)
    return _Picks(names[kept], *values, ", ".join(names[1 : kept[1]]), flown)


@dataclass(frozen=True, eq=False)
class _Dated:
    """Ages of horizons, and the spans between each and the next above it on the same range line.

    `newest` is the year of age 0; `open_years` typical ones lie above the first horizon; `age`
    (layer,) is how many years a layer is older, -1 for the surface, and `error` the expected
    miscount of that. On (layer, range_line): `above` is the layer that bounds a span from above, 0
    for the surface, -1 where there is none; `span_m` its mass [m w.e.], `n_years` its number of
    years and `sure` the probability of this number.
    """

    newest: int
    open_years: float
    age: np.ndarray
    error: np.ndarray
    above: np.ndarray
    span_m: np.ndarray
    n_years: np.ndarray
    sure: np.ndarray

    @property
    def whole(self):
        """Whether a span lies between two horizons; below the surface lies no whole year."""
        return self.above > 0


def _dated(water_m, picks, year, annual):
    """`_Dated` from the mass above picks (layer, range_line) [m w.e.]."""
    is_named = hasattr(year, "items")
    given = _given(picks, year if is_named else {str(picks.names[1]): year})
    known = _in_order(len(picks.names), given) if annual else given
    first = min(known)
    older = {layer: known[first] - value for layer, value in known.items()}
    doubt = picks.doubt.copy()
    doubt[list(given)] = KNOWN_DOUBT
    elapsed = picks.flown.day_of_year / YEAR_DAYS
    typical_m = _first_typical(water_m[1:])
    for _ in range(N_ROUNDS):
        age, above, miscount = _vote(water_m / typical_m, doubt, older, first, elapsed)
        whole = above > 0
        span_m = water_m - np.take_along_axis(water_m, above, axis=0)
        n_years = np.where(whole, age[:, None] - age[above], np.nan)
        year_m = span_m / n_years
        typical_m = _typical(year_m)
    years = water_m / typical_m
    _check_years(years, given)
    open_years = pd.Series(years[1]).median()
    ratio = year_m / typical_m
    odd = (ratio < THIN) | (ratio > THICK)
    if annual:
        of_layer = odd.sum(axis=1) > whole.sum(axis=1) / 2
        of_layer[1] = open_years > THICK
        miscount = np.cumsum(of_layer / 2)
    named = list(given) if is_named else [0]
    error = np.abs(miscount[:, None] - miscount[named]).min(axis=1)
    sure = np.clip(1 - np.abs(miscount[:, None] - miscount[above]), 0, np.where(odd, 0.5, 1))
    for layer in named:  # between two named layers lie as many years as their names say
        sure[layer, np.isin(above[layer], named)] = 1
    return _Dated(
        int(known[first] + age[first]), open_years, age, error, above, span_m, n_years, sure
    )


def _given(picks, year):
    """Years by the number of the layer that is named so, downwards."""
    for each in year.values():
        check_count("year", each, 0)
    given = {layer: year[name] for layer, name in enumerate(picks.names) if name in year}
    flown = picks.flown.year  # of the surface; the last autumn is of the year before
    falling = np.diff([flown + (0 in given), *given.values()]) < 0
    if not len(given) == len(year) > 0 or not falling.all():
        msg = (
            f"year: expected names of layers with picks, {', '.join(picks.names[1:])}, and years "
            f"that fall from each to the next, none after {flown - 1}, found {year}"
        )
        raise ValueError(msg)
    return given


def _in_order(n_layers, given):
    """Years of all layers, each a year older than the one above it, but for those given."""
    layers, years = np.array(list(given.items())).T
    more = -np.diff(layers + years)
    if (np.diff(layers)[more != 0] > 1).any():
        msg = (
            f"year: expected as many years from name to name as layers, found {more} more: name "
            "every layer, or count years"
        )
        raise ValueError(msg)
    every = np.arange(n_layers)
    every_year = np.interp(every, layers, layers + years).astype(int) - every
    return dict(enumerate(every_year[1:], start=1))


def _check_years(years, given):
    """Refuse given years between which lies far more or less snow (layer, line) than typical."""
    told = -np.diff(list(given.values()))
    found = pd.DataFrame(np.diff(years[list(given)], axis=0)).median(axis=1)
    if ((found < told / CONTRADICTION) | (found > told * CONTRADICTION)).any():
        msg = (
            f"year: from name to name {told} years contradict their snow, that of "
            f"{found.to_numpy().round(1)} typical years"
        )
        raise ValueError(msg)


def _typical(year_m):
    """Typical mass of a year (range_line,): the median of `year_m` in depth, then along track."""
    around = pd.DataFrame(year_m).median().rolling(TYPICAL_LINES, 1, center=True)
    return around.median().interpolate(limit_direction="both").to_numpy()


def _first_typical(water_m):
    """Typical mass of a year (range_line,), before years between picks (layer, line) are counted.

    Where most horizons are missing, the median of spans is of several years: of shares of it, the
    one that makes the masses of all spans most probable.
    """
    year_m = np.diff(np.sort(water_m, axis=0), axis=0)
    typical_m = _typical(year_m)
    ratio = year_m / typical_m
    ratio = ratio[np.isfinite(ratio)]
    some = np.maximum(ratio[:: 1 + ratio.size // N_SPANS], LEAST_RATIO) / SCALES[:, None]
    of_years = _log_likelihood(some[..., None], np.arange(LONG_YEARS), LEAST_DOUBT)
    likelihood = np.exp(of_years).sum(axis=2) / SCALES[:, None]
    return typical_m * SCALES[np.log(likelihood).sum(axis=1).argmax()]


def _log_likelihood(ratio, n_years, doubt):
    """Log-likelihood of `n_years` between two picks, from their mass over that of a typical year.

    The mass is lognormal. Gaps of n > 1 years, of no typical length, are as frequent as 1 / (n (n -
    1)). No years means that one of the picks is no horizon, which is likelier the larger `doubt`.
    """
    none = NO_HORIZON * doubt
    years = np.maximum(n_years, 1)
    variance = np.log1p(SPREAD**2 / years)
    of_mass = -(np.log(ratio / years) ** 2 / variance + np.log(2 * np.pi * variance)) / 2
    gap = np.where(years == 1, 1 - MISSED, MISSED / np.maximum(years**2 - years, 1))
    whole = np.log((1 - none) * gap / ratio) + of_mass
    nothing = np.log(none) - np.maximum(ratio - 1, 0) ** 2 / (2 * SPREAD**2)
    return np.select([n_years > 0, n_years == 0], [whole, nothing], IMPOSSIBLE)


def _vote(years, doubt, older, first, elapsed):
    """Age of layers, the layer above each pick, and the expected miscount of ages.

    Layers are dated from the first down, by the mass in typical years (layer, range_line) since the
    last horizon on each range line; some are known to be years `older` than the `first` of these.
    The first is the newest horizon, but where the surface is dated. Of a year, a share has
    `elapsed` since the last autumn. A layer of no horizon has the age of the one above it; it
    bounds no span.
    """
    age = np.full(len(years), -1)
    above = np.full(years.shape, -1)
    miscount = np.zeros(len(years))
    # The snow above the first is of the year that has elapsed, or more if a horizon is missing.
    years = years.copy()
    years[0] = np.minimum(years[1], elapsed) - 1
    last = np.zeros(years.shape[1], dtype=int)
    for layer, own in enumerate(years[1:], start=1):
        there = np.flatnonzero(np.isfinite(own))
        if there.size == 0:
            continue
        upper = last[there]
        ratio = own[there] - years[upper, there]
        ages, share = _ages(ratio, age[upper], np.median(doubt[layer, there]))
        deeper = min((n for n in older if n > layer > first), default=layer)
        below = pd.Series(years[deeper] - own).median()
        if below > 0:
            n_below = age[first] + older[deeper] - ages
            share *= np.exp(_log_likelihood(below, n_below, KNOWN_DOUBT))
        age[layer] = ages[share.argmax()] if layer > 1 or first == 0 else 0
        if layer in older and layer > first:
            age[layer] = age[first] + older[layer]
        if layer == 1:  # where it is missing, snow is counted from where it is elsewhere
            years[0] = np.nanmedian(own) - 1 - age[1]
        expected = share @ np.abs(ages - age[layer]) / share.sum()
        miscount[layer] = miscount[upper].mean() + expected
        horizon = there[age[layer] > age[upper]]
        above[layer, horizon] = last[horizon]
        last[horizon] = layer
    return age, above, miscount


def _ages(ratio, upper_age, doubt):
    """Ages that a layer may have and their likelihood.

    From the ages above it and `ratio`, years of mass between, (range_line,).
    """
    ratio = np.maximum(ratio, LEAST_RATIO)
    ages = upper_age.min() + np.arange(np.ptp(upper_age) + int(ratio.max()) + 4)
    likelihood = np.zeros(ages.size)
    for own in np.unique(upper_age):
        of_own = upper_age == own
        found = _log_likelihood(np.median(ratio[of_own]), ages - own, doubt)
        likelihood += of_own.mean() * found
    return ages, np.exp(likelihood - likelihood.max())


def _warn(picks, dated):
    """Say what may shift every date, and that a span has very many years."""
    first = (
        f"above {picks.names[1]}, the first horizon, taken for that of "
        f"{dated.newest - dated.age[1]}: a year off shifts every date, unless a layer is named"
    )
    longest = np.nanmax(dated.n_years)
    said = {
        f"faint {picks.left_out} left out {first}": picks.left_out,
        f"snow of {dated.open_years:.2g} typical years lies {first}": (
            max(dated.age[1], dated.error[1]) >= MISCOUNT
        ),
        f"up to {longest:g} years lie between two picks, and have one mean": longest > LONG_YEARS,
    }
    for text, is_so in said.items():
        if is_so:
            warnings.warn(f"layers: {text}", stacklevel=3)


def _by_year(layers, picks, column, dated, density_error):
    """Dataset of `accumulation`: each span is divided into equal years."""
    depth_m = column.at(column.depth_m, picks.below_s)
    layer, line = base = np.nonzero(dated.whole)
    upper, _ = top = (dated.above[base], line)
    n_years = dated.n_years[base].astype(int)
    thickness_m = depth_m[base] - depth_m[top]
    of_picks = np.hypot(picks.error_s[base], picks.error_s[top])
    of_picks /= picks.below_s[base] - picks.below_s[top]
    span_m = dated.span_m[base]
    density = WATER_DENSITY_KG_M3 * span_m / thickness_m
    # Of years that have one mean, each scatters about it, and so does the density of each.
    of_year = SPREAD * np.sqrt(1 - 1 / n_years)
    of_snow = DENSITY_SD_KG_M3 / density / np.sqrt(n_years)
    of_density = np.hypot(density_error, of_snow) / (1 + KOVACS_M3_KG * density)
    relative = np.hypot(of_picks, NINE_OF_TEN * np.hypot(of_density, of_year))
    sure = dated.sure[base]
    mean_m = span_m / n_years
    spans = {
        "slow_time": layers["slow_time"].values[line],
        "year": dated.newest - dated.age[upper],
        "depth_m": depth_m[top],
        "thickness_m": thickness_m / n_years,
        "accumulation_m_we": mean_m,
        "low": mean_m * np.maximum(1 - relative, 0),
        "high": mean_m * (1 + relative),
        "error_picks": mean_m * of_picks,
        "error_density": mean_m * NINE_OF_TEN * of_density,
        "n_years": n_years,
        "confidence": sure,
        "age_error_years": dated.error[upper],
        "error_step": (dated.error[layer] - dated.error[upper]) / n_years,
        "flag": (sure < LEAST_SURE).astype(int),
    }
    rows = pd.DataFrame(spans).loc[np.repeat(np.arange(n_years.size), n_years)]
    within = rows.groupby(level=0).cumcount()
    rows["year"] -= within
    rows["depth_m"] += within * rows["thickness_m"]
    rows["age_error_years"] += within * rows.pop("error_step")
    found = _dataset(layers, rows)
    times_s = np.linspace(0, min(1.1 * np.nanmax(picks.below_s), column.twtt_s[-1]), N_TIMES)
    found["depth_at"] = ("below_s", column.at(column.depth_m, times_s))
    from_surface = dated.above == 0
    first = from_surface & (dated.age[:, None] == 0)
    found["open_m_we"] = ("slow_time", np.fmin.reduce(np.where(first, dated.span_m, np.nan)))
    uppermost = from_surface.sum(axis=1).argmax()
    _, *no_horizon = picks.names[(dated.above < 0).all(axis=1) & np.isfinite(depth_m).any(axis=1)]
    return found.assign_coords(below_s=times_s).assign_attrs(
        uppermost=f"{picks.names[uppermost]}={dated.newest - dated.age[uppermost]}",
        no_horizon=", ".join(no_horizon),
        n_below_profile=(picks.below_s > column.twtt_s[-1]).sum(),
    )


def _dataset(layers, rows):
    """Rows as a dataset on (year, slow_time), with positions of the layers."""
    years = np.arange(rows["year"].max(), rows["year"].min() - 1, -1)
    found = rows.set_index(["year", "slow_time"]).to_xarray()
    found = found.reindex(year=years, slow_time=layers["slow_time"])
    for name in ("Latitude", "Longitude", "frame"):
        if name in layers:
            found[name] = ("slow_time", layers[name].values)
    return found
