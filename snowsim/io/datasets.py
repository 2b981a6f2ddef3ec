"""Open Polar Radar datasets: read as they stand, or made of the archives' arrays; checked."""

import importlib.util

import numpy as np
import xarray as xr

from snowsim.constants import SPEED_OF_LIGHT_M_S
from snowsim.echogram import ECHOGRAM_ALONG_TRACK, check_echogram
from snowsim.io.containers import read_netcdf
from snowsim.io.guard import check_present, check_size, existing, library_errors, refusal

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
    "Elevation_Correction": "range bins",
}
UNITS_OF_TWTT = ("", "s", "sec", "second", "seconds")
UNITS_OF_DB = ("db", "decibel", "decibels")
RANGES = {"Latitude": 90, "Longitude": 360}
# Of all that a file tells, this much goes with the dataset.
PARAMETERS = ("season_name", "radar_name", "day_seg")
FIRST_DAY = "1980-01-06"
LAST_YEAR = 2100
SECONDS_OF_DAY = 86400
# GPS - UTC grows by one second on each: Bulletin C of the International Earth Rotation and
# Reference Systems Service.
LEAP_DAYS = sorted(
    [f"{year}-01-01" for year in (1988, 1990, 1991, 1996, 1999, 2006, 2009, 2017)]
    + [f"{year}-07-01" for year in (1981, 1982, 1983, 1985, 1992, 1993, 1994, 1997, 2012, 2015)]
)


def echogram_dataset(path, content, attributes):
    """Echogram dataset, checked.

    `content` holds `Data` (range_bin, range_line), `twtt`, `slow_time`, and what there is along
    slow_time.
    """
    along_track = dict(content)
    power = along_track.pop("Data")
    twtt = along_track.pop("twtt")
    slow_time = along_track.pop("slow_time")
    variables = {"Data": (("twtt", "slow_time"), power, {"units": UNITS["Data"]})}
    for name, values in along_track.items():
        variables[name] = ("slow_time", values, {"units": UNITS[name]})
    coordinates = {"twtt": ("twtt", twtt, {"units": "s"}), "slow_time": slow_time}
    return checked_echogram(path, xr.Dataset(variables, coordinates, attributes))


def checked_echogram(path, dataset):
    """The dataset, if it passes the validator and stays on Earth."""
    check_echogram(dataset, str(path))
    for name, largest in RANGES.items():
        degrees = dataset[name].values
        outside = np.abs(degrees) > largest  # NaN, where the position is unknown, is not
        if outside.any():
            found = f"{degrees[outside][0]:g} at range_line {int(np.argmax(outside))}"
            raise refusal(path, name, f"degrees within +-{largest}", found)
    return dataset


def read_opr(path):
    """Echogram dataset as it stands on disk, but for the order (twtt, slow_time); checked.

    Decibels, if the units of `Data` say so, become linear power.
    """
    dataset = load_opr(path, ("Data", "twtt", "slow_time", *ECHOGRAM_ALONG_TRACK))
    check_dimensions(path, dataset, "Data", ("twtt", "slow_time"))
    if str(dataset["Data"].attrs.get("units", "")).lower() in UNITS_OF_DB:
        power = from_db(dataset["Data"].astype(float))
        dataset["Data"] = power.assign_attrs(dataset["Data"].attrs, units=UNITS["Data"])
    return checked_echogram(path, dataset.transpose("twtt", "slow_time", ...))


def check_dimensions(path, dataset, name, expected):
    """Refuse a variable on other dimensions than these two, in whichever order."""
    dimensions = dataset[name].dims
    if set(dimensions) != set(expected):
        found = ", ".join(map(str, dimensions))
        raise refusal(path, name, f"dimensions {' and '.join(expected)}", found)


def load_opr(path, needed):
    """Dataset of a NetCDF file or Zarr store in memory, with `twtt` in seconds.

    The variables needed must be there and, but for `slow_time`, real numbers.
    """
    path = existing(path, directory=True)
    if path.is_dir():
        dataset = _loaded_store(path)
    else:
        with library_errors(path, "dataset", "times and fill values that can be decoded"):
            dataset = xr.decode_cf(read_netcdf(path), decode_timedelta=False).load()
    check_present(path, needed, dataset.variables)
    unit = str(dataset["twtt"].attrs.get("units", ""))
    if unit not in UNITS_OF_TWTT:
        raise refusal(path, "twtt", "seconds", unit)
    for name in needed:
        if name != "slow_time" and dataset[name].dtype.kind not in "fiu":
            raise refusal(path, name, "real numbers", dataset[name].dtype)
    return dataset


def _loaded_store(path):
    if importlib.util.find_spec("zarr") is None:
        raise refusal(path, "Zarr store", "package zarr to read it", "it is not installed")
    with (
        library_errors(path, "dataset", "a readable store"),
        xr.open_dataset(path, engine="zarr", decode_timedelta=False) as dataset,
    ):
        for name, variable in dataset.variables.items():
            check_size(path, name, variable.shape, variable.dtype.itemsize)
        return dataset.load()


