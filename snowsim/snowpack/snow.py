"""Snow between picked layers: its depth, age and accumulation."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from snowsim.constants import ICE_DENSITY_KG_M3, SPEED_OF_LIGHT_M_S, WATER_DENSITY_KG_M3
from snowsim.echogram import check_layers
from snowsim.limits import check_values
from snowsim.snowpack.firn import (
    depth_herron_langway80,
    travel_time_s,
)
from snowsim.snowpack.profile import interfaces

SURFACE = "surface"
DENSITIES_KG_M3 = (50, ICE_DENSITY_KG_M3)
DEEPEST_M = 500.0  # depth at which snow of one density ends
DEEPEST_WATER_M = 200.0  # mass above the depth at which Herron & Langway's firn ends
FIRST_GUESS_M = 0.3  # mean accumulation [m w.e. / yr], on which that firn's density depends
N_ROUNDS = 3  # rounds in which typical mass, ages and mean accumulation adapt to each other
TYPICAL_LINES = 300  # range lines to either side, whose median mass of a year is the typical one
# Standard deviation of a year's mass over the typical one: years differ (by .17 to .28 in cores),
# and picks and the typical mass have errors.
SPREAD = 0.3
MISSED = 0.7  # factor of the odds for each year between two picks
# Odds that a pick is no horizon, over the probability that no layer lies there.
NO_HORIZON = 0.4
USUAL_CONFIDENCE = 0.75  # of picks that come without one
LEAST_DOUBT = 0.05  # smallest probability that no layer lies at a pick
KNOWN_DOUBT = 1e-9  # that of the surface and of layers whose year is given
MOST_YEARS = 12  # largest number of years between two picks
IMPOSSIBLE = -30.0  # log-likelihood of a negative number of years
N_TIMES = 500  # travel times at which depth is tabulated
NINE_OF_TEN = 1.645  # standard deviations to either side that hold nine of ten
LEAST_SURE = 0.8  # smallest confidence in a count of years without a flag
COUNT_UNCERTAIN = 1
AGE_UNCERTAIN = 2
COLUMNS = (
    "depth_m",
    "thickness_m",
    "accumulation_m_we",
    "low",
    "high",
    "n_years",
    "confidence",
    "flag",
)


def accumulation(
    layers,
    density,
    *,
    year,
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
    density : float or snowsim.io.profiles.Profile
        Density of the snow [kg m-3], 50 to 917; or a profile of density, below whose end no pick is
        used.
    year : int or mapping of str to int
        Year of the first horizon below the surface, picked or not, or years of layers by name:
        ``{"snow_3": 2008}``. The snow of a year lies below the horizon of that year.
    temperature_k : float, optional
        Annual mean temperature of the firn. If given, `density` is that at the surface, below 550,
        and density grows with depth by Herron & Langway (1980), under the mean accumulation found
        here.
    density_error : float
        Relative standard deviation of the density.
    least_confidence : float
        Picks of lower confidence are not used.

    Returns
    -------
    xarray.Dataset
        Variables on (year, slow_time) are NaN where picks do not bound a year:

        - `depth_m` of the year's horizon and `thickness_m` of its snow;
        - `accumulation_m_we` [m w.e. / yr], and `low` and `high`, the limits that hold a year's own
          accumulation in nine of ten;
        - `n_years`, the number of years between the picks that bound it: thickness and accumulation
          are means over these years; and `confidence`, the probability of this number;
        - `flag`: 1 where that probability is below 80 %; 2 where this is so for a count higher up,
          from the surface on, which makes the age uncertain; 3 where both hold.

        `open_m_we` (slow_time) is the mass above the first horizon, not a whole year. `depth_at`
        (below_s) is the depth [m] at travel times below the surface. `attrs` hold `uppermost`, the
        horizon that is uppermost on most range lines, with its year, ``snow_2=2011``; `no_horizon`,
        names of layers that are taken for none; and `n_below_profile`, the number of picks below
        the end of a profile.

    Raises
    ------
    ValueError
        If the surface is missing, layers cross, a density is out of range, no range line has two
        horizons within the profile, or a name is no layer's.

    Notes
    -----
    The travel time to depth z below the mass w [m w.e.] is ``t = (2 / c) (z + 0.845 w)`` (Kovacs,
    Gow & Morey 1995). The number of years between two picks follows from their mass over the
    typical annual mass, a median along track and in depth: the mass of n years scatters by s
    n^(1/2), where s is the scatter of single years. Years are counted from the surface down, so
    that a pick in the tail of its echo is no horizon. A layer has one age along the whole track.
    Range lines on which different layers lie above it vote for this age, by their log-likelihood. A
    pick that is more probably no horizon is left out. Then all is repeated with the typical mass
    that these ages give. Where most picks are of crusts between horizons, half a year counts as
    one, and accumulation is halved without a flag: compare a core, or a layer of known age.

    The errors of both picks, each half of ``twtt_high - twtt_low``, of density, and of a year about
    the mean of m years, ``s (1 - 1 / m)^(1/2)``, add in squares; a relative error e of density
    counts as ``e / n`` with the refractive index n. Picks lie 1.2 to 1.6 range bins below their
    interface. This cancels in a year's mass, but not in `open_m_we`.
    """
    picks = _picks(layers, least_confidence)
    check_values("density_error", density_error, 0, 1)
    mean_m = FIRST_GUESS_M
    for _ in range(N_ROUNDS if temperature_k is not None else 1):
        column = _column(density, temperature_k, mean_m)
        dated = _dated(column.at(column.water_m, picks.below_s), picks, year)
        if not dated.whole.any():
            msg = "layers: expected two horizons on a range line above "
            msg += f"{column.depth_m[-1]:.4g} m, where density ends, found none"
            raise ValueError(msg)
        mean_m = float(np.nanmean(dated.year_m))
    return _by_year(layers, picks, column, dated, density_error)


