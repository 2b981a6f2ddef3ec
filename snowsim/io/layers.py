"""Layer files of every format, read and written; contract of readers: `snowsim.io.containers`."""

import itertools
import re
import warnings
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from snowsim.echogram import UNITS, check_choice, check_layers, crossing_layers, named_frame
from snowsim.io.containers import (
    POSITION,
    format_of,
    one_line_errors,
    opened,
    read_values,
    write_matlab,
)
from snowsim.io.echograms import l1b_content, parameters
from snowsim.io.files import library_errors, locked, one_line, refusal, write_dataset
from snowsim.io.times import gps_seconds, utc_times

SURFACE = "surface"
TRACKED = "snow_"  # names of layers that `snowsim track` found begin so
# What the first two entries of an old file are where it gives no names: the format's convention.
OLD_NAMES = ("surface", "bottom")
AXES = ("layer", "slow_time")
# What a dataset holds on them, and its attributes.
PICKS = {
    "twtt": {"units": "s"},
    "quality": {"flag_values": "1 good, 2 moderate, 3 bad"},
    "type": {"flag_values": "1 manual, 2 automatic"},
}
MANUAL = 1
# Where nobody picked.
ABSENT = {"quality": 1, "type": 2}
# So far the surface of one line cannot lie above that of all others: 30 m of air, or 1.5 m if it is
# that many times as far as any others of them are apart.
FAR_S = 2e-7
NEAR_S = 1e-8
N_GAPS = 5
# Names in old files, and of Open Polar Radar, by those of new ones.
RENAMED = {"gps_time": "GPS_time", "lat": "Latitude", "lon": "Longitude", "elev": "Elevation"}


def read_layers(path, *, names=None, missing="refuse"):
    """Layers dataset of a file, whose format is determined from its content.

    Parameters
    ----------
    path : path_like
        CReSIS layer file, new (names from the organizer file beside it) or old, or an Open Polar
        Radar layers dataset.
    names : iterable of str, optional
        Read these layers only, such as ``["surface", "Koenig_2"]``.
    missing : {"refuse", "skip"}
        What becomes of a file that has no layer of one of the `names`.

    Returns
    -------
    xarray.Dataset
        `twtt` [s], `quality`, `type` on (layer, slow_time), from the snow surface down; `layer`
        holds the names. The attribute `place` of `twtt` is "interface" or "peak" (of the echo)
        where the file says it, as files of snowsim do. `peak_twtt` is the peak of the echo of a
        simulated interface.

    Raises
    ------
    ValueError
        One line, with file, variable, expected and found, for any file that is not a sound set of
        layers; also where no layer has a pick, or where layers cross.

    Examples
    --------
    >>> from snowsim import Climate, simulate
    >>> _, drawn = simulate(Climate(accumulation_m=0.3), "snow-2012", n_range_lines=64, rng=1)
    >>> _ = drawn.to_netcdf("layers.nc")
    >>> layers = read_layers("layers.nc")
    >>> layers["twtt"].dims, int(layers["layer"][0])
    (('layer', 'slow_time'), 0)
    """
    check_choice("missing", missing, ("refuse", "skip"))
    names = [names] if isinstance(names, str) else names
    return _read_layers(path, names, missing)


@one_line_errors()
def _read_layers(path, names, missing):
    """Layers of a file, checked; the arguments are those of `read_layers`, and checked before."""
    readers = {
        "cresis_layer": read_cresis_layers,
        "cresis_layer_data": read_cresis_layer_data,
        "opr_layers": read_opr_layers,
    }
    stored = opened(path)
    kind = format_of(stored, readers)
    return chosen(readers[kind](stored), names, missing, stored.path)


