"""CReSIS L1B files: MAT v5 and v7.3, plain or compressed, floating or integer."""

import numpy as np

from snowsim.io.containers import read_matlab
from snowsim.io.datasets import PARAMETERS, echogram_dataset, undo_compensation, utc_times
from snowsim.io.guard import Refused, library_errors

ALONG_TRACK = (
    "Latitude",
    "Longitude",
    "Elevation",
    "Surface",
    "Bottom",
    "Roll",
    "Pitch",
    "Heading",
    "Elevation_Correction",
)
OTHERS = ("Data", "Time", "GPS_time", "UTC_time", "Truncate_Bins", "minData", "maxData")
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
    * maxData + minData``. `Time` may be row or column; surface, attitude and `Bottom` may be
    missing. GPS seconds lose their leap seconds.
    """
    values = read_matlab(path, (*OTHERS, *ALONG_TRACK, *PARAMETER_STRUCTS))
    is_gps = "GPS_time" in values
    time = np.ravel(values["Time"]).astype(float)
    kept = np.ravel(values.get("Truncate_Bins", np.arange(time.size) + 1)) - 1
    if not kept[0] >= 0 or (np.diff(kept) != 1).any():
        msg = f"Truncate_Bins: expected consecutive indices from 1 up, found {kept[0] + 1:g} first"
        raise Refused(msg)
    # `Time` was truncated along with the data, or is as long as the padded traces were before.
    time_is_padded = kept.size < time.size
    content = {
        "Data": np.asarray(values["Data"]),
        "twtt": time[kept.astype(int)] if time_is_padded else time,
        "slow_time": utc_times(values["GPS_time" if is_gps else "UTC_time"], gps=is_gps),
    }
    content |= {name: values[name] for name in ALONG_TRACK if name in values}
    is_scaled = "minData" in values or "maxData" in values
    if is_scaled:
        with library_errors(path, "Data: expected integers scaled by minData and maxData"):
            content["Data"] = _unscaled(content["Data"], values)
    attributes = {"source_format": "CReSIS L1B MAT"}
    for struct in PARAMETER_STRUCTS:
        fields = values.get(struct)
        for name in PARAMETERS if isinstance(fields, dict) else ():
            if isinstance(fields.get(name), str) and fields[name]:
                attributes.setdefault(name, " ".join(fields[name].split())[:100])
    echogram = echogram_dataset(path, content, attributes, decibels=is_scaled)
    if "Elevation_Correction" not in echogram or compensated:
        return echogram
    padding = echogram["Elevation_Correction"].values.max() if time_is_padded else -np.inf
    return undo_compensation(echogram, -kept[0], time.size - padding - kept[0])


def _unscaled(data, values):
    """Decibels that integers stand for."""
    step_db = np.float32(values["maxData"] / np.iinfo(data.dtype).max)
    return data.astype(np.float32) * step_db + np.float32(values["minData"])
