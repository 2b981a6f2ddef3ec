"""Echograms of every format as Open Polar Radar datasets; contract: `snowsim.io.containers`."""

import re
from numbers import Integral
from os import PathLike
from pathlib import Path

import numpy as np
import xarray as xr

from snowsim.alignment import shifted
from snowsim.echogram import (
    ALONG_TRACK,
    MAXIMUM_BYTES,
    UNITS,
    as_recorded,
    check_echogram,
    echogram_dataset,
    named_frame,
    repeats,
    without_repeats,
)
from snowsim.io.containers import (
    ECHOGRAMS,
    RADIANS,
    SUPPLEMENT_FLAGS,
    format_of,
    one_line_errors,
    open_container,
    read_values,
)
from snowsim.io.files import content_of, digest_of, library_errors, refusal
from snowsim.io.times import gps_seconds, utc_times

# Decibels span this much from the weakest to the strongest pixel. If none is negative, their median
# is at least this share of the strongest.
LEAST_SPAN_DB, LARGEST_SPAN_DB = 3, 400
LEAST_MEDIAN = 0.1
UNITS_OF_DB = ("db", "dbm", "dbw", "decibel", "decibels")
UNITS_OF_AMPLITUDE = ("v", "volt", "volts", "amplitude")
# Units that begin so are decibels or another logarithm, in words that are not known.
LOGARITHMIC = ("db", "decibel", "log", "10*log", "10 log")
# Parameters of a file that become attributes of the dataset.
PARAMETERS = ("season_name", "radar_name", "day_seg")
UNREAD = "unread"  # in place of the digest of a file that cannot be read
# Only an attribute of this form becomes a folder: it may hold anything.
SEGMENT = re.compile(r"[0-9]{8}_[0-9]{2}")


def frame_in(echogram, path):
    """Segment and number of a frame by the attributes of its echogram; the number may be None.

    Open Polar Radar's tools write `granule`, or `segment_path` and `frame`. Without a segment, the
    day is one. ValueError, in words about the file at `path`, for a segment that is none.
    """
    segment, number = named_frame(str(echogram.attrs.get("granule", "")))
    if segment is not None:
        return segment, number
    told = [str(echogram.attrs.get(name, "")) for name in ("day_seg", "segment_path")]
    segment = told[0] or told[1]
    if not segment:
        day = str(echogram["slow_time"].values[0])[:10].replace("-", "")
        return f"{day}_01", None
    if not SEGMENT.fullmatch(segment):
        raise refusal(path, "day_seg", "a segment such as 20120330_04", segment)
    number = echogram.attrs.get("frame")
    counted = isinstance(number, Integral) and 0 < number < 1000
    return segment, int(number) if counted else None


@one_line_errors()
def read_echogram(
    path: str | PathLike[str], *, compensated: bool = False, source: str | None = None
) -> xr.Dataset:
    """Echogram dataset of a file; its format follows from its content.

    Parameters
    ----------
    path : path_like
        IRSNO1B NetCDF (plain, deconv, uwb), CReSIS L1B MAT (v5, v7.3), or an Open Polar Radar
        dataset (NetCDF, Zarr).
    compensated : bool
        Keep the elevation compensation of a file; by default it is undone, so that travel times
        start at the antenna's `Elevation`.
    source : {"nsidc", "cresis", "opr"}, optional
        Format that the file must have; by default any of these.

    Returns
    -------
    xarray.Dataset
        Coordinates `slow_time` [UTC] and `twtt` [s]; `Data` (twtt, slow_time) in linear power, NaN
        where nothing was recorded, also where power lies far below all other, see
        `snowsim.echogram.recorded`; `Latitude`, `Longitude`, `Elevation`, `Surface` along
        slow_time, and what else the file has.

    Raises
    ------
    ValueError
        One line, with file, variable, expected and found, for any file that is not a sound
        echogram.

    Examples
    --------
    A simulated frame, written as Open Polar Radar dataset:

    >>> from snowsim import Climate, simulate
    >>> drawn, _ = simulate(Climate(accumulation_m=0.3), "snow-2012", n_range_lines=64, rng=1)
    >>> _ = drawn.to_netcdf("frame.nc")
    >>> echogram = read_echogram("frame.nc")
    >>> echogram.sizes["slow_time"], echogram["twtt"].attrs["units"]
    (64, 's')
    """
    stored = open_container(path)
    kind = format_of(stored, [source] if source else ECHOGRAMS)
    if kind == "opr":
        return read_opr(stored)
    read = read_nsidc if kind == "nsidc" else read_cresis
    return read(stored, compensated=compensated)