def open_segment(paths):
    """Layers of the frames of a segment as one dataset, frames in order of their times.

    Parameters
    ----------
    paths : iterable of path_like
        Files that `read_layers` reads, such as the `NAME_layers.nc` of `snowsim track`.

    Returns
    -------
    xarray.Dataset
        As of `read_layers`; a layer of the same name is the same in all frames, NaN where a frame
        lacks it. Layers come by their names: the surface, then by number; from the surface
        down where they would cross. `frame` along slow_time
        is the name of the file.

    Raises
    ------
    ValueError
        In one line: no file, one that `read_layers` refuses, frames that overlap in time, or
        tracked frames of several segments.
    """
    paths = list(paths)
    where = "segment"
    if not paths:
        raise refusal(where, "files", "those of its frames", "none")
    frames = []
    segments = set()
    for path in paths:
        layers = read_layers(path)
        if any(str(name).startswith(TRACKED) for name in layers.get_index("layer")):
            segment, _ = named_frame(layers.attrs.get("granule", path))
            segments |= {segment} - {None}
        frame = Path(path).stem.removesuffix("_layers")
        names = ("slow_time", np.full(layers.sizes["slow_time"], frame, dtype=object))
        frames.append(layers.assign_coords(frame=names))
    if len(segments) > 1:
        told = " and ".join(sorted(segments))
        expected = f"one, of which alone {TRACKED}1, {TRACKED}2 and so on are the same layers"
        raise refusal(where, "segments", expected, told)
    frames.sort(key=lambda frame: frame["slow_time"].values[0])
    for first, second in itertools.pairwise(frames):
        if second["slow_time"].values[0] <= first["slow_time"].values[-1]:
            names = " and ".join(str(each["frame"].values[0]) for each in (first, second))
            raise refusal(where, names, "frames that follow one another", "frames overlap in time")
    joined = xr.concat(
        frames,
        "slow_time",
        data_vars="all",
        coords="minimal",
        compat="override",
        join="outer",
        fill_value=ABSENT,
        combine_attrs="drop_conflicts",
    )
    names = joined["layer"].values
    in_order = sorted(names, key=lambda name: (name != SURFACE, len(str(name)), name))
    by_name = joined.sel(layer=in_order)
    twtt = by_name["twtt"].transpose(*AXES).values
    if crossing_layers(twtt).any():  # names that are years, or have a group
        by_name = by_name.isel(layer=order_from_surface(twtt, list(map(str, in_order))))
    check_layers(by_name, f"{where} of {paths[0]}")
    return by_name


def read_cresis_layers(stored):
    """Layers of a new CReSIS layer file (`CSARP_layer`).

    Names come from the organizer file `layer_YYYYMMDD_SS.mat` beside it (group:name where a name
    comes twice), without one they are "id 1", "id 2", ...
    """
    values = stored.read(("id", *PICKS, *RENAMED, "peak_twtt", "place"))
    values = {RENAMED.get(name, name): value for name, value in values.items()}
    if "id" not in values or "twtt" not in values:
        expected = "at least one layer with picks"
        raise refusal(stored.path, "twtt", expected, "no layer (MATLAB_empty)")
    ids = np.ravel(values["id"])
    shape = (ids.size, np.size(values["GPS_time"]))
    absent = {name: np.full(shape, value) for name, value in ABSENT.items()}
    picks = {name: np.asarray((absent | values)[name]) for name in PICKS}
    # A single layer, or line, comes without its axis.
    picks = {name: of if of.ndim == 2 else of.reshape(shape) for name, of in picks.items()}
    named = _organized(stored.path)
    names = [named.get(number, (f"id {number:g}", "")) for number in ids]
    dataset = _layers_dataset(values, picks, names, "CReSIS layer")
    if "peak_twtt" in values:
        dataset["peak_twtt"] = (
            AXES,
            np.reshape(values["peak_twtt"], shape),
            {"units": "s", "place": "peak"},
        )
    if "place" in values:
        dataset["twtt"].attrs["place"] = values["place"]
    elif _is_simulated(stored.path):
        dataset["twtt"].attrs["place"] = "interface"
    return dataset


