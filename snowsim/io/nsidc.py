"""IRSNO1B NetCDF files of the snow and ice data centre: plain, deconv, uwb; with supplement."""

import re
from pathlib import Path

import numpy as np

from snowsim.io import datasets
from snowsim.io.containers import read_netcdf
from snowsim.io.guard import check_present, existing, matrix, one_line, refusal, vector
from snowsim.io.sniff import SUPPLEMENT_FLAGS, names_in

NEEDED = ("amplitude", "time", "fasttime", "lat", "lon", "altitude", "Surface")
ALONG_TRACK = {
    "lat": "Latitude",
    "lon": "Longitude",
    "altitude": "Elevation",
    "Surface": "Surface",
    "Bottom": "Bottom",
}
ATTITUDE = {"roll": "Roll", "pitch": "Pitch", "heading": "Heading"}
SECONDS = {
    "microseconds": 1e-6,
    "us": 1e-6,
    "nanoseconds": 1e-9,
    "ns": 1e-9,
    "seconds": 1.0,
    "s": 1.0,
}


def read_nsidc(path, *, compensated=False):
    """Echogram of an IRSNO1B file; see `snowsim.io.read_echogram`.

    `amplitude` (dB) becomes linear power, -inf (bins that elevation compensation inserted) becomes
    NaN; `time` (seconds of day, UTC) becomes `slow_time`, on past midnight; `fasttime` (us) becomes
    `twtt`; degrees of attitude become radians. With a supplement beside it, bit i of `quality_mask`
    (slow_time) is flag i of its `flag_meanings`.
    """
    path = existing(path)
    # As stored: no fill value is set in these files, and a default one must not hide a value.
    stored = read_netcdf(path, (*NEEDED, *ALONG_TRACK, *ATTITUDE, "Elevation_Correction"))
    check_present(path, NEEDED, stored.variables)
    seconds_of_day = vector(path, "time", stored["time"].values)
    seconds, n_midnights = datasets.unwrap_midnight(seconds_of_day)
    fast_time = vector(path, "fasttime", stored["fasttime"].values)
    if fast_time.size < 2:
        raise refusal(path, "fasttime", "two or more values", fast_time.size)
    n_lines = seconds.size
    content = {
        "Data": _power(path, stored, fast_time.size, n_lines),
        "twtt": fast_time * _scale(path, stored),
        "slow_time": datasets.from_utc_seconds(path, "time", seconds, _epoch(path, stored)),
    }
    for name, ours in (ALONG_TRACK | ATTITUDE).items():
        if name in stored:
            values = vector(path, name, stored[name].values, n_lines)
            content[ours] = np.radians(values) if name in ATTITUDE else values
    if "Elevation_Correction" in stored:
        name = "Elevation_Correction"
        bins = vector(path, name, stored[name].values, n_lines)
        if compensated:
            content[name] = bins
        else:
            content = datasets.undo_compensation(path, content, bins)
    attributes = {"source_format": "IRSNO1B NetCDF", "midnights_passed": n_midnights}
    attributes |= _parameters(path)
    echogram = datasets.echogram_dataset(path, content, attributes)
    supplement = find_supplement(path)
    if supplement is not None:
        echogram["quality_mask"] = _quality_mask(supplement, n_lines)
        echogram.attrs["supplement"] = supplement.name
    return echogram


def find_supplement(path):
    """The supplement that lies beside an IRSNO1B file, or None: the same name up to the frame."""
    path = Path(path)
    stems = [f"{path.stem}_supplement"]
    frame = re.match(r"(.*?\d{8}_\d{2}_\d{3})(.*)", path.stem)
    if frame:
        base, variant = frame.groups()
        stems += [f"{base}_supplement{variant}", f"{base}_supplement"]
    for stem in stems:
        supplement = path.with_name(f"{stem}.nc")
        if supplement.is_file():
            return supplement
    return None


def _power(path, stored, n_bins, n_lines):
    """Linear power (range_bin, range_line).

    Axes are recognised by the names of their dimensions, or by length where names do not say.
    """
    amplitude_db = stored["amplitude"].values
    dimensions = stored["amplitude"].dims
    down = stored["fasttime"].dims
    along = stored["time"].dims
    if dimensions == along + down and along != down and amplitude_db.shape == (n_lines, n_bins):
        amplitude_db = amplitude_db.T
    elif dimensions != down + along and n_bins == n_lines:
        raise refusal(path, "amplitude", f"dimensions {along + down}", dimensions)
    amplitude_db = matrix(path, "amplitude", amplitude_db, n_bins, n_lines)
    if amplitude_db.dtype.kind != "f":
        amplitude_db = amplitude_db.astype(np.float32)
    power = datasets.from_db(amplitude_db)
    power[np.isneginf(amplitude_db)] = np.nan
    return power


def _scale(path, stored):
    unit = str(stored["fasttime"].attrs.get("units", "")).strip().lower()
    unit = unit or "microseconds"
    if unit not in SECONDS:
        raise refusal(path, "fasttime", "units microseconds", unit)
    return SECONDS[unit]


def _epoch(path, stored):
    unit = str(stored["time"].attrs.get("units", "")).strip()
    date = re.fullmatch(r"seconds since (\d{4}-\d{2}-\d{2})([ T]00:00:00(\.0+)?Z?)?", unit)
    try:
        return str(np.datetime64(date.group(1), "D"))
    except (AttributeError, ValueError) as error:
        expected = "units 'seconds since YYYY-MM-DD 00:00:00'"
        raise refusal(path, "time", expected, repr(unit)) from error


def _parameters(path):
    """Season, radar and segment: NUL-padded characters under `param_*.season_name` and the like."""
    found = {}
    for name in sorted(names_in(path)):
        parameter = name.rpartition(".")[2]
        if name.startswith("param") and parameter in datasets.PARAMETERS:
            found.setdefault(parameter, name)
    dataset = read_netcdf(path, found.values())
    return {parameter: _text(dataset[name].values) for parameter, name in found.items()}


def _text(values):
    """Text of an array of characters, one byte each or one number each."""
    characters = values.ravel().tolist()
    if values.dtype.kind == "S":
        text = b"".join(characters).decode("latin-1")
    elif values.dtype.kind in "iu":
        text = "".join(chr(code) for code in characters if 0 < code < 0x110000)
    else:
        text = "".join(map(str, characters))
    return one_line(text.replace("\0", ""), 100)


def _quality_mask(path, n_lines):
    stored = read_netcdf(path, SUPPLEMENT_FLAGS)
    if not stored.variables:
        raise refusal(path, "supplement", f"flags {', '.join(SUPPLEMENT_FLAGS)}", "none of them")
    bits = 1 << np.arange(len(SUPPLEMENT_FLAGS), dtype=np.uint8)
    mask = np.zeros(n_lines, dtype=np.uint8)
    for bit, name in zip(bits, SUPPLEMENT_FLAGS, strict=True):
        if name in stored:
            flags = vector(path, name, stored[name].values)
            # Set for a frame as a whole, or line by line.
            if flags.size not in (1, n_lines):
                raise refusal(path, name, f"1 or {n_lines} values", f"shape {stored[name].shape}")
            mask |= bit * (flags != 0).astype(np.uint8)
    return "slow_time", mask, {"flag_masks": bits, "flag_meanings": " ".join(SUPPLEMENT_FLAGS)}