def table(accumulated):
    """Table of `accumulation` for a GIS: a row for each range line and year that is not NaN."""
    along = {"slow_time": "time", "Latitude": "lat", "Longitude": "lon"}
    rows = accumulated.drop_dims("below_s").drop_vars("open_m_we").to_dataframe().reset_index()
    rows = rows.rename(columns=along).dropna(subset="accumulation_m_we")
    rows = rows.astype({"n_years": int, "flag": int}).sort_values(["time", "year"])
    first = [name for name in ("frame", *along.values(), "year") if name in rows]
    return rows[[*first, *COLUMNS]].reset_index(drop=True)


@dataclass(frozen=True, eq=False)
class _Picks:
    """The surface and the picks that are used, and the names of their layers.

    On (layer, range_line): `below_s` is the travel time below the surface, `error_s` its error, and
    `doubt` the probability that no layer lies there.
    """

    names: list
    below_s: np.ndarray
    error_s: np.ndarray
    doubt: np.ndarray


def _picks(layers, least_confidence):
    """`_Picks` of a dataset; layers without a pick are left out."""
    check_layers(layers)
    layers = layers.transpose("layer", "slow_time", ...)
    names = [str(name).rpartition(":")[2] for name in layers.get_index("layer")]
    twtt = layers["twtt"]
    if names[0] not in (SURFACE, "0") or not twtt[0].notnull().any() or len(names) < 2:
        msg = "layers: expected the surface first, with travel times, and others below it, "
        msg += f"found {', '.join(names)}"
        raise ValueError(msg)
    doubt = 1 - layers.get("confidence", 0 * twtt + USUAL_CONFIDENCE)
    error = (layers.get("twtt_high", twtt) - layers.get("twtt_low", twtt)) / 2
    below = (twtt - twtt[0]).where(doubt <= 1 - least_confidence)
    doubt = doubt.clip(LEAST_DOUBT)
    below[0], doubt[0] = 0, KNOWN_DOUBT
    kept = np.flatnonzero(below.notnull().any("slow_time"))
    values = (each.values[kept] for each in (below, error, doubt))
    return _Picks([names[n] for n in kept], *values)


@dataclass(frozen=True, eq=False)
class _Column:
    """Depth [m] and the mass above it [m w.e.], (sample,), down to where density is known."""

    depth_m: np.ndarray
    water_m: np.ndarray

    @property
    def twtt_s(self):
        """Two-way travel time to every depth [s]."""
        return travel_time_s(self.depth_m, self.water_m)

    def at(self, values, below_s):
        """Values (sample,) at travel times below the surface [s], NaN beyond the end."""
        return np.interp(below_s, self.twtt_s, values, right=np.nan)


def _column(density, temperature_k, mean_m):
    """`_Column` of snow of one density, of a profile, or of firn under a mean accumulation."""
    if hasattr(density, "density_kg_m3"):
        found = interfaces(density.depth_m, density.density_kg_m3, density.thickness_m)
        check_values("profile: density [kg m-3]", found.density_kg_m3, *DENSITIES_KG_M3)
        # The last sample extends as far below its middle as above it.
        depth_m = np.append(found.depth_m, 2 * density.depth_m[-1] - found.depth_m[-1])
        slab_m = found.density_kg_m3 * np.diff(depth_m) / WATER_DENSITY_KG_M3
        return _Column(depth_m, np.append(0, np.cumsum(slab_m)))
    check_values("density [kg m-3]", density, *DENSITIES_KG_M3, number=True)
    if temperature_k is None:
        depth_m = np.array([0, DEEPEST_M])
        return _Column(depth_m, depth_m * density / WATER_DENSITY_KG_M3)
    check_values("temperature_k", temperature_k, 200, 273.15, number=True)
    check_values("density of the surface [kg m-3]", density, 50, 549)
    # Samples are finest near the surface, where density changes fastest.
    water_m = np.linspace(0, np.sqrt(DEEPEST_WATER_M), 2000) ** 2
    return _Column(depth_herron_langway80(water_m, mean_m, temperature_k, density), water_m)