def read_cresis_layer_data(stored):
    """Layers of an old CReSIS layer file (`CSARP_layerData`).

    Picks are `layerData{i}.value{2}.data`; where `value{1}` has a manual pick, the type is 1, else
    2. Entries without a name are the surface and the bottom, in this order, as the format has it.
    """
    values = stored.read(("GPS_time", "layerData", *POSITION))
    entries = values["layerData"]
    entries = [entries] if isinstance(entries, dict) else entries
    n_lines = np.size(values["GPS_time"])
    picks = {name: [] for name in PICKS}
    names = []
    for number, entry in enumerate(entries):
        manual, automatic = (np.ravel(value["data"]) for value in entry["value"][:2])
        quality = np.ravel(entry.get("quality", ()))
        picks["twtt"].append(automatic)
        picks["quality"].append(
            quality if quality.size == n_lines else np.full(n_lines, ABSENT["quality"])
        )
        types = np.full(n_lines, ABSENT["type"])
        types[np.flatnonzero(np.isfinite(manual))] = MANUAL
        picks["type"].append(types)
        unnamed = OLD_NAMES[number] if number < len(OLD_NAMES) else f"layer {number + 1}"
        names.append((_text(entry.get("name")) or unnamed, _text(entry.get("group_name"))))
    return _layers_dataset(values, picks, names, "CReSIS layerData")


def read_opr_layers(stored):
    """Layers dataset of Open Polar Radar as it stands on disk, (layer, slow_time).

    A single layer without a `layer` dimension gets one.
    """
    dataset = stored.read()
    for name in PICKS:
        if dataset[name].dims == ("slow_time",):
            dataset[name] = dataset[name].expand_dims("layer")
    return dataset.transpose(*AXES, ...)


def chosen(dataset, names, missing, where):
    """Layers of the names wanted, checked.

    Where layers have names, only those with picks, from the surface down; numbered ones keep their
    order, the first being the surface.
    """
    index = dataset.get_index("layer")  # numbers where the file has no coordinate of this name
    named = index.dtype.kind in "OUS"
    labels = index.astype(str)
    wanted = labels if names is None else pd.Index(list(names), dtype=str)
    # Zero is no travel time: it stands where nobody picked.
    dataset["twtt"] = dataset["twtt"].where(dataset["twtt"] != 0)
    has_picks = dataset["twtt"].notnull().any("slow_time").values
    keep = np.flatnonzero(labels.isin(wanted) & (has_picks | (not named)))
    absent = missing == "refuse" and not wanted.isin(labels).all()
    if absent or labels.has_duplicates or not has_picks[keep].any():
        expected = f"layers with picks, named {one_line(', '.join(wanted), 150)}"
        found = one_line(", ".join(labels[has_picks]), 150) or "none"
        raise refusal(where, "layer", expected, f"them in {found}")
    if named:
        keep = keep[order_from_surface(dataset["twtt"].values[keep], list(labels[keep]))]
    dataset = _without_placeholders(dataset.isel(layer=keep), where)
    check_layers(dataset, str(where))
    return dataset


def _without_placeholders(dataset, where):
    """Layers without lines of the uppermost that hold one time far above the others; warns of it.

    It stands for the first range bin, where nobody picked.
    """
    surface_s = dataset["twtt"][0].values
    times_s = np.unique(surface_s[np.isfinite(surface_s)])
    is_first = np.isin(surface_s, times_s[:1])
    gap_s, others_s = np.split(np.diff(times_s), [1])
    far_s = min(FAR_S, max(NEAR_S, N_GAPS * others_s.max(initial=0)))
    if is_first.sum() < 2 or not (gap_s > far_s).any():
        return dataset
    msg = (
        f"{where}: twtt: {is_first.sum()} range lines have their surface at {times_s[0]:.6g} s, "
        f"{gap_s[0]:.2g} s above all others: taken for lines that nobody picked"
    )
    warnings.warn(msg, UserWarning, stacklevel=6)
    twtt = dataset["twtt"].copy()
    twtt[0, is_first] = np.nan
    return dataset.assign(twtt=twtt)


