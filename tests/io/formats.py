"""Small files of every format, written to the published field tables.

No real echogram may be shipped with the tests. Names, units, orientations and traps are those of
the CReSIS toolbox and of the IRSNO1B files: MATLAB writes NetCDF dimensions the other way round,
v7.3 files are HDF5 with transposed arrays, text as numbers and cells as references.
"""

import h5py
import numpy as np
import pytest
import scipy.io
import xarray as xr

from snowsim.constants import SPEED_OF_LIGHT_M_S
from snowsim.echogram import to_db

BIN_S = 2.886e-10
GPS_START = 1_333_065_600.0 + 15  # 2012-03-30 00:00:00 UTC, 15 leap seconds then
N_BINS, N_LINES = 120, 40
SURFACE_BIN = 30
LAYERS_FILE, ORGANIZER_FILE = "Data_20120330_04_001.mat", "layer_20120330_04.mat"
TABLE_HEADER = "frame\techogram\tlayers\trole"


def refused(read, path, message):
    """Check that a reader refuses a file in one line that begins with its name; give the line."""
    with pytest.raises(ValueError, match=message) as error:
        read(path)
    line = str(error.value)
    assert "\n" not in line
    assert line.startswith(str(path))
    return line


def failures(call, n_failed, n_all):
    """Lines of the one error that tells of all frames or scenes that fail, but the first.

    That one tells how many fail.
    """
    with pytest.raises(ValueError, match=f"{n_failed} of {n_all} (frames|scenes) fail") as error:
        call()
    lines = str(error.value).splitlines()[1:]
    assert len(lines) == n_failed
    return lines


def truth(rng, n_bins=N_BINS, n_lines=N_LINES, n_above=0):
    """Linear power with a bright surface below rows of air, and what an L1B file has along."""
    power = rng.gamma(4, 0.25e-3, size=(n_bins + n_above, n_lines)).astype(np.float32)
    surface_bins = SURFACE_BIN + n_above + np.arange(n_lines) % 3
    power[surface_bins, np.arange(n_lines)] = 1.0
    time = 3e-6 + BIN_S * np.arange(-n_above, n_bins)
    return {
        "Data": power,
        "Time": time,
        "GPS_time": GPS_START + 0.05 * np.arange(n_lines),
        "Latitude": 70 + 1e-5 * np.arange(n_lines),
        "Longitude": -40 + 1e-5 * np.arange(n_lines),
        "Elevation": np.full(n_lines, 2500.0),
        "Roll": np.full(n_lines, 0.01),
        "Pitch": np.full(n_lines, 0.02),
        "Heading": np.full(n_lines, 1.5),
        "Surface": time[surface_bins],
    }


def content_of(echogram, gps_time, first_s=0.0):
    """What an L1B file holds of an echogram dataset, its travel times counted from `first_s`."""
    names = ("Latitude", "Longitude", "Elevation")
    return {name: echogram[name].values for name in names} | {
        "Data": echogram["Data"].transpose("twtt", "slow_time").values,
        "Time": first_s + echogram["twtt"].values,
        "GPS_time": gps_time,
        "Surface": first_s + echogram["Surface"].values,
        **dict.fromkeys(("Roll", "Pitch", "Heading"), np.zeros(gps_time.size)),
    }


def slow_time(gps_time):
    """UTC of GPS seconds of that day, to the nanosecond as far as float64 seconds hold them."""
    nanoseconds = np.rint((np.asarray(gps_time) - GPS_START) * 1e9)
    return np.datetime64("2012-03-30", "ns") + nanoseconds.astype("timedelta64[ns]")


def check_times(dataset, gps_time):
    """Seconds since 1970 are doubles, 2.4e-7 s apart."""
    late = np.abs(dataset["slow_time"].values - slow_time(gps_time))
    assert (late <= np.timedelta64(300, "ns")).all()