def power_of(data_db, where):
    """Linear power of decibels; -inf becomes NaN. ValueError if the values look like power."""
    some_db = data_db.flat[:: 1 + data_db.size // 100_000]
    some_db = some_db[np.isfinite(some_db)]
    low_db, middle_db, high_db = np.quantile(some_db if some_db.size else 0, (0, 0.5, 1))
    is_linear = low_db >= 0 and middle_db < LEAST_MEDIAN * high_db
    if is_linear or not LEAST_SPAN_DB < high_db - low_db < LARGEST_SPAN_DB:
        found = f"{low_db:.3g} to {high_db:.3g}, {middle_db:.3g} in the median: linear power?"
        raise refusal(where, "Data", "decibels", found)
    with np.errstate(over="ignore"):  # check_echogram refuses infinite power
        return np.where(np.isneginf(data_db), np.nan, 10 ** (data_db / 10))


def read_opr(stored):
    """Echogram dataset of an Open Polar Radar file, checked, with axes (twtt, slow_time).

    If `units` of `Data` say decibels, they become linear power; other logarithms are refused.
    """
    dataset = stored.read()
    units = str(dataset["Data"].attrs.get("units", "")).lower()
    if units in UNITS_OF_AMPLITUDE:
        raise refusal(stored.path, "Data: units", f"power, or {', '.join(UNITS_OF_DB)}", units)
    if units.startswith(LOGARITHMIC) and units not in UNITS_OF_DB:
        raise refusal(stored.path, "Data: units", f"{', '.join(UNITS_OF_DB)}, or power", units)
    if units in UNITS_OF_DB:
        power = power_of(dataset["Data"].values.astype(float), stored.path)
        dataset["Data"] = (dataset["Data"].dims, power, {"units": UNITS["Data"]})
    if "Surface" not in dataset:
        unknown = xr.full_like(dataset["Elevation"], np.nan, dtype=float)
        dataset["Surface"] = unknown.assign_attrs(units="s")
    dataset = without_repeats(dataset, stored.path)
    check_echogram(dataset, str(stored.path))
    return as_recorded(dataset.transpose("twtt", "slow_time", ...))


def undo_compensation(echogram, first_row=-np.inf, end_row=np.inf):
    """Echogram without elevation compensation: traces shifted back by `Elevation_Correction` bins.

    A trace without shift was recorded from `first_row` to before `end_row`. Other rows are padding,
    which the CReSIS toolbox fills with zero power; they become NaN.

    ``twtt -= EC dt``, ``Surface -= EC dt``, ``Elevation -= EC dt c / 2``: the inverse of the
    compensation by the CReSIS toolbox.
    """
    bins = echogram["Elevation_Correction"]
    most = MAXIMUM_BYTES / echogram["Data"][0].nbytes - echogram.sizes["twtt"]
    if not ((bins >= 0) & (bins == np.floor(bins)) & (bins <= most)).all():
        expected = f"whole numbers of bins from 0 to {most:.0f}"
        found = f"{bins.min():g} to {bins.max():g}"
        raise refusal(None, "Elevation_Correction", expected, found)
    row = xr.DataArray(np.arange(echogram.sizes["twtt"]), dims="twtt")
    recorded = (row >= bins + first_row) & (row < bins + end_row)
    echogram["Data"] = echogram["Data"].where(recorded)
    return shifted(echogram.drop_vars("Elevation_Correction"), -bins.values.astype(int))


# Names of variables along track in IRSNO1B files, if they differ from ours.
NSIDC_NAMES = {
    "Latitude": "lat",
    "Longitude": "lon",
    "Elevation": "altitude",
    "Roll": "roll",
    "Pitch": "pitch",
    "Heading": "heading",
}
ATTITUDE = ("Roll", "Pitch", "Heading")
HALF_DAY = np.timedelta64(12, "h")


def read_nsidc(stored, *, compensated=False):
    """Echogram of an IRSNO1B file; see `snowsim.io.read_echogram`.

    `amplitude` [dB] becomes linear power, and its -inf (bins that elevation compensation inserted)
    NaN. `time` (UTC, of one day) becomes `slow_time`, which goes on past midnight; `fasttime` [us]
    becomes `twtt`; attitude becomes radians. With a supplement beside the file, bit i of
    `quality_mask` (slow_time) is flag i of `flag_meanings`.
    """
    values = stored.read()
    axes = (*values["fasttime"].dims, *values["time"].dims)
    times = utc_times(values["time"])
    midnights = np.cumsum(np.append(False, np.diff(times) < -HALF_DAY))
    content = {
        "Data": power_of(values["amplitude"].transpose(*axes).values, stored.path),
        "twtt": values["fasttime"].values,
        "slow_time": times + 2 * HALF_DAY * midnights,
    }
    for ours in ALONG_TRACK:
        theirs = NSIDC_NAMES.get(ours, ours)
        if theirs in values:
            along = values[theirs].astype(float)
            unit = str(along.attrs.get("units", "")).strip().lower()
            in_degrees = ours in ATTITUDE and unit not in RADIANS
            content[ours] = np.radians(along) if in_degrees else along
    attributes = {"source_format": "IRSNO1B NetCDF"}
    for name in sorted(values.variables):
        parameter = name.rpartition(".")[2]
        if name.startswith("param") and parameter in PARAMETERS:
            # The text is an array of characters, padded with NUL.
            text = b"".join(np.ravel(values[name]).astype(bytes)).decode("latin-1")
            attributes.setdefault(parameter, " ".join(text.replace("\0", "").split())[:100])
    echogram = echogram_dataset(stored.path, content, attributes)
    if "Elevation_Correction" in echogram and not compensated:
        echogram = undo_compensation(echogram)
    supplement = find_supplement(stored.path)
    if supplement is not None:
        dims, mask, attrs = _quality_mask(supplement, times.size)
        echogram["quality_mask"] = dims, mask[~repeats(content["slow_time"])], attrs
        echogram.attrs["supplement"] = supplement.name
    return echogram


def find_supplement(path):
    """Path of the supplement beside an IRSNO1B file, named alike up to the frame, or None."""
    path = Path(path)
    base, variant = re.fullmatch(r"(.*?\d{8}_\d{2}_\d{3}|.*?)(.*)", path.stem).groups()
    stems = (f"{path.stem}_supplement", f"{base}_supplement{variant}", f"{base}_supplement")
    files = (path.with_name(f"{stem}.nc") for stem in stems)
    return next((file for file in files if file.is_file()), None)


def content_and_digest(path):
    """Bytes of a file, None of a folder; and the digest of these and of the supplement beside."""
    content = content_of(path)
    digest = digest_of(path, content)
    supplement = find_supplement(path)
    if supplement is not None:
        digest += digest_of(supplement, content_of(supplement))
    return content, digest


def digest_or_unread(path):
    """Digest of `content_and_digest`, or `UNREAD` if the file cannot be read."""
    try:
        return content_and_digest(path)[1]
    except (ValueError, OSError):
        return UNREAD


def _quality_mask(path, n_lines):
    """Variable `quality_mask` of the flags of a supplement, which are set by frame or by line."""
    stored = read_values(path)
    bits = 1 << np.arange(len(SUPPLEMENT_FLAGS), dtype=np.uint8)
    mask = np.zeros(n_lines, dtype=np.uint8)
    with library_errors(path, f"supplement: expected flags of 1 or {n_lines} lines"):
        if not stored.variables.keys() & set(SUPPLEMENT_FLAGS):
            expected = f"flags {', '.join(SUPPLEMENT_FLAGS)}"
            raise refusal(path, "supplement", expected, "none of them")
        for bit, name in zip(bits, SUPPLEMENT_FLAGS, strict=True):
            if name in stored:
                mask |= bit * (np.nan_to_num(stored[name].values) != 0)  # NaN: declared as missing
    return "slow_time", mask, {"flag_masks": bits, "flag_meanings": " ".join(SUPPLEMENT_FLAGS)}


OTHERS = ("Data", "Time", "GPS_time", "UTC_time", "Truncate_Bins", "minData", "maxData")
# Parameter structs, newest first: the first that has a parameter is used.
PARAMETER_STRUCTS = (
    "param_records",
    "param_qlook",
    "param_get_heights",
    "param_array",
    "param_sar",
    "param_csarp",
    "param_combine_wf_chan",
    "param_combine",
    "param_vectors",
    "param_radar",
    "param",
)


def read_cresis(stored, *, compensated=False):
    """Echogram of a CReSIS L1B file; see `snowsim.io.read_echogram`.

    `Data` is linear power, or, in a file with `minData` and `maxData`, integers for which ``dB =
    Data / intmax * maxData + minData``. `Time` may be a row or a column. Surface, attitude and
    `Bottom` may be missing. Leap seconds are removed from GPS time.
    """
    values = stored.read((*OTHERS, *ALONG_TRACK, *PARAMETER_STRUCTS))
    is_gps = "GPS_time" in values
    time = np.ravel(values["Time"]).astype(float)
    kept = np.ravel(values.get("Truncate_Bins", np.arange(time.size) + 1)) - 1
    if not kept[0] >= 0 or (np.diff(kept) != 1).any():
        expected = "consecutive indices from 1 up"
        raise refusal(stored.path, "Truncate_Bins", expected, f"{kept[0] + 1:g} first")
    # `Time` is either truncated like the data, or as long as the padded traces before truncation.
    time_is_padded = kept.size < time.size
    content = {
        "Data": np.asarray(values["Data"]),
        "twtt": time[kept.astype(int)] if time_is_padded else time,
        "slow_time": utc_times(values["GPS_time" if is_gps else "UTC_time"], gps=is_gps),
    }
    content |= {name: values[name] for name in ALONG_TRACK if name in values}
    if "minData" in values or "maxData" in values:
        with library_errors(stored.path, "Data: expected integers scaled by minData and maxData"):
            step_db = np.float32(values["maxData"] / np.iinfo(content["Data"].dtype).max)
            data_db = content["Data"].astype(np.float32) * step_db
            data_db += np.float32(values["minData"])
        content["Data"] = power_of(data_db, stored.path)
    attributes = {"source_format": "CReSIS L1B MAT"}
    for struct in PARAMETER_STRUCTS:
        fields = values.get(struct)
        for name in PARAMETERS if isinstance(fields, dict) else ():
            if isinstance(fields.get(name), str) and fields[name]:
                attributes.setdefault(name, " ".join(fields[name].split())[:100])
    echogram = echogram_dataset(stored.path, content, attributes)
    if "Elevation_Correction" not in echogram or compensated:
        return echogram
    padding = echogram["Elevation_Correction"].values.max() if time_is_padded else -np.inf
    return undo_compensation(echogram, -kept[0], time.size - padding - kept[0])


def l1b_content(segment, echogram):
    """Variables of the CReSIS L1B file of a simulated echogram, by name."""
    centre_hz = echogram.attrs["centre_hz"]
    half_hz = echogram.attrs["bandwidth_hz"] / 2
    sweep = {"f0": centre_hz - half_hz, "f1": centre_hz + half_hz, "fmult": 1.0}
    records = {
        **parameters(segment, echogram.attrs),
        "gps_source": "",
        "cmd": {"mission_names": ""},
        "radar": {"wfs": sweep},
    }
    content = {
        "Data": echogram["Data"].transpose("twtt", "slow_time").values,
        "Time": echogram["twtt"].values[:, None],
        "GPS_time": gps_seconds(echogram["slow_time"].values),
        "param_records": records,
    }
    return content | {name: echogram[name].values for name in ALONG_TRACK if name in echogram}


def parameters(segment, attributes):
    """Struct of parameters: radar and season, empty if `attributes` lack them, and segment."""
    known = {name: str(attributes.get(name, "")) for name in PARAMETERS}
    return known | {"day_seg": segment, "sw_version": {"ver": "snowsim"}}