def order_from_surface(twtt, names):
    """Order of layers (layer, range_line) from the surface down, (layer,) of int.

    Layer i goes before j if it is above it on some line both are picked on. Layers that share no
    line are ordered by their median depth below the surface. The layer named "surface" goes before
    all others. Of layers that cross, also by way of others, the shallowest goes first.
    """
    twtt = pd.DataFrame(twtt)
    above = np.array([(row <= twtt.values).any(axis=1) for row in twtt.values])
    np.fill_diagonal(above, False)
    surface = surface_among(names)
    depth = twtt
    if surface is not None:
        above[surface] = np.arange(len(names)) != surface
        above[:, surface] = False
        depth = twtt - twtt.iloc[surface]
    depth = depth.median(axis=1).fillna(twtt.median(axis=1))
    order = []
    left = list(depth.sort_values(kind="stable").index)
    while left:
        free = [layer for layer in left if not above[left, layer].any()]
        order.append((free or left)[0])
        left.remove(order[-1])
    return np.array(order)


def begins_with_surface(layers):
    """Whether the first layer is named the surface, or layers are numbered, the first being it."""
    index = layers.get_index("layer")
    return index.dtype.kind not in "OUS" or surface_among(index.astype(str)) == 0


def surface_among(names):
    """Which of the names, with or without a group in front, is the snow surface; None if none."""
    plain = [name.rpartition(":")[2] for name in names]
    return plain.index(SURFACE) if SURFACE in plain else None


def find_organizer(path):
    """The organizer file beside a CReSIS layer file, which names its layers, or None."""
    path = Path(path)
    segment = re.search(r"\d{8}_\d{2}", path.stem)
    organizer = path.with_name(f"layer_{segment.group()}.mat") if segment else path
    return organizer if organizer.is_file() and organizer != path else None


def _organized(path):
    """Name and group of layers by their id, as the organizer file beside a layer file has them."""
    organizer = find_organizer(path)
    if organizer is None:
        return {}
    values = read_values(organizer, ("lyr_id", "lyr_name", "lyr_group_name"))
    ids = np.ravel(values["lyr_id"])
    cells = (values["lyr_name"], values.get("lyr_group_name", [""] * ids.size))
    # One cell alone comes as what it holds.
    texts = ([cell] if isinstance(cell, str) else map(_text, cell) for cell in cells)
    return dict(zip(ids, zip(*texts, strict=True), strict=True))


def _is_simulated(path):
    """Whether the organizer of a layer file says that `snowsim simulate` made the layers."""
    organizer = find_organizer(path)
    values = {} if organizer is None else read_values(organizer, ("lyr_desc",))
    return SIMULATED in map(_text, np.ravel(values.get("lyr_desc", ())))


def _text(value):
    """Text of a file, empty where it has none there."""
    return value if isinstance(value, str) else ""


def _layers_dataset(values, picks, names, source):
    """Dataset of all layers of a CReSIS file, of its values, picks and (name, group) of layers."""
    plain, groups = zip(*names, strict=True)
    full = [f"{group}:{name}" if plain.count(name) > 1 else name for name, group in names]
    variables = {
        "slow_time": utc_times(values["GPS_time"], gps=True),
        "layer": np.array(full, str),
        "group": ("layer", np.array(groups, str)),
    }
    for name, attributes in PICKS.items():
        variables[name] = (AXES, np.array(picks[name], dtype=float), attributes)
    for name in POSITION:
        if name in values:
            position = np.ravel(values[name]).astype(float)
            variables[name] = ("slow_time", position, {"units": UNITS[name]})
    dataset = xr.Dataset(variables, attrs={"source_format": source}).set_coords("group")
    for name in ABSENT:
        flags = dataset[name].fillna(0)
        if flags.min() < 0 or flags.max() > 255:
            raise refusal(None, name, "flags within 0 to 255", f"up to {flags.max():g}")
        dataset[name] = flags.astype(np.uint8)
    without = ~np.isfinite(dataset["twtt"]).any("slow_time")
    return dataset.assign_attrs(empty_layers=", ".join(dataset["layer"].values[without]))