def from_db(power_db):
    """Linear power of decibels; where it overflows, the infinite power is refused further on."""
    with np.errstate(over="ignore"):
        return 10 ** (power_db / 10)


def leap_seconds(gps_seconds):
    """GPS minus UTC [s] at a time in GPS seconds since 1970-01-01, leap seconds not removed."""
    days = np.array(LEAP_DAYS, dtype="datetime64[s]").astype(np.int64)
    since = days + 1 + np.arange(days.size)
    return int(np.searchsorted(since, gps_seconds, side="right"))


def from_utc_seconds(path, what, seconds, epoch="1970-01-01"):
    """UTC seconds since a date as datetime64[ns], (range_line,).

    Refused where they are not finite or out of this age.
    """
    since = np.datetime64(epoch, "s").astype(np.int64)
    first = np.datetime64(FIRST_DAY, "s").astype(np.int64)
    last = np.datetime64(f"{LAST_YEAR}-01-01", "s").astype(np.int64)
    since_1970 = seconds + since
    # Written so that NaN fails too.
    bad = ~((since_1970 >= first) & (since_1970 < last))
    expected = f"seconds since {epoch} that fall in 1980 to {LAST_YEAR}"
    if seconds.size == 0:
        raise refusal(path, what, expected, "none")
    if bad.any():
        found = f"{seconds[bad][0]:g} at range_line {int(np.argmax(bad))}"
        raise refusal(path, what, expected, found)
    whole = np.floor(seconds)
    nanoseconds = np.rint((seconds - whole) * 1e9).astype(np.int64)
    whole_since_1970 = whole.astype(np.int64) + since
    return (whole_since_1970 * 1_000_000_000 + nanoseconds).view("datetime64[ns]")


def from_gps_seconds(path, what, seconds):
    """GPS seconds since 1970 as UTC datetime64[ns], (range_line,).

    One offset holds for a whole file, that of its first line, as in the archive's own conversion to
    NetCDF: a frame flown over a leap second stays in order.
    """
    seconds = np.asarray(seconds, dtype=float)
    finite = seconds[np.isfinite(seconds)]
    if finite.size == 0:
        raise refusal(path, what, "GPS seconds since 1970", f"no finite value among {seconds.size}")
    return from_utc_seconds(path, what, seconds - leap_seconds(finite[0]))


def unwrap_midnight(seconds_of_day):
    """Seconds of day that go on past midnight, and how often it passed.

    Midnight passes where they fall back by over half a day.
    """
    seconds_of_day = np.asarray(seconds_of_day, dtype=float)
    falls_back = np.diff(seconds_of_day) < -SECONDS_OF_DAY / 2
    midnights = np.cumsum(np.append(False, falls_back))
    return seconds_of_day + SECONDS_OF_DAY * midnights, int(falls_back.sum())


def undo_compensation(path, content, correction_bins, *, first_row=-np.inf, end_row=np.inf):
    """Content with traces shifted back by `correction_bins` (range_line,), made for level flight.

    `content` holds `Data` (range_bin, range_line), `twtt` (range_bin,) [s], `Elevation` [m],
    `Surface` and perhaps `Bottom` (range_line,) [s]. A trace that was not shifted was recorded from
    `first_row` to before `end_row`; what lies outside is padding and counts as missing.

    ``twtt -= EC dt``, ``Surface -= EC dt``, ``Elevation -= EC dt c / 2``: the inverse of the CReSIS
    toolbox's compression, in which inserted bins hold zero power. They are NaN here, so that no
    zero passes for a measurement.
    """
    data = content["Data"]
    twtt = content["twtt"]
    counted = np.isfinite(correction_bins) & (correction_bins >= 0)
    whole = counted & (correction_bins == np.floor(correction_bins))
    if not whole.all():
        found = f"{correction_bins[~whole][0]:g} at range_line {int(np.argmin(whole))}"
        raise refusal(path, "Elevation_Correction", "whole numbers of bins, not negative", found)
    n_rows, n_lines = data.shape
    n_extra = int(correction_bins.max(initial=0))
    shape = (n_rows + n_extra, n_lines)
    check_size(path, "Elevation_Correction", shape, data.dtype.itemsize)

    starts = np.clip(correction_bins + first_row, 0, n_rows).astype(int)
    stops = np.clip(correction_bins + end_row, starts, n_rows).astype(int)
    shifted = np.full(shape, np.nan, dtype=data.dtype)
    for line, bins in enumerate(correction_bins.astype(int)):
        top = n_extra - bins
        start = starts[line]
        stop = stops[line]
        shifted[top + start : top + stop, line] = data[start:stop, line]
    bin_size = (twtt[-1] - twtt[0]) / (twtt.size - 1)
    undone = dict(content)
    undone["Data"] = shifted
    undone["twtt"] = twtt[0] + bin_size * (np.arange(len(shifted)) - n_extra)
    undone["Elevation"] = content["Elevation"] - correction_bins * bin_size * SPEED_OF_LIGHT_M_S / 2
    for name in ("Surface", "Bottom"):
        if name in content:
            undone[name] = content[name] - correction_bins * bin_size
    return undone
