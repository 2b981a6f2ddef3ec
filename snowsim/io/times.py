"""GPS and UTC seconds of the archives' files to UTC datetime64."""

import numpy as np

from snowsim.io.guard import refusal

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
