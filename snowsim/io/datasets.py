"""Plain arrays to the Open Polar Radar datasets, and the checks both pass on the way out.

GPS and UTC seconds of the archives' files to UTC datetime64.
Elevation compensation as the archives store it, undone: every trace back to the travel times it was recorded at.
"""

import numpy as np
import xarray as xr

from snowsim.constants import SPEED_OF_LIGHT_M_S
from snowsim.echogram import check_echogram, check_layers
from snowsim.io.guard import check_size, refusal

UNITS = {
    "Data": "W (uncalibrated)",
    "Latitude": "degrees_north",
    "Longitude": "degrees_east",
    "Elevation": "m",
    "Surface": "s",
    "Bottom": "s",
    "Roll": "radian",
    "Pitch": "radian",
    "Heading": "radian",
    "twtt": "s",
}
RANGES = {"Latitude": 90, "Longitude": 360}


def echogram_dataset(path, content, attributes):
    """Echogram dataset of `Data` (range_bin, range_line), `twtt`, `slow_time` and values along slow_time; checked."""
    along_track = {name: v for name, v in content.items() if name not in ("Data", "twtt", "slow_time")}
    dataset = xr.Dataset(
        {
            "Data": (("twtt", "slow_time"), content["Data"], {"units": UNITS["Data"]}),
            **{
                name: v if isinstance(v, tuple) else ("slow_time", v, {"units": UNITS[name]})
                for name, v in along_track.items()
            },
        },
        coords={"twtt": ("twtt", content["twtt"], {"units": "s"}), "slow_time": content["slow_time"]},
        attrs={name: value for name, value in attributes.items() if value is not None},
    )
    return checked_echogram(path, dataset)


def checked_echogram(path, dataset):
    """The dataset, if it passes the validator and stays on Earth."""
    check_echogram(dataset, str(path))
    for name, largest in RANGES.items():
        outside = np.abs(dataset[name].values) > largest  # NaN, where the position is unknown, is not outside
        if outside.any():
            found = f"{dataset[name].values[outside][0]:g} at range_line {int(np.argmax(outside))}"
            raise refusal(path, name, f"degrees within +-{largest}", found)
    return dataset


def layers_dataset(path, content, attributes):
    """Layers dataset of `twtt`, `quality`, `type` (layer, slow_time), names and positions along slow_time; checked."""
    along_track = {name: content[name] for name in ("Latitude", "Longitude", "Elevation") if name in content}
    dataset = xr.Dataset(
        {
            "twtt": (("layer", "slow_time"), content["twtt"], {"units": "s"}),
            "quality": (("layer", "slow_time"), content["quality"], {"flag_values": "1 good, 2 moderate, 3 bad"}),
            "type": (("layer", "slow_time"), content["type"], {"flag_values": "1 manual, 2 automatic"}),
            **{name: ("slow_time", values, {"units": UNITS[name]}) for name, values in along_track.items()},
        },
        coords={
            "slow_time": content["slow_time"],
            "layer": ("layer", np.asarray(content["names"], dtype=str)),
            "group": ("layer", np.asarray(content["groups"], dtype=str)),
        },
        attrs={name: value for name, value in attributes.items() if value is not None},
    )
    check_layers(dataset, str(path))
    return dataset


# GPS - UTC [s] from each date on: Bulletin C of the International Earth Rotation and Reference Systems Service.
LEAP_SECONDS = (
    ("1980-01-06", 0),
    ("1981-07-01", 1),
    ("1982-07-01", 2),
    ("1983-07-01", 3),
    ("1985-07-01", 4),
    ("1988-01-01", 5),
    ("1990-01-01", 6),
    ("1991-01-01", 7),
    ("1992-07-01", 8),
    ("1993-07-01", 9),
    ("1994-07-01", 10),
    ("1996-01-01", 11),
    ("1997-07-01", 12),
    ("1999-01-01", 13),
    ("2006-01-01", 14),
    ("2009-01-01", 15),
    ("2012-07-01", 16),
    ("2015-07-01", 17),
    ("2017-01-01", 18),
)
LAST_YEAR = 2100
SECONDS_OF_DAY = 86400


def leap_seconds(gps_seconds):
    """GPS minus UTC [s] at a time given in GPS seconds since 1970-01-01 (leap seconds not removed)."""
    offset = 0
    for date, seconds in LEAP_SECONDS:
        if gps_seconds >= np.datetime64(date, "s").astype(np.int64) + seconds:
            offset = seconds
    return offset


