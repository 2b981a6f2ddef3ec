"""Agreement of the layers of two passes over the same snow, where no truth is known."""

import warnings
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr
from scipy.optimize import linear_sum_assignment

from snowsim.constants import KOVACS_M3_KG, SPEED_OF_LIGHT_M_S, WATER_DENSITY_KG_M3
from snowsim.limits import check_values
from snowsim.progress import with_progress
from snowsim.snowpack.column import DensityProfile
from snowsim.snowpack.meetings import Track, find_places, track_of
from snowsim.snowpack.snow import accumulation

# A layer counts at a place if it is picked on this share of the lines about it.
LEAST_PICKED = 0.5
# Snow of n years between two flights scatters about n typical years by this times n^(1/2), as
# years of cores do, and masses of the same layer differ by it. Half a year is the most by which
# they may: farther off, the next layer is nearer.
SCATTER_YEARS = 0.2
MOST_YEARS = 0.5
DAY = np.timedelta64(1, "D")
YEAR_DAYS = 365.25
# Unit and meaning of every variable.
ON_PLACE = {
    "first": ("1", "name of the first segment"),
    "second": ("1", "name of the second segment"),
    "meeting": ("1", "number of the crossing or overlap"),
    "kind": ("1", "crossing, or overlap: the tracks stay together"),
    "slow_time_first": (None, "time of the first segment's range line"),
    "slow_time_second": (None, "time of the second segment's range line"),
    "Latitude": ("degrees_north", "latitude of the first segment's range line"),
    "Longitude": ("degrees_east", "longitude of the first segment's range line"),
    "distance_m": ("m", "distance between both range lines"),
    "angle_deg": ("degrees", "angle between both directions of flight, 180 if they are opposite"),
    "length_m": ("m", "length of track over which the segments are near each other"),
    "days_between": ("days", "time of the second segment less that of the first"),
    "fallen_m_we": ("m", "mass of snow that fell in that time, taken off, in metres of water"),
    "n_first": ("1", "layers of the first segment in snow that both have layers in"),
    "n_second": ("1", "layers of the second segment in snow that both have layers in"),
    "n_matched": ("1", "layers of both that are one by their mass"),
    "share_matched": ("1", "share of these layers that are matched"),
    "depth_rms_m": ("m", "rms difference of depth of matched layers"),
    "depth_median_m": ("m", "median of depth in the second segment less that in the first"),
    "accumulation_rms_m_we": ("m", "rms difference of accumulation of years that both have"),
    "accumulation_median_m_we": ("m", "median of accumulation in the second less the first"),
    "offset_years": ("1", "most frequent difference of years of matched layers, second less first"),
    "share_same_year": ("1", "share of matched and dated layers that have the same year in both"),
}
ON_LAYER = {
    "layer_place": ("1", "number of the place"),
    "layer_first": ("1", "name of the layer in the first segment, empty if it has none"),
    "layer_second": ("1", "name of the layer in the second segment, empty if it has none"),
    "depth_first_m": ("m", "depth in the first segment, on the day of the earlier flight"),
    "depth_second_m": ("m", "depth in the second segment, on the day of the earlier flight"),
    "mass_first_m_we": ("m", "mass above in the first segment, on that day, in metres of water"),
    "mass_second_m_we": ("m", "mass above in the second segment, on that day, in metres of water"),
    "year_first": ("1", "year of the layer in the first segment"),
    "year_second": ("1", "year of the layer in the second segment"),
    "counted": ("1", "1 for layers in snow that both have layers in, else 0"),
}
ON_ANNUAL = {
    "annual_place": ("1", "number of the place"),
    "annual_year": ("1", "year"),
    "accumulation_first_m_we": ("m", "accumulation of the year in the first segment"),
    "accumulation_second_m_we": ("m", "accumulation of the year in the second segment"),
}
ON = {"place": ON_PLACE, "layer": ON_LAYER, "annual": ON_ANNUAL}


