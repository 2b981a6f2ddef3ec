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
    slow_time = _slow_time(path, values)
    time = vector(path, "Time", values["Time"])
    if time.size < 2:
        raise refusal(path, "Time", "two or more values", time.size)
    kept = _kept_bins(path, values, time.size)
    # `Time` was truncated along with the data, or is as long as the padded traces were before.
    time_is_padded = kept.size < time.size
    twtt = time[kept] if time_is_padded else time
    power = _power(path, values, twtt.size, slow_time.size)
    content = {"Data": power, "twtt": twtt, "slow_time": slow_time}
    for name in (*ECHOGRAM_ALONG_TRACK, *ALONG_TRACK_IF_ANY):
        if name in ECHOGRAM_ALONG_TRACK or _holds(values, name):
            content[name] = vector(path, name, values[name], slow_time.size)
    if _holds(values, "Elevation_Correction"):
        name = "Elevation_Correction"
        bins = vector(path, name, values[name], slow_time.size)
        if compensated:
            content[name] = bins
        else:
            n_recorded = time.size - bins.max(initial=0) if time_is_padded else np.inf
            rows = {"first_row": -kept[0], "end_row": n_recorded - kept[0]}
            content = datasets.undo_compensation(path, content, bins, **rows)
    attributes = {"source_format": "CReSIS L1B MAT"} | _parameters(values)
    return datasets.echogram_dataset(path, content, attributes)


def _slow_time(path, values):
    if "GPS_time" in values:
        gps_time = vector(path, "GPS_time", values["GPS_time"])
        return datasets.from_gps_seconds(path, "GPS_time", gps_time)
    utc_time = vector(path, "UTC_time", values["UTC_time"])
    return datasets.from_utc_seconds(path, "UTC_time", utc_time)


def _holds(values, name):
    """Whether a variable that may be missing is there and not empty."""
    return np.size(values.get(name, ())) > 0


def _kept_bins(path, values, n_times):
    """Indices, from 0, of the bins of padded traces that the rows of `Data` stand for."""
    if not _holds(values, "Truncate_Bins"):
        return np.arange(n_times)
    kept = vector(path, "Truncate_Bins", values["Truncate_Bins"])
    largest = np.inf if kept.size == n_times else n_times
    expected = f"consecutive indices within 1 to {largest}"
    inside = (kept >= 1) & (kept <= largest)
    if not inside.all():
        raise refusal(path, "Truncate_Bins", expected, f"{kept[~inside][0]:g}")
    if kept.size < 2 or (np.diff(kept) != 1).any():
        found = f"{kept.size} values from {kept[0]:g}, not consecutive"
        raise refusal(path, "Truncate_Bins", expected, found)
    return kept.astype(int) - 1


def _power(path, values, n_bins, n_lines):
    data = matrix(path, "Data", values["Data"], n_bins, n_lines)
    scaling = [name for name in ("minData", "maxData") if name in values]
    if not scaling:
        return data if data.dtype.kind == "f" else data.astype(np.float32)
    if len(scaling) == 1 or data.dtype.kind not in "iu":
        found = f"{' and '.join(scaling)} beside Data of {data.dtype}"
        raise refusal(path, "Data", "integers scaled by minData and maxData", found)
    (lowest_db,) = vector(path, "minData", values["minData"], 1)
    (span_db,) = vector(path, "maxData", values["maxData"], 1)
    step_db = np.float32(span_db / np.iinfo(data.dtype).max)
    return datasets.from_db(data.astype(np.float32) * step_db + np.float32(lowest_db))


def _parameters(values):
    found = {}
    for struct in PARAMETER_STRUCTS:
        fields = values.get(struct)
        if isinstance(fields, dict):
            for name in datasets.PARAMETERS:
                text = fields.get(name)
                if isinstance(text, str) and text:
                    found.setdefault(name, one_line(text, 100))
    return found