@dataclass(frozen=True, eq=False)
class _Dated:
    """Ages of horizons, and the spans between each and the next above it on the same range line.

    `newest` is the year of the first horizon; `age` (layer,) is how many years a layer is older, -1
    for the surface. On (layer, range_line): `above` is the layer that bounds a span from above, 0
    for the surface, -1 where there is none; `span_m` its mass [m w.e.], `n_years` its number of
    years and `sure` the probability of this number.
    """

    newest: int
    age: np.ndarray
    above: np.ndarray
    span_m: np.ndarray
    n_years: np.ndarray
    sure: np.ndarray

    @property
    def whole(self):
        """Whether a span lies between two horizons; below the surface lies no whole year."""
        return self.above > 0

    @property
    def year_m(self):
        """Mass of a year [m w.e.] (layer, range_line), NaN where a span is not whole."""
        return np.where(self.whole, self.span_m / self.n_years, np.nan)


def _dated(water_m, picks, year):
    """`_Dated` from the mass above picks (layer, range_line) [m w.e.]."""
    known = year if hasattr(year, "items") else {picks.names[0]: year + 1}
    given = {layer: known[name] for layer, name in enumerate(picks.names) if name in known}
    if not len(given) == len(known) > 0 or (np.diff(list(given.values())) >= 0).any():
        msg = f"year: expected names of layers with picks, {', '.join(picks.names)}, and years "
        msg += f"that fall from each to the next, found {known}"
        raise ValueError(msg)
    first, *_ = given
    doubt = picks.doubt.copy()
    doubt[list(given)] = KNOWN_DOUBT
    typical_m = _typical(np.diff(np.sort(water_m[1:], axis=0), axis=0))
    forced = {}
    for _ in range(N_ROUNDS):
        age, above = _vote(water_m / typical_m, doubt, forced)
        newest = int(given[first] + age[first])
        forced = {layer: newest - value for layer, value in given.items()}
        bounded = above >= 0
        span_m = np.where(bounded, water_m - np.take_along_axis(water_m, above, axis=0), np.nan)
        n_years = np.where(bounded, age[:, None] - age[above], np.nan)
        either = np.maximum(doubt, np.take_along_axis(doubt, above, axis=0))
        sure = _probability(span_m / typical_m, n_years, either)
        if 0 not in given:  # a named layer needs no count from the surface
            sure[above == 0] = 1
        dated = _Dated(newest, age, above, span_m, n_years, sure)
        typical_m = _typical(dated.year_m)
    return dated


def _typical(year_m):
    """Typical mass of a year (range_line,): the median of `year_m` in depth, then along track."""
    around = pd.DataFrame(year_m).median().rolling(2 * TYPICAL_LINES + 1, 1, center=True)
    return around.median().interpolate(limit_direction="both").to_numpy()


def _log_likelihood(ratio, n_years, doubt):
    """Log-likelihood of `n_years` between two picks, from their mass over that of a typical year.

    No years means that one of the picks is no horizon, which is likelier the larger `doubt`.
    """
    variance = np.maximum(n_years, 1) * SPREAD**2
    off = np.where(n_years == 0, np.maximum(ratio - 1, 0), ratio - n_years)
    odds = np.where(n_years == 0, np.log(NO_HORIZON * doubt), n_years * np.log(MISSED))
    return np.where(n_years < 0, IMPOSSIBLE, odds - off**2 / (2 * variance) - np.log(variance) / 2)


def _probability(ratio, n_years, doubt):
    """Probability of `n_years` between two picks, among up to two fewer and two more."""
    likelihood = [np.exp(_log_likelihood(ratio, n_years + more, doubt)) for more in range(-2, 3)]
    return likelihood[2] / sum(likelihood)


def _vote(years, doubt, forced):
    """Age of layers, and the layer above each pick, from the mass above it in typical years.

    Layers are dated from the surface down, by the mass since the last horizon on each range line.
    A layer of no horizon has the age of the one above it; it bounds no span.
    """
    age = np.full(len(years), -1.0)
    above = np.full(years.shape, -1)
    # On each range line: the last horizon, its age, and the mass above it in typical years.
    last = np.zeros(years.shape[1], dtype=int)
    last_age = np.full(last.size, -1.0)
    last_years = np.zeros(last.size)
    for layer, own in enumerate(years[1:], start=1):
        there = np.isfinite(own)
        if layer in forced:
            age[layer] = forced[layer]
        elif there.any():
            doubtful = np.median(doubt[layer, there])
            age[layer] = _elected((own - last_years)[there], last_age[there], doubtful)
        deeper = there & (age[layer] > last_age)
        above[layer, deeper] = last[deeper]
        last[deeper] = layer
        last_age[deeper] = age[layer]
        last_years[deeper] = own[deeper]
    return age, above