def agreement(
    segments: xr.Dataset | Iterable[xr.Dataset] | Mapping[str, xr.Dataset],
    density: float | DensityProfile | None = None,
    *,
    within_m: float = 50.0,
    tolerance_years: float = 0.25,
    **dating: Any,
) -> xr.Dataset:
    """Agreement of layers and accumulation where tracks cross or overlap, without any truth.

    Parameters
    ----------
    segments : xarray.Dataset, iterable of these, or mapping of str to xarray.Dataset
        Layers of segments, as `snowsim.io.open_segment` joins them, with `Latitude` and
        `Longitude`. In results they are named by their numbers 0, 1, ..., or as in the mapping.
    density : float or snowsim.io.profiles.Profile, optional
        As for `snowsim.accumulation`.
    within_m : float
        Range lines that lie within this distance of each other see the same snow [m].
    tolerance_years : float
        Largest difference in mass of matched layers, in years of accumulation, up to .5. For
        flights n years apart it is wider, by ``.2 n^(1/2)``, up to .5.
    **dating
        Other arguments of `snowsim.accumulation`, for all segments.

    Returns
    -------
    xarray.Dataset
        Variables have units and long names. On `place`: names of both segments, the crossing or
        overlap, times, position, distance, angle and days between the flights, number of layers
        and matched layers, differences of depth and annual accumulation, and `offset_years`, the
        most frequent difference of the years of matched layers: if it is not 0, years were
        miscounted in one of the two. Differences are those of the second segment less the first.
        On `layer`: every layer at every place, matched or not. On `annual`: accumulation of every
        year that both segments have.

    Raises
    ------
    ValueError
        In one line, if no tracks meet, range lines have no position or are farther apart than
        `within_m`, or `snowsim.accumulation` refuses one of any two segments that meet. Others that
        it refuses are left out, with a warning.

    Notes
    -----
    A crossing has one place, where the tracks are nearest. Tracks overlap if they stay together
    for more than 20 times `within_m`; an overlap has a place in every such length. Two parts of
    one track meet, too, if more than 10 times `within_m` of track lies between them.

    At a place a layer has its median depth and mass over the lines within `within_m` along track,
    if half of them have a pick. Snow that fell between both flights is taken off the later one:
    median accumulation there times the years between them, under the same density. Layers are
    matched one to one by the mass above them: the sum of squared differences is least, where a
    layer without a partner counts as the tolerance. Layers in fallen snow, and layers deeper than
    the deepest of the other segment by more than the tolerance, are not counted.
    ``share_matched = 2 n_matched / (n_first + n_second)``.

    Examples
    --------
    >>> import numpy as np
    >>> from snowsim import Climate, simulate
    >>> _, layers = simulate(Climate(accumulation_m=0.4), "snow-2012", n_range_lines=400, rng=1)
    >>> again = layers.assign(twtt=layers["twtt"] + 1e-9 * (layers["twtt"] > layers["twtt"][0]))
    >>> found = agreement([layers, again], temperature_k=243)  # layers 1 ns deeper, some 11 cm
    >>> str(found["kind"][0].values), found["share_matched"].values.round(2)
    ('overlap', array([1., 1.]))
    >>> found["depth_median_m"].values.round(2), found["offset_years"].values
    (array([0.11, 0.11]), array([0., 0.]))
    """
    check_values("within_m", within_m, 0, above=True, number=True)
    check_values("tolerance_years", tolerance_years, 0, MOST_YEARS, above=True, number=True)
    if isinstance(segments, xr.Dataset):
        segments = [segments]  # whose track may meet itself
    if not isinstance(segments, Mapping):
        segments = {str(number): layers for number, layers in enumerate(segments)}
    tracks = {name: _checked_track(layers, name, within_m) for name, layers in segments.items()}
    places = find_places(list(tracks.values()), within_m) if tracks else []
    if not places:
        msg = (
            f"agreement: expected tracks that meet within {within_m:g} m, or one that crosses "
            f"itself, found none among {len(tracks)} segments: within_m widens the search"
        )
        raise ValueError(msg)
    names = list(tracks)
    met = {names[number] for place in places for number in (place.first, place.second)}
    met = {name: (segments[name], tracks[name]) for name in names if name in met}
    passes, left_out = _dated(met, density, dating)
    rows = {"place": [], "layer": [], "annual": []}
    for place in places:
        pair = [names[number] for number in (place.first, place.second)]
        if not {*pair} <= {*passes}:
            continue
        compared = _compare(place, *(passes[name] for name in pair), within_m, tolerance_years)
        number = len(rows["place"])
        own = {"first": pair[0], "second": pair[1]} | compared.summary
        rows["place"].append(pd.DataFrame([own]))
        rows["layer"].append(compared.layers.assign(layer_place=number))
        rows["annual"].append(compared.annual.assign(annual_place=number))
    if not rows["place"]:
        raise ValueError(left_out[0])
    for text in left_out:
        warnings.warn(text, stacklevel=2)
    _warn_of_copies(rows)
    return _dataset(rows).assign_attrs(within_m=within_m, tolerance_years=tolerance_years)