def from_utc_seconds(path, what, seconds, epoch="1970-01-01"):
    """UTC seconds since a date as datetime64[ns], (range_line,); ValueError where not finite or out of this age."""
    seconds = np.asarray(seconds, dtype=float)
    since = np.datetime64(epoch, "s").astype(np.int64)
    first = np.datetime64(LEAP_SECONDS[0][0], "s").astype(np.int64)
    last = np.datetime64(f"{LAST_YEAR}-01-01", "s").astype(np.int64)
    # Written so that NaN fails too.
    bad = ~((seconds + since >= first) & (seconds + since < last))
    if seconds.size == 0 or bad.any():
        found = "none" if seconds.size == 0 else f"{seconds[bad][0]:g} at range_line {int(np.argmax(bad))}"
        raise refusal(path, what, f"seconds since {epoch} that fall in 1980 to {LAST_YEAR}", found)
    whole = np.floor(seconds)
    nanoseconds = np.rint((seconds - whole) * 1e9).astype(np.int64)
    return ((whole.astype(np.int64) + since) * 1_000_000_000 + nanoseconds).view("datetime64[ns]")


def from_gps_seconds(path, what, seconds):
    """GPS seconds since 1970 as UTC datetime64[ns], (range_line,).

    One offset holds for a whole file, that of its first line, as in the archive's own conversion to NetCDF: a frame
    flown over a leap second stays in order.
    """
    seconds = np.asarray(seconds, dtype=float)
    finite = seconds[np.isfinite(seconds)]
    if finite.size == 0:
        raise refusal(path, what, "GPS seconds since 1970", f"no finite value among {seconds.size}")
    return from_utc_seconds(path, what, seconds - leap_seconds(finite[0]))


def unwrap_midnight(seconds_of_day):
    """Seconds of day that fall back by more than half a day are taken to have passed midnight, and go on.

    Returns
    -------
    seconds : ndarray
    n_crossings : int
    """
    seconds_of_day = np.asarray(seconds_of_day, dtype=float)
    wrapped = np.concatenate([[False], np.diff(seconds_of_day) < -SECONDS_OF_DAY / 2])
    return seconds_of_day + SECONDS_OF_DAY * np.cumsum(wrapped), int(wrapped.sum())


def undo_compensation(path, content, correction_bins, first_bin=None, n_recorded=None):
    """Shift every trace back by the bins that were inserted above it.

    Parameters
    ----------
    path : path_like
        For the message of a refusal.
    content : dict
        `Data` (range_bin, range_line) linear power, `twtt` (range_bin,) [s], `Elevation` [m], `Surface` and perhaps
        `Bottom` (range_line,) [s].
    correction_bins : array_like, (range_line,)
        `Elevation_Correction`: bins inserted above each trace to simulate level flight; whole, not negative.
    first_bin : int, optional
        Index, from 0, of the first kept row on the compensated travel-time axis (`Truncate_Bins`).
    n_recorded : int, optional
        Bins of a trace as recorded; where known, rows padded below it count as missing.

    Returns
    -------
    dict
        As `content`, with ``max(correction_bins)`` rows more; NaN where nothing was recorded.

    Notes
    -----
    ``twtt -= EC dt``, ``Surface -= EC dt``, ``Elevation -= EC dt c / 2``: the inverse of the CReSIS toolbox's
    compression, in which inserted bins hold zero power. They are NaN here, so that no zero passes for a measurement.
    """
    data, twtt = content["Data"], content["twtt"]
    correction_bins = np.asarray(correction_bins, dtype=float)
    whole = np.isfinite(correction_bins) & (correction_bins >= 0) & (correction_bins == np.floor(correction_bins))
    if not whole.all():
        found = f"{correction_bins[~whole][0]:g} at range_line {int(np.argmin(whole))}"
        raise refusal(path, "Elevation_Correction", "whole numbers of bins, not negative", found)
    n_rows, n_lines = data.shape
    n_extra = int(correction_bins.max(initial=0))
    check_size(path, "Elevation_Correction", (n_rows + n_extra, n_lines), data.dtype.itemsize)
    correction_bins = correction_bins.astype(int)

    shifted = np.full((n_rows + n_extra, n_lines), np.nan, dtype=data.dtype if data.dtype.kind == "f" else float)
    for line, bins in enumerate(correction_bins):
        start = 0 if first_bin is None else max(0, bins - first_bin)
        stop = n_rows if n_recorded is None else max(start, min(n_rows, n_recorded + bins - (first_bin or 0)))
        top = n_extra - bins
        shifted[top + start : top + stop, line] = data[start:stop, line]
    bin_size = (twtt[-1] - twtt[0]) / (twtt.size - 1)
    undone = {**content, "Data": shifted, "twtt": twtt[0] + bin_size * (np.arange(n_rows + n_extra) - n_extra)}
    undone["Elevation"] = content["Elevation"] - correction_bins * bin_size * SPEED_OF_LIGHT_M_S / 2
    for name in ("Surface", "Bottom"):
        if name in content:
            undone[name] = content[name] - correction_bins * bin_size
    return undone
