"""IRSNO1B NetCDF files of the snow and ice data centre: plain, deconvolved, ultra-wideband; with their supplement."""

import re
from pathlib import Path

import numpy as np

from snowsim.io.containers import read_netcdf
from snowsim.io.datasets import echogram_dataset, from_utc_seconds, undo_compensation, unwrap_midnight
from snowsim.io.guard import container_of, existing, matrix, numeric, one_line, refusal, vector
from snowsim.io.sniff import SUPPLEMENT_FLAGS, names_in

NEEDED = ("amplitude", "time", "fasttime", "lat", "lon", "altitude", "Surface")
ATTITUDE = {"roll": "Roll", "pitch": "Pitch", "heading": "Heading"}
SECONDS = {"microseconds": 1e-6, "us": 1e-6, "nanoseconds": 1e-9, "ns": 1e-9, "seconds": 1.0, "s": 1.0}
# Parameters are flattened into variable names; of all that is there, this much goes with the dataset.
PARAMETERS = ("season_name", "radar_name", "day_seg")


def read_nsidc(path, *, compensated=False, supplement=None):
    """Echogram of an IRSNO1B file.

    `amplitude` (dB) becomes linear power, -inf (bins that elevation compensation inserted) becomes NaN; `time`
    (seconds of day, UTC) becomes `slow_time`, on past midnight; `fasttime` (us) becomes `twtt`; degrees of attitude
    become radians; elevation compensation is undone.

    Parameters
    ----------
    path : path_like
    compensated : bool
        Keep the traces as stored, shifted by `Elevation_Correction`, which then goes with the dataset.
    supplement : path_like, optional
        File of quality flags; by default the one beside `path` that is named after it.

    Returns
    -------
    xarray.Dataset
        As `snowsim.echogram.check_echogram` wants it; `quality_mask (slow_time)` if there is a supplement, bit i for
        flag i of the attribute `flag_meanings`.

    Raises
    ------
    ValueError
        One line with file, variable, expected and found, for every file that is not as described.
    """
    path = existing(path)
    values, dimensions, units = _read_variables(path, (*NEEDED, *ATTITUDE, "Bottom", "Elevation_Correction"))
    for name in NEEDED:
        if name not in values:
            raise refusal(path, name, f"variables {', '.join(NEEDED)}", one_line(", ".join(sorted(values)), 200))
    seconds, n_midnights = unwrap_midnight(vector(path, "time", values["time"]))
    twtt = vector(path, "fasttime", values["fasttime"])
    if twtt.size < 2:
        raise refusal(path, "fasttime", "two or more values", twtt.size)
    n_lines = seconds.size
    content = {
        "Data": _power(path, values["amplitude"], dimensions, twtt.size, n_lines),
        "twtt": twtt * _scale(path, units),
        "slow_time": from_utc_seconds(path, "time", seconds, _epoch(path, units)),
    }
    for name, ours in {"lat": "Latitude", "lon": "Longitude", "altitude": "Elevation", "Surface": "Surface"}.items():
        content[ours] = vector(path, name, values[name], n_lines)
    for name, ours in ATTITUDE.items():
        if name in values:
            content[ours] = np.radians(vector(path, name, values[name], n_lines))
    if "Bottom" in values:
        content["Bottom"] = vector(path, "Bottom", values["Bottom"], n_lines)
    if "Elevation_Correction" in values:
        bins = vector(path, "Elevation_Correction", values["Elevation_Correction"], n_lines)
        if compensated:
            content["Elevation_Correction"] = ("slow_time", bins, {"units": "range bins"})
        else:
            content = undo_compensation(path, content, bins)
    supplement = find_supplement(path) if supplement is None else existing(supplement)
    if supplement is not None:
        content["quality_mask"] = _quality_mask(supplement, n_lines)
    attributes = {"source_format": "IRSNO1B NetCDF", "midnights_passed": n_midnights, **_parameters(path)}
    attributes["supplement"] = None if supplement is None else supplement.name
    return echogram_dataset(path, content, attributes)