def write_nsidc(path, content, *, transposed=False, seconds=None, drop=(), format="NETCDF4"):
    """An IRSNO1B file: dB, seconds of day, microseconds, degrees; dimensions as of MATLAB."""
    seconds = np.asarray(content["GPS_time"]) - GPS_START if seconds is None else seconds
    amplitude = (("fasttime", "time"), to_db(content["Data"]), {"units": "counts in dB"})
    variables = {
        "amplitude": amplitude,
        "time": ("time", seconds, {"units": "seconds since 2012-03-30 00:00:00"}),
        "fasttime": ("fasttime", content["Time"] * 1e6, {"units": "microseconds"}),
        "Surface": ("time", content["Surface"], {"units": "seconds"}),
        "param_records.season_name": np.array(b"2012_Greenland_P3".ljust(24, b"\0")),
        "param_records.radar.wfs(1).f0": ("text", np.zeros(24)),
    }
    for theirs, ours in {"lat": "Latitude", "lon": "Longitude", "altitude": "Elevation"}.items():
        variables[theirs] = ("time", content[ours])
    for name in ("Roll", "Pitch", "Heading"):
        variables[name.lower()] = ("time", np.degrees(content[name]), {"units": "degrees"})
    if "Elevation_Correction" in content:
        variables["Elevation_Correction"] = ("time", content["Elevation_Correction"])
    file = xr.Dataset(variables, attrs={"min_time_bound": "20120330T00:00:15 GPS"})
    file = file.drop_vars(drop) if transposed else file.drop_vars(drop).transpose("time", ...)
    no_fill = {name: {"_FillValue": None} for name in file.variables}
    file.to_netcdf(path, format=format, encoding=no_fill)


def write_supplement(path, **flags):
    flags = {name: np.atleast_1d(np.asarray(value, dtype="u1")) for name, value in flags.items()}
    xr.Dataset({name: (f"n{value.size}", value) for name, value in flags.items()}).to_netcdf(path)


def write_flight(folder, content, echograms):
    """Table `frames.tsv` of echograms (file and role), and their layer file.

    Layers are the surface and one 40 bins below.
    """
    surface = content["Surface"]
    layers = layer_content([surface + 40 * BIN_S, surface], [5, 9], content["GPS_time"])
    write_mat5(folder / LAYERS_FILE, layers)
    write_mat5(folder / ORGANIZER_FILE, organizer_content([5, 9], ["Koenig_2", "surface"]))
    rows = [f"{name}\t{file}\t{LAYERS_FILE}\t{role}" for name, (file, role) in echograms.items()]
    (folder / "frames.tsv").write_text("\n".join(["# a remark", TABLE_HEADER, *rows]))


def write_nsidc_flight(folder, rng, roles, n_lines):
    """IRSNO1B frames, one a role and called so, their layers and table.

    They have 50 rows above the surface as a block has.
    """
    content = truth(rng, n_bins=400, n_lines=n_lines, n_above=40)
    for number, role in enumerate(roles):  # power of its own: a held-out frame is no copy
        own = content | {"Data": content["Data"] * (1 + 1e-3 * number)}
        write_nsidc(folder / f"{role}.nc", own)
    write_flight(folder, content, {role: (f"{role}.nc", role) for role in roles})


def as_matlab(content):
    """Some vectors are columns in MATLAB; others are written as rows."""
    names = [name for name in ("Time", "Truncate_Bins") if np.ndim(content.get(name)) == 1]
    return content | {name: content[name][:, None] for name in names}


def write_mat5(path, content, *, compress=True):
    scipy.io.savemat(path, as_matlab(content), do_compression=compress)


def write_mat73(path, content):
    """HDF5 as MATLAB has it: user block, transposed arrays, text as uint16, cells as references."""
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, value in as_matlab(content).items():
            _put73(file, file, name, value)
    with open(path, "r+b") as raw:
        raw.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124, b" ") + b"\x00\x02IM")


def _put73(file, group, name, value):
    if isinstance(value, dict):
        node = group.create_group(name)
        for key, item in value.items():
            _put73(file, node, key, item)
        return
    array = np.asarray(value)
    if isinstance(value, str):
        stored = np.frombuffer(value.encode("utf-16-le"), dtype="u2")[:, None]
    elif array.dtype.kind in "OU":
        cells = file.require_group("#refs#")
        stored = np.empty((array.size, 1), dtype=h5py.ref_dtype)
        for row, item in enumerate(array.flat):
            key = f"r{len(cells)}"
            _put73(file, cells, key, item)
            stored[row] = cells[key].ref
    else:
        stored = np.atleast_2d(array).T if array.size else np.array(array.shape, dtype="u8")
    node = group.create_dataset(name, data=stored)
    if isinstance(value, str):
        node.attrs["MATLAB_class"] = np.bytes_("char")
    if array.size == 0:
        node.attrs["MATLAB_empty"] = np.uint8(1)