def _warn_of_copies(rows):
    """Warn of places where a segment and its copy meet, by tables of places and of their layers."""
    copies = set()
    for place, layers in zip(rows["place"], rows["layer"], strict=True):
        (own,) = place.to_dict("records")
        depths_m = layers[["depth_first_m", "depth_second_m"]].dropna().to_numpy()
        n_equal = (depths_m[:, 0] == depths_m[:, 1]).sum()
        if own["days_between"] == 0 and n_equal > len(depths_m) / 2:
            copies.add(f"{own['first']} and {own['second']}")
    if copies:
        warnings.warn(
            f"segments {', '.join(sorted(copies))}: most layers have equal times and depths: one "
            "pass and its copy agree with themselves",
            stacklevel=3,
        )


def _checked_track(layers, name, within_m):
    """`Track` of a segment; ValueError, which names it, if its lines cannot meet others."""
    if not isinstance(layers, xr.Dataset):
        kind = type(layers).__name__
        msg = f"segment {name}: expected layers as an xarray.Dataset, got {kind}"
        raise ValueError(msg)
    try:
        track = track_of(layers)
    except ValueError as error:
        msg = f"segment {name}: {error}"
        raise ValueError(msg) from error
    spacing_m = np.median(np.diff(track.along_m)) if track.line.size > 1 else 0.0
    if spacing_m > within_m:
        msg = (
            f"segment {name}: expected range lines at most within_m, {within_m:g} m, apart, so "
            f"that no crossing lies between them, found {spacing_m:.4g} m: give a larger within_m"
        )
        raise ValueError(msg)
    return track


@dataclass(frozen=True, eq=False)
class _Pass:
    """Result of `accumulation` for a segment, as arrays, and its track.

    `depth_m` and `water_m`, the mass above, are (layer, range_line) without the surface, `names`
    and `year` (layer,), `yearly_m` (calendar year, range_line) the accumulation.
    """

    track: Track
    time: np.ndarray
    position: np.ndarray
    names: np.ndarray
    year: np.ndarray
    depth_m: np.ndarray
    water_m: np.ndarray
    calendar: np.ndarray
    yearly_m: np.ndarray
    typical_m: float
    depth_at: xr.DataArray

    def depth_below(self, mass_m):
        """Depths [m] above which masses of snow lie [m w.e.], an array of their shape."""
        # Of t = (2 / c) (z + .845 w), Kovacs et al. (1995).
        optical_m = SPEED_OF_LIGHT_M_S / 2 * self.depth_at["below_s"].values
        water_m = (optical_m - self.depth_at.values) / (KOVACS_M3_KG * WATER_DENSITY_KG_M3)
        return np.interp(mass_m, water_m, self.depth_at.values)


def _dated(segments, density, dating):
    """`_Pass` of segments by name, from their layers and tracks, and lines on those left out.

    Left out are segments that `accumulation` refuses.
    """
    passes = {}
    left_out = []
    for name, (layers, track) in with_progress(segments.items(), unit="segment"):
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always", UserWarning)
            try:
                passes[name] = _pass_of(layers, track, accumulation(layers, density, **dating))
            except ValueError as error:
                left_out.append(f"segment {name} is left out: {error}")
        for warning in caught:
            warnings.warn(f"segment {name}: {warning.message}", warning.category, stacklevel=3)
    return passes, left_out


def _pass_of(layers, track, found):
    """`_Pass` of a segment from its `accumulation`."""
    on_layer = found[["layer_depth_m", "layer_m_we", "layer_year"]].isel(layer=slice(1, None))
    by_line = on_layer.transpose("layer", "slow_time")
    return _Pass(
        track=track,
        time=layers["slow_time"].values,
        position=np.stack([layers["Latitude"].values, layers["Longitude"].values]),
        names=by_line["layer"].values,
        year=by_line["layer_year"].values,
        depth_m=by_line["layer_depth_m"].values,
        water_m=by_line["layer_m_we"].values,
        calendar=found["year"].values,
        yearly_m=found["accumulation_m_we"].transpose("year", "slow_time").values,
        typical_m=found.attrs["typical_m"],
        depth_at=found["depth_at"],
    )


