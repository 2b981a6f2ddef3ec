"""IRSNO1B NetCDF files of the snow and ice data centre: plain, deconv, uwb; with supplement."""

import re
from pathlib import Path

import numpy as np

from snowsim.io.containers import read_netcdf
from snowsim.io.datasets import (
    PARAMETERS,
    echogram_dataset,
    in_seconds,
    undo_compensation,
    utc_times,
)
from snowsim.io.guard import Refused, library_errors
from snowsim.io.sniff import SUPPLEMENT_FLAGS

ALONG_TRACK = {
    "lat": "Latitude",
    "lon": "Longitude",
    "altitude": "Elevation",
    "Surface": "Surface",
    "Bottom": "Bottom",
    "Elevation_Correction": "Elevation_Correction",
    "roll": "Roll",
    "pitch": "Pitch",
    "heading": "Heading",
}
ATTITUDE = ("Roll", "Pitch", "Heading")
HALF_DAY_S = 43200


def read_nsidc(path, *, compensated=False):
    """Echogram of an IRSNO1B file; see `snowsim.io.read_echogram`.

    `amplitude` (dB) becomes linear power, -inf (bins that elevation compensation inserted) becomes
    NaN; `time` (seconds of day, UTC) becomes `slow_time`, on past midnight; `fasttime` (us) becomes
    `twtt`; degrees of attitude become radians. With a supplement beside it, bit i of `quality_mask`
    (slow_time) is flag i of its `flag_meanings`.
    """
    # As stored: no fill value is set in these files, and a default one must not hide a value.
    stored = read_netcdf(path)
    axes = (*stored["fasttime"].dims, *stored["time"].dims)
    seconds_of_day = np.ravel(stored["time"]).astype(float)
    midnights = np.cumsum(np.append(False, np.diff(seconds_of_day) < -HALF_DAY_S))
    epoch = str(stored["time"].attrs.get("units", "")).removeprefix("seconds since ")
    content = {
        "Data": stored["amplitude"].transpose(*axes).values,
        "twtt": in_seconds(stored["fasttime"], "us").values,
        "slow_time": utc_times(seconds_of_day + 2 * HALF_DAY_S * midnights, epoch),
    }
    for theirs, ours in ALONG_TRACK.items():
        if theirs in stored:
            values = np.ravel(stored[theirs]).astype(float)
            content[ours] = np.radians(values) if ours in ATTITUDE else values
    attributes = {"source_format": "IRSNO1B NetCDF"}
    for name in sorted(stored.variables):
        parameter = name.rpartition(".")[2]
        if name.startswith("param") and parameter in PARAMETERS:
            # Characters, padded with NUL.
            text = b"".join(np.ravel(stored[name]).astype(bytes)).decode("latin-1")
            attributes.setdefault(parameter, " ".join(text.replace("\0", "").split())[:100])
    echogram = echogram_dataset(path, content, attributes, decibels=True)
    if "Elevation_Correction" in echogram and not compensated:
        echogram = undo_compensation(echogram)
    supplement = find_supplement(path)
    if supplement is not None:
        echogram["quality_mask"] = _quality_mask(supplement, seconds_of_day.size)
        echogram.attrs["supplement"] = supplement.name
    return echogram


def find_supplement(path):
    """The supplement that lies beside an IRSNO1B file, or None: the same name up to the frame."""
    path = Path(path)
    base, variant = re.fullmatch(r"(.*?\d{8}_\d{2}_\d{3}|.*?)(.*)", path.stem).groups()
    stems = (f"{path.stem}_supplement", f"{base}_supplement{variant}", f"{base}_supplement")
    files = (path.with_name(f"{stem}.nc") for stem in stems if base or stem == stems[0])
    return next((file for file in files if file.is_file()), None)


def _quality_mask(path, n_lines):
    """Flags of a supplement, set for a frame as a whole or line by line."""
    stored = read_netcdf(path)
    flags = np.zeros((len(SUPPLEMENT_FLAGS), n_lines), dtype=bool)
    with library_errors(path, f"supplement: expected flags of 1 or {n_lines} lines"):
        if not stored.variables.keys() & set(SUPPLEMENT_FLAGS):
            msg = f"supplement: expected flags {', '.join(SUPPLEMENT_FLAGS)}, found none of them"
            raise Refused(msg)
        for row, name in enumerate(SUPPLEMENT_FLAGS):
            if name in stored:
                flags[row] = stored[name].values != 0
    (mask,) = np.packbits(flags, axis=0, bitorder="little")
    bits = 1 << np.arange(len(SUPPLEMENT_FLAGS), dtype=np.uint8)
    return "slow_time", mask, {"flag_masks": bits, "flag_meanings": " ".join(SUPPLEMENT_FLAGS)}
