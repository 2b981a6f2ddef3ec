"""Times of files, as seconds since 1970, GPS time or UTC, converted to UTC and back."""

import numpy as np

from snowsim.constants import THIS_AGE
from snowsim.io.files import refusal

SINCE = np.datetime64("1970-01-01", "s")
# GPS - UTC grows by one second on each: Bulletin C of the International Earth Rotation and
# Reference Systems Service.
LEAP_DAYS = [
    "1981-07-01",
    "1982-07-01",
    "1983-07-01",
    "1985-07-01",
    "1988-01-01",
    "1990-01-01",
    "1991-01-01",
    "1992-07-01",
    "1993-07-01",
    "1994-07-01",
    "1996-01-01",
    "1997-07-01",
    "1999-01-01",
    "2006-01-01",
    "2009-01-01",
    "2012-07-01",
    "2015-07-01",
    "2017-01-01",
]
LEAP_UTC = np.array(LEAP_DAYS, dtype="datetime64[ns]")
LEAP_GPS = LEAP_UTC + np.arange(1, LEAP_UTC.size + 1) * np.timedelta64(1, "s")


def utc_times(times, *, gps=False):
    """UTC times (range_line,), datetime64[ns], from `times`: dates, or seconds since 1970.

    With `gps`, `times` are GPS time, and the leap seconds are subtracted. The whole file has the
    offset of its first line, as in the archive's own conversion to NetCDF, so that a frame flown
    across a leap second stays in order. Missing times, and times outside `THIS_AGE`, are refused.
    """
    name = getattr(times, "name", "slow_time")
    times = np.ravel(times)
    is_dated = times.dtype.kind == "M"
    seconds = (times - SINCE) / np.timedelta64(1, "s") if is_dated else times.astype(float)
    first, end = np.array(THIS_AGE, dtype="datetime64[s]").astype(float)
    missing = np.isnan(seconds)
    if missing.any():
        found = f"none on {missing.sum()} of {missing.size} (the first is {missing.argmax()})"
        raise refusal(None, name, "a time on every range line", found)
    inside = (seconds >= first) & (seconds < end)
    if not inside.all():
        expected = f"units 'since' a date, or seconds since 1970, in {' to '.join(THIS_AGE)}"
        raise refusal(None, name, expected, f"{seconds[~inside][0]:g}")
    if not is_dated:
        whole = np.floor(seconds)
        nanoseconds = np.rint((seconds - whole) * 1e9)
        times = whole.astype("datetime64[s]") + nanoseconds.astype("timedelta64[ns]")
    late_s = np.searchsorted(LEAP_GPS, times[0], side="right") if gps else 0
    return times.astype("datetime64[ns]") - np.timedelta64(late_s, "s")


def gps_seconds(slow_time):
    """GPS seconds since 1970 (range_line,) of UTC times; the inverse of `utc_times`.

    The result equals, to the last bit, the seconds from which the times were read: today doubles
    are 2.4e-7 s apart, and nanoseconds round by less. The whole file has the offset of its first
    line. A first line within a leap second counts as the second after it, as UTC writes it.
    """
    times = np.asarray(slow_time, dtype="datetime64[ns]")
    whole, rest = np.divmod(times.astype(np.int64), 1_000_000_000)
    return (whole + leap_seconds(times[0])) + rest * 1e-9


def leap_seconds(time):
    """Number of seconds that GPS time is ahead of UTC at a time in UTC."""
    return int(np.searchsorted(LEAP_UTC, time, side="right"))
