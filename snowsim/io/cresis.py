"""CReSIS L1B files: MAT v5 and v7.3, plain or compressed, floating or integer."""

import numpy as np

from snowsim.io.datasets import echogram_dataset, from_gps_seconds, from_utc_seconds, undo_compensation
from snowsim.io.guard import existing, matrix, one_line, refusal, vector
from snowsim.io.matlab import names_in_matlab, read_matlab

NEEDED = ("Data", "Time", "Latitude", "Longitude", "Elevation", "Surface")
ALONG_TRACK = ("Latitude", "Longitude", "Elevation", "Surface")
OPTIONAL = (
    "GPS_time",
    "UTC_time",
    "Roll",
    "Pitch",
    "Heading",
    "Bottom",
    "Elevation_Correction",
    "Truncate_Bins",
    "minData",
    "maxData",
)
# Parameter structs by age; the newest that has a name is believed.
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
PARAMETERS = ("season_name", "radar_name", "day_seg")


def read_cresis(path, *, compensated=False):
    """Echogram of a CReSIS L1B file.

    `Data` is taken as linear power; where `minData` and `maxData` stand beside integers it is
    ``dB = Data / intmax * maxData + minData``. `Time` may be a row or a column, attitude and `Bottom` may be missing.
    GPS seconds lose their leap seconds. Elevation compensation is undone.

    Parameters
    ----------
    path : path_like
    compensated : bool
        Keep the traces as stored, shifted by `Elevation_Correction`, which then goes with the dataset.

    Returns
    -------
    xarray.Dataset
        As `snowsim.echogram.check_echogram` wants it.

    Raises
    ------
    ValueError
        One line with file, variable, expected and found, for every file that is not as described.
    """
    path = existing(path)
    values = read_matlab(path, (*NEEDED, *OPTIONAL, *PARAMETER_STRUCTS))
    values_needed = (*NEEDED, "GPS_time") if "GPS_time" not in values and "UTC_time" not in values else NEEDED
    for name in values_needed:
        if name not in values:
            found = one_line(", ".join(sorted(names_in_matlab(path))), 200)
            raise refusal(path, name, f"variables {', '.join((*NEEDED, 'GPS_time'))}", found)
    slow_time = _slow_time(path, values)
    n_lines = slow_time.size
    time = vector(path, "Time", values["Time"])
    if time.size < 2:
        raise refusal(path, "Time", "two or more values", time.size)
    kept, first_bin = _kept_bins(path, values, time)
    content = {
        "Data": _power(path, values, time.size if kept is None else kept.size, n_lines),
        "twtt": time if kept is None else time[kept],
        "slow_time": slow_time,
    }
    for name in ALONG_TRACK:
        content[name] = vector(path, name, values[name], n_lines)
    for name in ("Roll", "Pitch", "Heading", "Bottom"):
        if name in values and values[name] is not None and np.size(values[name]):
            content[name] = vector(path, name, values[name], n_lines)
    if "Elevation_Correction" in values and np.size(values["Elevation_Correction"]):
        bins = vector(path, "Elevation_Correction", values["Elevation_Correction"], n_lines)
        if compensated:
            content["Elevation_Correction"] = ("slow_time", bins, {"units": "range bins"})
        else:
            # `Time` is as long as the padded traces were before they were truncated.
            n_recorded = None if kept is None else time.size - int(np.nan_to_num(bins).max(initial=0))
            content = undo_compensation(path, content, bins, first_bin, n_recorded)
    return echogram_dataset(path, content, {"source_format": "CReSIS L1B MAT", **_parameters(values)})


def _slow_time(path, values):
    if "GPS_time" in values:
        return from_gps_seconds(path, "GPS_time", vector(path, "GPS_time", values["GPS_time"]))
    return from_utc_seconds(path, "UTC_time", vector(path, "UTC_time", values["UTC_time"]))


def _kept_bins(path, values, time):
    """Which bins of `Time`, from 0, the rows of `Data` stand for (None: all), and the first bin before truncation."""
    bins = values.get("Truncate_Bins")
    if bins is None or not np.size(bins):
        return None, 0
    kept = vector(path, "Truncate_Bins", bins)
    truncated_along = kept.size == time.size  # `Time` was truncated along with the data
    largest = np.inf if truncated_along else time.size
    inside = (kept >= 1) & (kept <= largest)
    if kept.size < 2 or not inside.all() or (np.diff(kept) != 1).any():
        found = f"{kept.size} values from {kept[0]:g}, not consecutive" if inside.all() else f"{kept[~inside][0]:g}"
        raise refusal(path, "Truncate_Bins", f"consecutive indices within 1 to {largest}", found)
    first_bin = int(kept[0]) - 1
    return None if truncated_along else kept.astype(int) - 1, first_bin


def _power(path, values, n_bins, n_lines):
    data = matrix(path, "Data", values["Data"], n_bins, n_lines)
    scaling = [name for name in ("minData", "maxData") if name in values]
    if not scaling:
        return data if data.dtype.kind == "f" else data.astype(np.float32)
    if len(scaling) == 1 or data.dtype.kind not in "iu":
        found = f"{' and '.join(scaling)} beside Data of {data.dtype}"
        raise refusal(path, "Data", "integers scaled by minData and maxData", found)
    lowest_db, span_db = (vector(path, name, values[name], 1)[0] for name in ("minData", "maxData"))
    data_db = data.astype(np.float32) * np.float32(span_db / np.iinfo(data.dtype).max) + np.float32(lowest_db)
    with np.errstate(over="ignore"):  # infinite power is refused by name further on
        return 10 ** (data_db / 10)


def _parameters(values):
    found = {}
    for struct in PARAMETER_STRUCTS:
        for name in PARAMETERS:
            text = values[struct].get(name) if isinstance(values.get(struct), dict) else None
            if isinstance(text, str) and text and name not in found:
                found[name] = one_line(text, 100)
    return found