def _elected(ratio, upper_age, doubt):
    """Most probable age of a layer, from the ages above it and `ratio`, years of mass between."""
    ages = upper_age.min() + np.arange(np.ptp(upper_age) + MOST_YEARS + 1)
    likelihood = np.zeros(ages.size)
    for own in np.unique(upper_age):
        of_own = upper_age == own
        found = _log_likelihood(np.median(ratio[of_own]), ages - own, doubt)
        likelihood += of_own.mean() * found
    return ages[likelihood.argmax()]


def _by_year(layers, picks, column, dated, density_error):
    """Dataset of `accumulation`: each span is divided into equal years."""
    depth_m = column.at(column.depth_m, picks.below_s)
    layer, line = np.nonzero(dated.whole)
    upper = dated.above[layer, line]
    n_years = dated.n_years[layer, line].astype(int)
    thickness_m = depth_m[layer, line] - depth_m[upper, line]
    between_s = picks.below_s[layer, line] - picks.below_s[upper, line]
    index = SPEED_OF_LIGHT_M_S * between_s / (2 * thickness_m)
    of_picks = np.hypot(picks.error_s[layer, line], picks.error_s[upper, line]) / between_s
    # Of years that have one mean, each scatters about it.
    of_year = SPREAD * np.sqrt(1 - 1 / n_years)
    relative = np.hypot(of_picks, NINE_OF_TEN * np.hypot(density_error / index, of_year))
    mean_m = dated.span_m[layer, line] / n_years
    sure = dated.sure[layer, line]
    spans = {
        "line": line,
        "year": dated.newest - dated.age[upper].astype(int),
        "depth_m": depth_m[upper, line],
        "thickness_m": thickness_m / n_years,
        "accumulation_m_we": mean_m,
        "low": mean_m * np.maximum(1 - relative, 0),
        "high": mean_m * (1 + relative),
        "n_years": n_years,
        "confidence": sure,
        "flag": np.where(sure < LEAST_SURE, COUNT_UNCERTAIN, 0),
    }
    rows = pd.DataFrame(spans).loc[np.repeat(np.arange(line.size), n_years)]
    within = rows.groupby(level=0).cumcount()
    rows["year"] -= within
    rows["depth_m"] += within * rows["thickness_m"]
    found = _dataset(layers, rows, dated, column, picks.below_s)
    uppermost = (dated.above == 0).sum(axis=1).argmax()
    no_horizon = [picks.names[n] for n in np.flatnonzero((dated.above < 0).all(axis=1))[1:]]
    return found.assign_attrs(
        uppermost=f"{picks.names[uppermost]}={dated.newest - int(dated.age[uppermost])}",
        no_horizon=", ".join(no_horizon),
    )


def _dataset(layers, rows, dated, column, below_s):
    """Rows as a dataset on (year, slow_time), with positions and times of the layers."""
    years = np.arange(dated.newest, rows["year"].min() - 1, -1)
    found = rows.set_index(["year", "line"]).to_xarray()
    found = found.reindex(year=years, line=np.arange(below_s.shape[1]))
    found = found.rename(line="slow_time").assign_coords(slow_time=layers["slow_time"].values)
    # A doubtful count makes every deeper year's age uncertain.
    open_count = np.where(dated.above == 0, dated.sure, np.nan)
    open_count = np.fmin.reduce(open_count, axis=0) < LEAST_SURE
    doubt = np.vstack([open_count, found["flag"].values == COUNT_UNCERTAIN])
    found["flag"] += AGE_UNCERTAIN * np.logical_or.accumulate(doubt, axis=0)[:-1]
    water_m = column.at(column.water_m, below_s)
    first = (dated.above == 0) & (dated.age[:, None] == 0)
    found["open_m_we"] = ("slow_time", np.fmin.reduce(np.where(first, water_m, np.nan), axis=0))
    times_s = np.linspace(0, min(1.1 * np.nanmax(below_s), column.twtt_s[-1]), N_TIMES)
    found["depth_at"] = ("below_s", column.at(column.depth_m, times_s))
    for name in ("Latitude", "Longitude", "frame"):
        if name in layers:
            found[name] = ("slow_time", layers[name].values)
    n_below = int((np.isfinite(below_s) & np.isnan(water_m)).sum())
    return found.assign_coords(below_s=times_s).assign_attrs(n_below_profile=n_below)
