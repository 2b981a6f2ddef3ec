"""Tables of accumulation: by range line and year for a GIS, and by year for a paper."""

import numpy as np
import pandas as pd

from snowsim.alignment import along_track_m
from snowsim.constants import KILOMETRE

PIECE_M = 500.0  # length of a line on a map
# Columns of the table for a GIS that follow frame, time, position and year.
TABLE_COLUMNS = (
    "depth_m",
    "thickness_m",
    "accumulation_m_we",
    "low",
    "high",
    "year_confidence",
    "age_low",
    "age_high",
    "n_years",
    "flag",
    "open_m_we",
)
# Columns of the table by year that are means along track.
MEAN_COLUMNS = (
    "accumulation_m_we",
    "low",
    "high",
    "error_picks",
    "error_density",
    "year_confidence",
)


def table(accumulated):
    """Table of `accumulation` for a GIS, with a row for each range line and year that is not NaN.

    If nothing is dated, there is a row for each range line and layer: the layer's depth, and the
    thickness and mass [m w.e.] from there down to the next layer.
    """
    along = {"slow_time": "time", "Latitude": "lat", "Longitude": "lon"}
    if accumulated.sizes["year"] == 0:
        return _undated(accumulated, along)
    rows = accumulated.drop_dims(["below_s", "layer"]).to_dataframe().reset_index()
    rows = rows.rename(columns=along).dropna(subset="accumulation_m_we")
    whole = dict.fromkeys(("age_low", "age_high", "n_years", "flag"), int)
    rows = rows.astype(whole).sort_values(["time", "year"])
    first = [name for name in ("frame", *along.values(), "year") if name in rows]
    return rows[[*first, *TABLE_COLUMNS]].reset_index(drop=True)


def _undated(accumulated, along):
    """Table by range line and layer, if nothing is dated."""
    held = [name for name in ("frame", *along) if name in accumulated]
    names = {"layer_depth_m": "depth_m", "layer_m_we": "mass_m_we"}
    rows = accumulated[[*names, *held]].to_dataframe().reset_index().rename(columns=names | along)
    rows = rows.dropna(subset="depth_m").sort_values(["time", "depth_m"])
    below = rows.groupby("time")[["depth_m", "mass_m_we"]].diff(-1)
    rows["thickness_m"], rows["mass_m_we"] = -below["depth_m"], -below["mass_m_we"]
    rows = rows.dropna(subset="thickness_m").rename(columns={"layer": "name"})
    first = [name for name in ("frame", *along.values()) if name in rows]
    return rows[[*first, "name", "depth_m", "thickness_m", "mass_m_we"]].reset_index(drop=True)


def pieces(rows):
    """Means of a `table` over pieces of track for a map, with a row for each year and 500 m.

    `line` lists longitude and latitude of a piece's range lines; longitudes go on past 180 degrees.
    Times, and range lines without a position, are left out. ValueError if nothing is dated or no
    range line has a position.
    """
    if "year" not in rows:
        msg = "a map needs years, nothing is dated: write a table or NetCDF"
        raise ValueError(msg)
    if not {"lat", "lon"} <= set(rows) or rows["lat"].isna().all():
        msg = "a map needs Latitude and Longitude of range lines, the layers have none"
        raise ValueError(msg)
    rows = rows.dropna(subset=["lat", "lon"])
    positions = rows[["time", "lat", "lon"]].drop_duplicates()
    along = positions.rename(columns={"lat": "Latitude", "lon": "Longitude"}).set_index("time")
    distance_m = pd.Series(along_track_m(along), along.index)
    rows = rows.assign(piece=rows["time"].map(distance_m) // PIECE_M)
    of_piece = rows.groupby(["year", "piece"])
    means = of_piece[list(TABLE_COLUMNS)].mean()
    means["line"] = of_piece[["lon", "lat"]].apply(
        lambda own: np.unwrap(own.to_numpy(), period=360, axis=0)
    )
    return means.reset_index()


def by_year(accumulated):
    """Table of `accumulation` by year: means along track, their errors, and their support.

    Limits `low` and `high`, and both errors, hold nine of ten cases [m w.e. / yr]. The error of
    picks falls with the number of kilometres, `independent_km`; that of density does not. `flagged`
    is the share of range lines with a flag.
    """
    given = accumulated["accumulation_m_we"].notnull()
    n_km = np.ones(given.sizes["year"])
    if {"Latitude", "Longitude"} <= set(accumulated):
        # Errors of picks within a kilometre of track count as one.
        kilometre = np.floor(along_track_m(accumulated) / KILOMETRE)
        n_km = [max(pd.Series(kilometre[lines]).nunique(), 1) for lines in given.values]
    means = {name: accumulated[name].mean("slow_time").values for name in MEAN_COLUMNS}
    means["flagged"] = accumulated["flag"].mean("slow_time").values
    means["error_picks"] = means["error_picks"] / np.sqrt(n_km)
    rows = pd.DataFrame({"year": accumulated["year"], **means, "independent_km": n_km})
    return rows.dropna(subset="accumulation_m_we").reset_index(drop=True)