def compensated(content, correction, *, n_kept, first=0, truncate_time=False):
    """What the toolbox's compression makes of an echogram: traces lower, zeros above, NaN below."""
    correction = np.asarray(correction)
    n_bins, n_lines = content["Data"].shape
    padded = np.full((n_bins + correction.max(), n_lines), np.nan, dtype=content["Data"].dtype)
    for line, bins in enumerate(correction):
        padded[:bins, line] = 0
        padded[bins : bins + n_bins, line] = content["Data"][:, line]
    time = content["Time"][0] + BIN_S * np.arange(padded.shape[0])
    kept = slice(first, first + n_kept)
    return content | {
        "Data": padded[kept],
        "Time": time[kept] if truncate_time else time,
        "Elevation": content["Elevation"] + correction * BIN_S * SPEED_OF_LIGHT_M_S / 2,
        "Surface": content["Surface"] + correction * BIN_S,
        "Elevation_Correction": correction.astype(float),
        "Truncate_Bins": np.arange(first, first + n_kept) + 1.0,
    }


def layer_content(twtt, ids, gps_time, *, elevation=2500.0):
    """A new layer file: twtt (Nl, Nx)."""
    twtt = np.atleast_2d(twtt)
    n_lines = np.size(gps_time)
    return {
        "gps_time": np.asarray(gps_time),
        "lat": np.full(n_lines, 70.0),
        "lon": np.full(n_lines, -40.0),
        "elev": np.full(n_lines, elevation),
        "id": np.asarray(ids, dtype=float),
        "twtt": twtt,
        "quality": np.ones(twtt.shape, dtype=np.uint8),
        "type": np.full(twtt.shape, 2, dtype=np.uint8),
    }


def cell(items):
    """A row of MATLAB's cells."""
    return np.fromiter(items, dtype=object)[None]


def organizer_content(ids, names, groups=None):
    return {
        "lyr_id": np.asarray(ids, float),
        "lyr_name": cell(names),
        "lyr_group_name": cell(groups or [""] * len(names)),
        "lyr_order": np.asarray(ids),
    }


def old_layer_content(twtt, gps_time, names):
    """An old layer file: a cell of structs."""
    entries = []
    for row, name in zip(twtt, names, strict=True):
        manual = np.where(np.arange(row.size) == 0, row, np.nan)
        entry = {"value": cell([{"data": manual}, {"data": row}]), "quality": np.ones(row.size)}
        if name:
            entry["name"] = name
        entries.append(entry)
    positions = {"Latitude": 70.0, "Longitude": -40.0, "Elevation": 2500.0}
    along = {name: np.full(np.size(gps_time), value) for name, value in positions.items()}
    return {"GPS_time": np.asarray(gps_time), "layerData": cell(entries), **along}


def opr_dataset(content):
    """The same echogram as an Open Polar Radar dataset."""
    variables = {"Data": (("twtt", "slow_time"), content["Data"])}
    for name, values in content.items():
        if name not in ("Data", "Time", "GPS_time"):
            variables[name] = ("slow_time", values)
    coords = {
        "twtt": ("twtt", content["Time"], {"units": "s"}),
        "slow_time": slow_time(content["GPS_time"]),
    }
    return xr.Dataset(variables, coords)


def opr_layers(twtt, gps_time, names=None):
    twtt = np.atleast_2d(twtt)
    coords = {"slow_time": slow_time(gps_time)}
    if names is not None:
        coords["layer"] = np.asarray(names, dtype=str)
    dimensions = ("layer", "slow_time")
    variables = {"twtt": (dimensions, twtt, {"units": "s"})}
    for name in ("quality", "type"):
        variables[name] = (dimensions, np.ones(twtt.shape, dtype=np.uint8))
    return xr.Dataset(variables, coords)


of_mat = pytest.mark.parametrize("write", [write_mat5, write_mat73], ids=["mat5", "mat73"])