@dataclass(frozen=True, eq=False)
class _Profile:
    """Layers below a place, (layer,), from the uppermost down, and its accumulation by year."""

    names: np.ndarray
    year: np.ndarray
    depth_m: np.ndarray
    water_m: np.ndarray
    accumulation_m: pd.Series

    @classmethod
    def of(cls, own, index, within_m):
        """Profile of a `_Pass` about one of the lines of its track: medians along track."""
        lines = own.track.line[own.track.lines_about(index, within_m)]
        water_m = _median_of_picked(own.water_m[:, lines])
        order = np.argsort(water_m)[: np.isfinite(water_m).sum()]  # NaN comes last
        depth_m = _median_of_picked(own.depth_m[:, lines])
        yearly_m = _median_of_picked(own.yearly_m[:, lines])
        return cls(
            names=own.names[order],
            year=own.year[order],
            depth_m=depth_m[order],
            water_m=water_m[order],
            accumulation_m=pd.Series(yearly_m, own.calendar).dropna(),
        )

    def before(self, fallen_m, own):
        """The profile without a mass of snow that fell last, of its own `_Pass` [m w.e.]."""
        # Density is the same at equal mass above, so that depth changes with the mass.
        water_m = self.water_m - fallen_m
        own_m = own.depth_below(self.water_m)
        deeper_m = np.where(
            water_m > 0, own_m - own.depth_below(np.maximum(water_m, 0)), own.depth_below(fallen_m)
        )
        return replace(self, water_m=water_m, depth_m=self.depth_m - deeper_m)


def _median_of_picked(values):
    """Median of values (row, range_line) along track, NaN for rows with too few, (row,)."""
    is_picked = np.isfinite(values).mean(axis=1) >= LEAST_PICKED
    medians = np.full(len(values), np.nan)
    medians[is_picked] = np.nanmedian(values[is_picked], axis=1)
    return medians


@dataclass(frozen=True, eq=False)
class _Compared:
    """Rows of a place: the place itself, its layers, and years that both segments have."""

    summary: dict
    layers: pd.DataFrame
    annual: pd.DataFrame


def _compare(place, first, second, within_m, tolerance_years):
    """`_Compared` of two `_Pass`es at a `Place`."""
    profiles = [
        _Profile.of(own, index, within_m)
        for own, index in ((first, place.index_first), (second, place.index_second))
    ]
    rates_m = [
        own.accumulation_m.median() if own.accumulation_m.size else each.typical_m
        for own, each in zip(profiles, (first, second), strict=True)
    ]
    rate_m = np.mean(rates_m)
    lines = (first.track.line[place.index_first], second.track.line[place.index_second])
    times = (first.time[lines[0]], second.time[lines[1]])
    days = (times[1] - times[0]) / DAY
    years = abs(days) / YEAR_DAYS
    later = int(days > 0)
    profiles[later] = profiles[later].before(rate_m * years, (first, second)[later])
    widened_years = tolerance_years + SCATTER_YEARS * np.sqrt(years)
    layers = _matched(*profiles, rate_m * min(widened_years, MOST_YEARS))
    annual = pd.concat([own.accumulation_m for own in profiles], axis=1, join="inner")
    annual.columns = ["accumulation_first_m_we", "accumulation_second_m_we"]
    annual = annual.rename_axis("annual_year").reset_index()
    latitude, longitude = first.position[:, lines[0]]
    summary = {
        "meeting": place.meeting,
        "kind": "overlap" if place.is_overlap else "crossing",
        "slow_time_first": times[0],
        "slow_time_second": times[1],
        "Latitude": latitude,
        "Longitude": longitude,
        "distance_m": place.distance_m,
        "angle_deg": place.angle_deg,
        "length_m": place.length_m,
        "days_between": days,
        "fallen_m_we": rate_m * years,
    }
    return _Compared(summary | figures(layers, annual), layers, annual)


