"""CReSIS L1B files: MAT v5 and v7.3, plain or compressed, floating or integer."""

import numpy as np

from snowsim.echogram import ECHOGRAM_ALONG_TRACK
from snowsim.io import datasets
from snowsim.io.guard import check_present, existing, matrix, one_line, refusal, vector
from snowsim.io.matlab import read_matlab
from snowsim.io.sniff import names_in

NEEDED = ("Data", "Time", *ECHOGRAM_ALONG_TRACK)
TIMES = ("GPS_time", "UTC_time")
ALONG_TRACK_IF_ANY = ("Roll", "Pitch", "Heading", "Bottom")
CODES = ("Elevation_Correction", "Truncate_Bins", "minData", "maxData")
# Parameter structs by age; the newest that has a name is believed.
PARAMETER_STRUCTS = (
    *(
        "param_records",
        "param_qlook",
        "param_get_heights",
        "param_array",
        "param_sar",
        "param_csarp",
    ),
    *("param_combine_wf_chan", "param_combine", "param_vectors", "param_radar", "param"),
)


def read_cresis(path, *, compensated=False):
    """Echogram of a CReSIS L1B file; see `snowsim.io.read_echogram`.

    `Data` is linear power; where `minData` and `maxData` stand beside integers ``dB = Data / intmax
    * maxData + minData``. `Time` may be row or column, attitude and `Bottom` may be missing. GPS
    seconds lose their leap seconds.
    """
    path = existing(path)
    values = read_matlab(path, (*NEEDED, *TIMES, *ALONG_TRACK_IF_ANY, *CODES, *PARAMETER_STRUCTS))
    needed = NEEDED if "UTC_time" in values else (*NEEDED, "GPS_time")
    check_present(path, needed, values, names_in)
    if "GPS_time" in values:
        slow_time = datasets.from_gps_seconds(
            path, "GPS_time", vector(path, "GPS_time", values["GPS_time"])
        )
    else:
        slow_time = datasets.from_utc_seconds(
            path, "UTC_time", vector(path, "UTC_time", values["UTC_time"])
        )
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
    for name in (*ECHOGRAM_ALONG_TRACK, *ALONG_TRACK_IF_ANY):
        if name in ECHOGRAM_ALONG_TRACK or _holds(values, name):
            content[name] = vector(path, name, values[name], n_lines)
    if "Elevation_Correction" in values and np.size(values["Elevation_Correction"]):
        bins = vector(path, "Elevation_Correction", values["Elevation_Correction"], n_lines)
        # `Time` is as long as the padded traces were before they were truncated.
        n_recorded = None if kept is None else time.size - int(np.nan_to_num(bins).max(initial=0))
        recorded = {"first_bin": first_bin, "n_recorded": n_recorded}
        content = datasets.undo_compensation(path, content, bins, keep=compensated, **recorded)
    return datasets.echogram_dataset(
        path, content, {"source_format": "CReSIS L1B MAT", **_parameters(values)}
    )


def _holds(values, name):
    """Whether a variable that may be missing is there and not empty."""
    return values.get(name) is not None and np.size(values[name]) > 0


def _kept_bins(path, values, time):
    """Which bins of `Time`, from 0, the rows of `Data` stand for (None: all), and the first bin before truncation."""
    if not _holds(values, "Truncate_Bins"):
        return None, 0
    kept = vector(path, "Truncate_Bins", values["Truncate_Bins"])
    truncated_along = kept.size == time.size  # `Time` was truncated along with the data
    largest = np.inf if truncated_along else time.size
    inside = (kept >= 1) & (kept <= largest)
    if kept.size < 2 or not inside.all() or (np.diff(kept) != 1).any():
        found = (
            f"{kept.size} values from {kept[0]:g}, not consecutive"
            if inside.all()
            else f"{kept[~inside][0]:g}"
        )
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
    step_db = np.float32(span_db / np.iinfo(data.dtype).max)
    return datasets.from_db(data.astype(np.float32) * step_db + np.float32(lowest_db))


def _parameters(values):
    found = {}
    for struct in PARAMETER_STRUCTS:
        for name in datasets.PARAMETERS:
            text = values[struct].get(name) if isinstance(values.get(struct), dict) else None
            if isinstance(text, str) and text and name not in found:
                found[name] = one_line(text, 100)
    return found
