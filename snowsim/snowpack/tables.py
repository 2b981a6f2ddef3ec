"""Accumulation as tables: of range lines and years for a GIS, and of years for a paper."""

import numpy as np
import pandas as pd

from snowsim.alignment import along_track_m
from snowsim.constants import KILOMETRE

PIECE_M = 500.0  # length of a line on a map
# Columns of the table for a GIS, after frame, time, position and year.
COLUMNS = (
    "depth_m",
    "thickness_m",
    "accumulation_m_we",
    "low",
    "high",
    "n_years",
    "confidence",
    "age_error_years",
    "flag",
    "open_m_we",
)


def table(accumulated):
    """Table of `accumulation` for a GIS: a row for each range line and year that is not NaN."""
    along = {"slow_time": "time", "Latitude": "lat", "Longitude": "lon"}
    rows = accumulated.drop_dims("below_s").to_dataframe().reset_index()
    rows = rows.rename(columns=along).dropna(subset="accumulation_m_we")
    rows = rows.astype({"n_years": int, "flag": int}).sort_values(["time", "year"])
    first = [name for name in ("frame", *along.values(), "year") if name in rows]
    return rows[[*first, *COLUMNS]].reset_index(drop=True)


def pieces(rows):
    """Means of a `table` over pieces of track for a map: a row for each year and 500 m.

    `line` is the list of longitude and latitude of its range lines, on past 180 degrees; times are
    left out, and range lines without a position. ValueError if none has one.
    """
    if not {"lat", "lon"} <= set(rows) or rows["lat"].isna().all():
        msg = "a map needs Latitude and Longitude of range lines, the layers have none"
        raise ValueError(msg)
    rows = rows.dropna(subset=["lat", "lon"])
    positions = rows[["time", "lat", "lon"]].drop_duplicates()
    along = positions.rename(columns={"lat": "Latitude", "lon": "Longitude"}).set_index("time")
    distance_m = pd.Series(along_track_m(along), along.index)
    rows = rows.assign(piece=rows["time"].map(distance_m) // PIECE_M)
    of_piece = rows.groupby(["year", "piece"])
    means = of_piece[list(COLUMNS)].mean()
    means["line"] = of_piece[["lon", "lat"]].apply(
        lambda own: np.unwrap(own.to_numpy(), period=360, axis=0)
    )
    return means.reset_index()


def by_year(accumulated):
    """Table of `accumulation` by year: means along the track, their errors and support.

    Errors hold nine of ten [m w.e. / yr]. That of picks falls with the number of `independent_km`,
    that of density does not; that of counting is what a year more or less between two picks would
    change, times its probability. `flagged` is the share of range lines with a flag.
    """
    given = accumulated["accumulation_m_we"].notnull()
    n_km = np.ones(given.sizes["year"])
    if {"Latitude", "Longitude"} <= set(accumulated):
        # Over a kilometre of track accumulation is taken as one value.
        kilometre = np.floor(along_track_m(accumulated) / KILOMETRE)
        n_km = [max(pd.Series(kilometre[lines]).nunique(), 1) for lines in given.values]
    doubt = (1 - accumulated["confidence"]) / accumulated["n_years"]
    columns = {
        "accumulation_m_we": accumulated["accumulation_m_we"],
        "error_picks": accumulated["error_picks"],
        "error_density": accumulated["error_density"],
        "error_counting": accumulated["accumulation_m_we"] * doubt,
        "age_error_years": accumulated["age_error_years"],
        "flagged": accumulated["flag"],
    }
    means = {name: column.mean("slow_time").values for name, column in columns.items()}
    means["error_picks"] = means["error_picks"] / np.sqrt(n_km)
    rows = pd.DataFrame({"year": accumulated["year"], **means, "independent_km": n_km})
    return rows.dropna(subset="accumulation_m_we").reset_index(drop=True)