VERSION = "1"
GROUP_OF_SURFACE = "standard"
GROUP = "snowsim"
# Descriptions of layers in the organizer.
TRACKED_LAYER = "snow layer, tracked"
SIMULATED = "snow layer, simulated"


def write_layer_files(folder, segment, frames, *, force=False):
    """Write layers of a segment as CReSIS layer files, in `folder/CSARP_layer/segment`.

    `Data_SEGMENT_FFF.mat` for each frame, and `layer_SEGMENT.mat`, which names the layers of all.
    Layer 0 is the surface; layer i is `snow_i`. Every file holds all layers of the segment, also
    those without a pick in its frame: xopr joins frames only if they have the same.

    Parameters
    ----------
    folder : path_like
        Where the tree begins.
    segment : str
        Day and number, such as "20120330_04".
    frames : mapping of int to xarray.Dataset
        By number of the frame: `twtt` [s], `quality` (1 good, 2 moderate, 3 bad), `type` (1 manual,
        2 automatic) on (layer, slow_time), and `Latitude`, `Longitude`, `Elevation` along
        slow_time. Where there is a coordinate `layer`, it names them, surface and snow_i, else
        layers are numbered as they come. A frame may lack layers that others have.
    force : bool
        Replace files that are there.

    Returns
    -------
    list of Path
        What was written, the organizer last.

    Raises
    ------
    ValueError
        If a file is there and `force` is not set; if the folder holds layer files of other frames,
        whose layers the organizer would name anew; if layers cross, or a variable is missing.
    """
    of_paths = {_frame_path(folder, segment, number): frames[number] for number in frames}
    refuse_other_frames(folder, segment, frames)  # before the folder of the segment is made
    contents = _contents(segment, of_paths, TRACKED_LAYER)
    with locked(_parent(folder, segment)):
        # Once more under the lock: another process may have written since.
        refuse_other_frames(folder, segment, frames)
        for path in contents if not force else ():
            refuse_existing(path)
        for path, content in contents.items():
            write_matlab(path, "layers", content)
    return list(contents)


def write_cresis(path, dataset):
    """Write an echogram or layers of `snowsim.simulate` as CReSIS files, MAT v5.

    The name tells segment and frame; GPS seconds have their leap seconds. An echogram is an L1B
    file, layers are a layer file and the organizer beside it; ValueError where one is there that
    names others.
    """
    segment, _ = named_frame(path)
    if "Data" in dataset:
        write_matlab(path, "echogram", l1b_content(segment, dataset))
        return
    names = _layer_names(dataset.sizes["layer"])
    there = [name for name, _ in _organized(path).values()]
    if there not in ([], names):
        expected = f"surface to {names[-1]}"
        raise refusal(find_organizer(path), "lyr_name", expected, ", ".join(there))
    for file, content in _contents(segment, {path: dataset}, SIMULATED).items():
        write_matlab(file, "layers", content)


def layer_numbers(layers):
    """Number of every layer of a dataset by its name, 0 the surface; else as they come.

    ValueError for names that are no such numbers: a layer file would not keep them.
    """
    if "layer" not in layers.coords:
        return np.arange(layers.sizes["layer"])
    numbers = []
    for name in map(str, layers["layer"].values):
        digits = "0" if name == SURFACE else name.removeprefix(TRACKED)
        if not digits.isdecimal():
            msg = f"layer: expected {SURFACE}, snow_1, snow_2 and so on, found {name!r}"
            raise ValueError(msg)
        numbers.append(int(digits))
    return np.array(numbers)