def _matched(first, second, tolerance_m):
    """Table of the layers of two `_Profile`s: a row for each match and each layer without one.

    The assignment has the least sum of squared differences of mass; a layer without a partner
    counts as `tolerance_m` [m w.e.]. Squares keep the order of layers.
    """
    both = (first, second)
    shallower_m = min(own.water_m.max(initial=0) for own in both)
    deepest_m = shallower_m + tolerance_m if shallower_m > 0 else 0
    is_counted = [(own.water_m > 0) & (own.water_m <= deepest_m) for own in both]
    away = np.abs(first.water_m[:, None] - second.water_m) / tolerance_m
    away[~(is_counted[0][:, None] & is_counted[1])] = 1
    upper, lower = linear_sum_assignment(np.minimum(away, 1) ** 2)
    is_match = away[upper, lower] < 1
    matches = (upper[is_match], lower[is_match])
    alone = [
        np.setdiff1d(np.arange(own.water_m.size), used)
        for own, used in zip(both, matches, strict=True)
    ]
    n_alone = [own.size for own in alone]
    # -1 stands for a layer that the segment does not have.
    rows_first = np.concatenate([matches[0], alone[0], np.full(n_alone[1], -1)])
    rows_second = np.concatenate([matches[1], np.full(n_alone[0], -1), alone[1]])
    table = {}
    for rows, which, own, counted in (
        (rows_first, "first", first, is_counted[0]),
        (rows_second, "second", second, is_counted[1]),
    ):
        table |= {
            f"layer_{which}": np.append(own.names.astype(object), "")[rows],
            f"depth_{which}_m": np.append(own.depth_m, np.nan)[rows],
            f"mass_{which}_m_we": np.append(own.water_m, np.nan)[rows],
            f"year_{which}": np.append(own.year, np.nan)[rows],
            f"counted_{which}": np.append(counted, False)[rows],
        }
    table = pd.DataFrame(table)
    counted = table.pop("counted_first") | table.pop("counted_second")
    masses = table[["mass_first_m_we", "mass_second_m_we"]].mean(axis=1)
    return table.assign(counted=counted.astype(np.int8)).iloc[np.argsort(masses, kind="stable")]


def figures(layers, annual):
    """Figures of agreement, by name, of tables of layers and years at one place or at many."""
    layers = layers[layers["counted"] == 1]
    is_there = layers[["depth_first_m", "depth_second_m"]].notna()
    n_first, n_second = is_there.sum()
    deeper_m = (layers["depth_second_m"] - layers["depth_first_m"]).dropna()
    years_off = (layers["year_second"] - layers["year_first"]).dropna()
    more_m = annual["accumulation_second_m_we"] - annual["accumulation_first_m_we"]
    n_layers = n_first + n_second
    return {
        "n_first": int(n_first),
        "n_second": int(n_second),
        "n_matched": deeper_m.size,
        "share_matched": 2 * deeper_m.size / n_layers if n_layers else np.nan,
        "depth_rms_m": np.sqrt((deeper_m**2).mean()),
        "depth_median_m": deeper_m.median(),
        "accumulation_rms_m_we": np.sqrt((more_m**2).mean()),
        "accumulation_median_m_we": more_m.median(),
        "offset_years": _most_frequent(years_off),
        "share_same_year": (years_off == 0).mean() if years_off.size else np.nan,
    }


def _most_frequent(values):
    """The most frequent of some numbers, the one nearest to 0 of several, NaN of none."""
    counts = values.value_counts()
    candidates = counts.index[counts == counts.max()]
    return min(candidates, key=abs, default=np.nan)


def _dataset(rows):
    """Dataset of `agreement`, from lists of tables by the dimension of their rows."""
    variables = {}
    for on, tables in rows.items():
        table = pd.concat(tables, ignore_index=True)
        for name, (units, meaning) in ON[on].items():
            attributes = {"long_name": meaning} | ({"units": units} if units else {})
            variables[name] = (on, table[name].to_numpy(), attributes)
    return xr.Dataset(variables)


def agreement_table(found):
    """Table of `agreement` with a row for each place."""
    along = {"Latitude": "lat", "Longitude": "lon"}
    along |= {f"slow_time_{which}": f"time_{which}" for which in ("first", "second")}
    return found[list(ON_PLACE)].to_dataframe().rename(columns=along).reset_index(drop=True)


def agreement_summary(found):
    """Table of `agreement` by pair of segments, and in its last row of all pairs.

    Figures are those of all layers and years together. `n_compared` is the number of places where
    both segments have layers, `n_offset` the number of places whose `offset_years` is not 0.
    """
    places = found[list(ON_PLACE)].to_dataframe()
    layers = found[list(ON_LAYER)].to_dataframe()
    annual = found[list(ON_ANNUAL)].to_dataframe()
    pairs = list(places.groupby(["first", "second"], sort=False))
    rows = []
    for pair, own in [*pairs, (("all", ""), places)]:
        meetings = own.drop_duplicates("meeting")
        offset = own["offset_years"].dropna()
        rows.append(
            {
                "first": pair[0],
                "second": pair[1],
                "n_crossings": int((meetings["kind"] == "crossing").sum()),
                "n_overlaps": int((meetings["kind"] == "overlap").sum()),
                "n_places": len(own),
                "n_compared": int(own["share_matched"].notna().sum()),
                "n_offset": int((offset != 0).sum()),
            }
            | figures(
                layers[layers["layer_place"].isin(own.index)],
                annual[annual["annual_place"].isin(own.index)],
            )
        )
    return pd.DataFrame(rows)