def find_supplement(path):
    """The supplement file that lies beside an IRSNO1B file, or None: the same name up to the frame number."""
    path = Path(path)
    frame = re.match(r".*?\d{8}_\d{2}_\d{3}", path.stem)
    variant = path.stem[frame.end() :] if frame else ""
    base = frame.group() if frame else path.stem
    names = [f"{path.stem}_supplement.nc", f"{base}_supplement{variant}.nc", f"{base}_supplement.nc"]
    return next((path.with_name(name) for name in names if path.with_name(name).is_file()), None)


def _read_variables(path, names):
    """Values, dimension names and units of the variables that are there."""
    dataset = read_netcdf(path, names)
    # As stored: no fill value is set in these files, and a default one must not hide a value.
    values = {name: numeric(path, name, dataset[name].values) for name in names if name in dataset.variables}
    dimensions = {name: dataset[name].dims for name in values}
    units = {name: str(dataset[name].attrs.get("units", "")) for name in values}
    return values, dimensions, units


def _power(path, amplitude_db, dimensions, n_bins, n_lines):
    """Linear power (range_bin, range_line): axes by the names of their dimensions, by length where those do not say."""
    fast, slow = dimensions["fasttime"], dimensions["time"]
    if dimensions["amplitude"] == (*slow, *fast) and fast != slow and amplitude_db.shape == (n_lines, n_bins):
        amplitude_db = amplitude_db.T
    elif dimensions["amplitude"] != (*fast, *slow) and n_bins == n_lines:
        raise refusal(path, "amplitude", f"dimensions {(*slow, *fast)}", dimensions["amplitude"])
    amplitude_db = matrix(path, "amplitude", amplitude_db, n_bins, n_lines)
    if amplitude_db.dtype.kind != "f":
        amplitude_db = amplitude_db.astype(np.float32)
    missing = np.isneginf(amplitude_db)
    with np.errstate(over="ignore"):  # infinite power is refused by name further on
        power = 10 ** (amplitude_db / 10)
    power[missing] = np.nan
    return power


def _scale(path, units):
    unit = units["fasttime"].strip().lower() or "microseconds"
    if unit not in SECONDS:
        raise refusal(path, "fasttime", "units microseconds", unit)
    return SECONDS[unit]


def _epoch(path, units):
    date = re.fullmatch(r"seconds since (\d{4}-\d{2}-\d{2})([ T]00:00:00(\.0+)?Z?)?", units["time"].strip())
    try:
        return str(np.datetime64(date.group(1), "D"))
    except (AttributeError, ValueError) as error:
        expected = "units 'seconds since YYYY-MM-DD 00:00:00'"
        raise refusal(path, "time", expected, repr(units["time"])) from error


def _parameters(path):
    """Season, radar and segment: text kept as NUL-padded characters under `param_*.season_name` and the like."""
    container, found = container_of(path), {}
    for name in sorted(names_in(path, container)):
        parameter = name.rpartition(".")[2]
        if name.startswith("param") and parameter in PARAMETERS and parameter not in found:
            found[parameter] = _text(read_netcdf(path, [name])[name].values)
    return found


def _text(values):
    """Text of an array of characters, one byte each or one number each."""
    if values.dtype.kind == "S":
        text = b"".join(values.ravel().tolist()).decode("latin-1")
    elif values.dtype.kind in "iu":
        text = "".join(chr(value) for value in values.ravel().tolist() if 0 < value < 0x110000)
    else:
        text = "".join(map(str, values.ravel().tolist()))
    return one_line(text.replace("\0", ""), 100)


def _quality_mask(path, n_lines):
    values, _, _ = _read_variables(path, SUPPLEMENT_FLAGS)
    if not values:
        raise refusal(path, "supplement", f"flags {', '.join(SUPPLEMENT_FLAGS)}", "none of them")
    mask = np.zeros(n_lines, dtype=np.uint8)
    for bit, name in enumerate(SUPPLEMENT_FLAGS):
        if name in values:
            flags = vector(path, name, values[name])
            if flags.size not in (1, n_lines):  # flags are set for a frame as a whole, or line by line
                raise refusal(path, name, f"1 or {n_lines} values", f"shape {values[name].shape}")
            mask |= np.uint8(1 << bit) * (flags != 0).astype(np.uint8)
    bits = np.array([1 << bit for bit in range(len(SUPPLEMENT_FLAGS))], dtype=np.uint8)
    return "slow_time", mask, {"flag_masks": bits, "flag_meanings": " ".join(SUPPLEMENT_FLAGS)}