def refuse_other_frames(folder, segment, numbers):
    """Refuse to track frames of a segment into a folder that holds layer files of others of it.

    One organizer names the layers of all.
    """
    own = {_frame_path(folder, segment, number) for number in numbers}
    parent = _parent(folder, segment)
    others = sorted(set(parent.glob(f"Data_{segment}_*.mat")) - own)
    if others:
        wanted = "those of the frames tracked alone (track all frames of the segment at once, or "
        raise refusal(parent, "layer files", wanted + "to another folder)", others[0].name)


def _parent(folder, segment):
    return Path(folder) / "CSARP_layer" / segment


def _frame_path(folder, segment, number):
    return _parent(folder, segment) / f"Data_{segment}_{number:03d}.mat"


def write_layers(path, layers, *, force=False):
    """Write the same layers of one frame as NetCDF, with all that the dataset has along."""
    if not force:
        refuse_existing(path)
    write_dataset(path, layers, compress=True)


def refuse_existing(path):
    """Refuse to write over a file that is there."""
    if Path(path).exists():
        raise refusal(path, "file", "none, or --force (force=True) to write over it", "one")


def _contents(segment, frames, origin):
    """Variables of layer files, by path as their layers are, and of their organizer, the last."""
    n_layers = 1 + max(int(layer_numbers(layers).max()) for layers in frames.values())
    contents = {}
    for path, layers in frames.items():
        check_layers(layers, str(path))
        with library_errors(path, "layers: expected with positions along slow_time"):
            contents[path] = _frame_content(segment, layers, n_layers)
    contents[path.with_name(f"layer_{segment}.mat")] = {
        "file_type": "layer_organizer",
        "file_version": VERSION,
        "lyr_age": np.full(n_layers, np.nan),
        "lyr_age_source": _cell([np.empty((0, 0), dtype=object)] * n_layers),
        "lyr_desc": _cell(["snow surface"] + [origin] * (n_layers - 1)),
        "lyr_group_name": _cell([GROUP_OF_SURFACE] + [GROUP] * (n_layers - 1)),
        "lyr_id": 1.0 + np.arange(n_layers),
        "lyr_name": _cell(_layer_names(n_layers)),
        "lyr_order": 1.0 + np.arange(n_layers),
        "param": parameters(segment, next(iter(frames.values())).attrs),
    }
    return contents


def _frame_content(segment, layers, n_layers):
    """Variables of a frame's layer file."""
    shape = (n_layers, layers.sizes["slow_time"])
    numbers = layer_numbers(layers)
    twtt = np.full(shape, np.nan)
    twtt[numbers] = layers["twtt"].transpose("layer", "slow_time").values
    content = {
        "file_type": "layer",
        "file_version": VERSION,
        "gps_time": gps_seconds(layers["slow_time"].values),
        "id": 1.0 + np.arange(n_layers),
        "twtt": twtt,
        "param": parameters(segment, layers.attrs),
    }
    if "peak_twtt" in layers:
        content["peak_twtt"] = np.full(shape, np.nan)
        content["peak_twtt"][numbers] = layers["peak_twtt"].transpose("layer", "slow_time").values
    if "place" in layers["twtt"].attrs:
        content["place"] = layers["twtt"].attrs["place"]
    for theirs, ours in RENAMED.items():
        if ours in POSITION:
            content[theirs] = layers[ours].values.astype(float)
    for name, absent in ABSENT.items():
        flags = np.full(shape, absent)
        flags[numbers] = layers[name].transpose("layer", "slow_time").values
        content[name] = np.where(np.isfinite(twtt), flags, absent).astype(np.uint8)
    return content


def _layer_names(n_layers):
    return [SURFACE, *(f"snow_{layer}" for layer in range(1, n_layers))]


def _cell(values):
    """A row of MATLAB cells."""
    return np.fromiter(values, dtype=object)[None]
