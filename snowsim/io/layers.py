"""Layer files of every format, read and written; contract of readers: `snowsim.io.containers`."""

import hashlib
import itertools
import re
import warnings
from collections.abc import Iterable, Sequence
from os import PathLike
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from snowsim import __version__
from snowsim.alignment import order_from_surface, surface_among
from snowsim.echogram import (
    SURFACE_NAME,
    UNITS,
    check_choice,
    check_layers,
    crossing_layers,
    named_frame,
    without_repeats,
)
from snowsim.io.containers import (
    POSITION,
    format_of,
    one_line_errors,
    open_container,
    read_values,
    write_matlab,
)
from snowsim.io.echograms import l1b_content, parameters
from snowsim.io.files import (
    library_errors,
    locked,
    one_line,
    refusal,
    write_dataset,
    written_together,
)
from snowsim.io.times import gps_seconds, utc_times

# Attribute of layers: digest of the frames that were tracked in one call, and of the tracker.
TOGETHER = "tracked_together"
TRACKED_PREFIX = "snow_"  # begins the names of layers that `snowsim track` found
# Names of the first two entries of an old file without names, by convention of the format.
OLD_NAMES = ("surface", "bottom")
LAYER_AXES = ("layer", "slow_time")
# Variables on these axes, and their attributes.
PICKS = {
    "twtt": {"units": "s"},
    "quality": {"flag_values": "1 good, 2 moderate, 3 bad"},
    "type": {"flag_values": "1 manual, 2 automatic"},
}
MANUAL = 1
# Values on range lines without a pick.
VALUES_WITHOUT_PICK = {"quality": 1, "type": 2}
# A surface this far above all others is a placeholder, not a surface: 30 m of air; or 1.5 m, if
# that is N_GAPS times the largest gap among the others.
PLACEHOLDER_S = 2e-7
NEAR_PLACEHOLDER_S = 1e-8
N_GAPS = 5
# Steps to which `rounded` rounds values, which take 4 bytes each in files of `write_layers`. A MAT
# file holds multiples of a power of two exactly, and in fewer bytes than those of 1 ps.
STEPS = {
    "twtt": 2.0**-40,  # 0.9 ps
    "twtt_low": 2.0**-40,
    "twtt_high": 2.0**-40,
    "confidence": 2.0**-30,
}
NOT_PICKED = -(2**31)  # in place of a number of steps
# Names in old files and in those of Open Polar Radar, by the names in new CReSIS files.
CRESIS_NAMES = {"gps_time": "GPS_time", "lat": "Latitude", "lon": "Longitude", "elev": "Elevation"}


def read_layers(
    path: str | PathLike[str], *, names: Sequence[str] | None = None, missing: str = "refuse"
) -> xr.Dataset:
    """Layers dataset of a file; its format follows from its content.

    Parameters
    ----------
    path : path_like
        CReSIS layer file, new (names from the organizer file beside it) or old, or an Open Polar
        Radar layers dataset.
    names : iterable of str, optional
        Read these layers only, such as ``["surface", "Koenig_2"]``.
    missing : {"refuse", "skip"}
        Whether a file without a layer of one of the `names` is refused, or that name is left out.

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
    stored = open_container(path)
    kind = format_of(stored, readers)
    layers = readers[kind](stored)
    if "slow_time" in layers:
        layers = without_repeats(layers, stored.path)
    return select_layers(layers, names, missing, stored.path)


def open_segment(paths: str | PathLike[str] | Iterable[str | PathLike[str]]) -> xr.Dataset:
    """Layers of all frames of a segment as one dataset, in order of time.

    Parameters
    ----------
    paths : path_like or iterable of path_like
        Files that `read_layers` reads: the `SEGMENT_layers.nc` of `snowsim track`, or files of its
        frames. With ``SEGMENT/*.mat``, the organizer file among the layer files is ignored.

    Returns
    -------
    xarray.Dataset
        As of `read_layers`. Layers of the same name are one layer, NaN in frames without it. They
        are in order of their names: the surface, then by number; or, if layers in this order would
        cross, from the surface down. `frame` (slow_time) is the name of the echogram's file, or, if
        the layers do not say it, of their own.

    Raises
    ------
    ValueError
        In one line, if there is no file, `read_layers` refuses one, frames overlap in time, or
        tracked frames belong to several segments or several calls of `snowsim track`.
    """
    paths = [Path(path) for path in ([paths] if isinstance(paths, str | PathLike) else paths)]
    organizers = {find_organizer(path) for path in paths}
    paths = [path for path in paths if path not in organizers]
    where = "segment"
    if not paths:
        raise refusal(where, "files", "those of its frames", "none")
    frames = []
    segments = set()
    for path in paths:
        layers = read_layers(path)
        if any(str(name).startswith(TRACKED_PREFIX) for name in layers.get_index("layer")):
            segment, _ = named_frame(layers.attrs.get("granule", path))
            segments |= {layers.attrs.get("day_seg", segment)} - {None}
        if "frame" not in layers.coords or layers["frame"].dims != ("slow_time",):
            layers = with_frame(layers, Path(path).stem.removesuffix("_layers"))
        frames.append(layers)
    if len(segments) > 1:
        told = " and ".join(sorted(segments))
        expected = f"one segment, in which {TRACKED_PREFIX}1 of all frames is one layer"
        raise refusal(where, "segments", expected, told)
    frames.sort(key=lambda frame: frame["slow_time"].values[0])
    _check_together(frames, where)
    joined = join_frames(frames)
    check_layers(joined, f"{where} of {paths[0]}")
    return joined


def with_frame(layers, name):
    """Layers with the name of their frame on each range line, the coordinate `frame`."""
    names = np.full(layers.sizes["slow_time"], name, dtype=object)
    return layers.assign_coords(frame=("slow_time", names))


def join_frames(frames):
    """Layers of frames in order of time, which have a `frame`, as one dataset; see `open_segment`.

    Attributes that frames do not share are left out. Variables are joined one by one, to save
    memory: a segment may have 200 layers on 50,000 range lines.
    """
    variables = dict.fromkeys(name for frame in frames for name in frame.data_vars)
    joined = _joined([frame[["twtt"]] for frame in frames])
    names = joined["layer"].values
    in_order = sorted(names, key=lambda name: (name != SURFACE_NAME, len(str(name)), name))
    if any(_crosses(frame, in_order) for frame in frames):  # such names are years, or have a group
        twtt = joined["twtt"].sel(layer=in_order).transpose(*LAYER_AXES).values
        in_order = np.array(in_order)[order_from_surface(twtt, list(map(str, in_order)))]
    joined = joined.sel(layer=in_order)
    for name in variables:
        others = [[other for other in frame.data_vars if other != name] for frame in frames]
        alone = [frame.drop_vars(other) for frame, other in zip(frames, others, strict=True)]
        if name != "twtt":
            of_all = _joined(alone)[name]
            joined[name] = of_all.sel(layer=in_order) if "layer" in of_all.dims else of_all
    return joined


def _joined(frames):
    """Datasets of frames concatenated along slow_time."""
    return xr.concat(
        frames,
        "slow_time",
        data_vars="all",
        coords="minimal",
        compat="override",
        join="outer",
        fill_value=VALUES_WITHOUT_PICK,
        combine_attrs="drop_conflicts",
    )


def _crosses(frame, names):
    """Whether layers of a frame cross in the order of these names."""
    own = [name for name in names if name in frame.get_index("layer")]
    return crossing_layers(frame["twtt"].sel(layer=own).transpose(*LAYER_AXES).values).any()


def open_segments(paths):
    """Layers of several segments, each joined as `open_segment` does.

    Parameters
    ----------
    paths : iterable of path_like
        Files that `read_layers` reads. Files are of one segment if their names have the same, as
        ``Data_20120330_04_001_layers.nc`` has 20120330_04. A file whose name has none is a segment
        of its own.

    Returns
    -------
    dict of str to xarray.Dataset
        Results of `open_segment` by the segment's name, or by the file's.

    Raises
    ------
    ValueError
        In one line, if `open_segment` refuses a segment, or two files would have one name.
    """
    by_segment = {}
    for path in map(Path, paths):
        segment, _ = named_frame(path)
        name = path.stem.removesuffix("_layers") if segment is None else segment
        if segment is None and name in by_segment:
            expected = f"another name than that of {by_segment[name][0]}, by which segments go"
            raise refusal(path, "name", expected, path.name)
        by_segment.setdefault(name, []).append(path)
    return {name: open_segment(own) for name, own in by_segment.items()}


def _check_together(frames, where):
    """Refuse frames that do not belong together, and say which of them a person corrected."""
    digests = {frame.attrs.get(TOGETHER) for frame in frames} - {None}
    if len(digests) > 1:
        expected = f"one, for {TRACKED_PREFIX}1 of each is another layer (track them in one call)"
        raise refusal(where, TOGETHER, expected, f"{len(digests)} calls of track")
    for first, second in itertools.pairwise(frames):
        if second["slow_time"].values[0] <= first["slow_time"].values[-1]:
            names = " and ".join(str(each["frame"].values[0]) for each in (first, second))
            raise refusal(where, names, "frames that follow one another", "frames overlap in time")
    counts = {frame.sizes["layer"] for frame in frames if "layer" not in frame.coords}
    if len(counts) > 1:
        expected = "names, or as many layers in each frame"
        raise refusal(where, "layer", expected, f"{min(counts)} to {max(counts)} without names")
    by_hand = [str(frame["frame"].values[0]) for frame in frames if "confidence" not in frame]
    if 0 < len(by_hand) < len(frames):
        warnings.warn(
            f"{where}: {len(by_hand)} of {len(frames)} frames have no confidence, as a person's "
            f"({by_hand[0]}): years are counted in all, unless every layer is said to be one year",
            stacklevel=3,
        )


def read_cresis_layers(stored):
    """Layers of a new CReSIS layer file (`CSARP_layer`).

    Names come from the organizer file `layer_YYYYMMDD_SS.mat` beside it, as group:name if two
    layers have the same name. Without an organizer they are "id 1", "id 2", ...
    """
    values = stored.read(("id", *PICKS, *CRESIS_NAMES, "peak_twtt", "place", TOGETHER))
    values = {CRESIS_NAMES.get(name, name): value for name, value in values.items()}
    if "id" not in values or "twtt" not in values:
        expected = "at least one layer with picks"
        raise refusal(stored.path, "twtt", expected, "no layer (MATLAB_empty)")
    ids = np.ravel(values["id"])
    shape = (ids.size, np.size(values["GPS_time"]))
    absent = {name: np.full(shape, value) for name, value in VALUES_WITHOUT_PICK.items()}
    picks = {name: np.asarray((absent | values)[name]) for name in PICKS}
    # An array of a single layer, or of a single line, has lost that axis.
    picks = {name: of if of.ndim == 2 else of.reshape(shape) for name, of in picks.items()}
    named = _organized(stored.path)
    names = [named.get(number, (f"id {number:g}", "")) for number in ids]
    dataset = _layers_dataset(values, picks, names, "CReSIS layer")
    if "peak_twtt" in values:
        dataset["peak_twtt"] = (
            LAYER_AXES,
            np.reshape(values["peak_twtt"], shape),
            {"units": "s", "place": "peak"},
        )
    if TOGETHER in values:
        dataset.attrs[TOGETHER] = values[TOGETHER]
    if "place" in values:
        dataset["twtt"].attrs["place"] = values["place"]
    elif _is_simulated(stored.path):
        dataset["twtt"].attrs["place"] = "interface"
    return dataset


def read_cresis_layer_data(stored):
    """Layers of an old CReSIS layer file (`CSARP_layerData`).

    Picks are `layerData{i}.value{2}.data`. The type is 1 where `value{1}` has a manual pick, else
    2. The first two entries are the surface and the bottom if they have no names.
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
            quality if quality.size == n_lines else np.full(n_lines, VALUES_WITHOUT_PICK["quality"])
        )
        types = np.full(n_lines, VALUES_WITHOUT_PICK["type"])
        types[np.flatnonzero(np.isfinite(manual))] = MANUAL
        picks["type"].append(types)
        unnamed = OLD_NAMES[number] if number < len(OLD_NAMES) else f"layer {number + 1}"
        names.append((_text(entry.get("name")) or unnamed, _text(entry.get("group_name"))))
    return _layers_dataset(values, picks, names, "CReSIS layerData")


def read_opr_layers(stored):
    """Layers dataset of an Open Polar Radar file, with axes in the order (layer, slow_time).

    A single layer without the dimension `layer` gets it. Names of layers lose the blanks that
    arrays of characters are padded with.
    """
    dataset = stored.read()
    index = dataset.indexes.get("layer")
    if index is not None and index.dtype.kind in "OUS":
        names = [name.decode() if isinstance(name, bytes) else str(name) for name in index]
        names = np.array([name.strip() for name in names], str)
        dataset = dataset.assign_coords(layer=("layer", names, dataset["layer"].attrs))
    for name in PICKS:
        if dataset[name].dims == ("slow_time",):
            dataset[name] = dataset[name].expand_dims("layer")
    for name in VALUES_WITHOUT_PICK:
        if dataset[name].isnull().any():  # declared as missing
            dataset[name] = dataset[name].fillna(0)
    return dataset.transpose(*LAYER_AXES, ...)


def select_layers(dataset, names, missing, where):
    """Layers of the given `names`, or all if None, checked.

    Named layers are ordered from the surface down, and those without picks are left out. Numbered
    layers keep their order and are all kept; the first is the surface. A layer "Surface", in any
    case, is named surface.
    """
    dataset = _with_surface_named(dataset)
    index = dataset.get_index("layer")  # numbers, if the file has no coordinate `layer`
    named = index.dtype.kind in "OUS"
    labels = index.astype(str)
    wanted = labels
    if names is not None:
        wanted = pd.Index([as_named(name, labels) for name in names], dtype=str)
    # Zero means that nobody picked.
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


def _with_surface_named(dataset):
    """The layers with the name surface for a layer that has it in another case, as "Surface"."""
    index = dataset.get_index("layer")
    spelled = [str(name) for name in index if str(name).lower() == SURFACE_NAME]
    if len(spelled) != 1 or spelled == [SURFACE_NAME]:
        return dataset
    names = [SURFACE_NAME if name == spelled[0] else str(name) for name in index]
    return dataset.assign_coords(layer=("layer", np.array(names, str), dataset["layer"].attrs))


def as_named(name, names):
    """The name of a layer as it is among `names`, which have "surface" for "Surface"."""
    is_other = str(name) not in names and str(name).lower() == SURFACE_NAME
    return SURFACE_NAME if is_other else name


def _without_placeholders(dataset, where):
    """Layers without placeholders of the surface: picks at one time far above all others.

    Such picks lie at the first range bin, on lines that nobody picked. Warns of them.
    """
    surface_s = dataset["twtt"][0].values
    times_s = np.unique(surface_s[np.isfinite(surface_s)])
    is_first = np.isin(surface_s, times_s[:1])
    gap_s, others_s = np.split(np.diff(times_s), [1])
    far_s = min(PLACEHOLDER_S, max(NEAR_PLACEHOLDER_S, N_GAPS * others_s.max(initial=0)))
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


def begins_with_surface(layers):
    """True if the first layer is named surface, or if layers have numbers instead of names."""
    index = layers.get_index("layer")
    return index.dtype.kind not in "OUS" or surface_among(index.astype(str)) == 0


def find_organizer(path):
    """Path of the organizer file beside a CReSIS layer file, which names its layers, or None."""
    path = Path(path)
    segment = re.search(r"\d{8}_\d{2}", path.stem)
    organizer = path.with_name(f"layer_{segment.group()}.mat") if segment else path
    return organizer if organizer.is_file() and organizer != path else None


def _organized(path):
    """Name and group of each layer by its id, from the organizer file beside a layer file."""
    organizer = find_organizer(path)
    if organizer is None:
        return {}
    values = read_values(organizer, ("lyr_id", "lyr_name", "lyr_group_name"))
    ids = np.ravel(values["lyr_id"])
    cells = (values["lyr_name"], values.get("lyr_group_name", [""] * ids.size))
    # A single cell has been replaced by its content.
    texts = ([cell] if isinstance(cell, str) else map(_text, cell) for cell in cells)
    return dict(zip(ids, zip(*texts, strict=True), strict=True))


def _is_simulated(path):
    """Whether the organizer of a layer file says that `snowsim simulate` made the layers."""
    organizer = find_organizer(path)
    values = {} if organizer is None else read_values(organizer, ("lyr_desc",))
    return SIMULATED in map(_text, np.ravel(values.get("lyr_desc", ())))


def _text(value):
    """The value if it is text, else an empty text."""
    return value if isinstance(value, str) else ""


def _layers_dataset(values, picks, names, source):
    """Dataset of all layers of a CReSIS file from its values, picks and (name, group) pairs."""
    plain, groups = zip(*names, strict=True)
    full = [f"{group}:{name}" if plain.count(name) > 1 else name for name, group in names]
    variables = {
        "slow_time": utc_times(values["GPS_time"], gps=True),
        "layer": np.array(full, str),
        "group": ("layer", np.array(groups, str)),
    }
    for name, attributes in PICKS.items():
        variables[name] = (LAYER_AXES, np.array(picks[name], dtype=float), attributes)
    for name in POSITION:
        if name in values:
            position = np.ravel(values[name]).astype(float)
            variables[name] = ("slow_time", position, {"units": UNITS[name]})
    dataset = xr.Dataset(variables, attrs={"source_format": source}).set_coords("group")
    for name in VALUES_WITHOUT_PICK:
        flags = dataset[name].fillna(0)
        if flags.min() < 0 or flags.max() > 255:
            raise refusal(None, name, "flags within 0 to 255", f"up to {flags.max():g}")
        dataset[name] = flags.astype(np.uint8)
    without = ~np.isfinite(dataset["twtt"]).any("slow_time")
    return dataset.assign_attrs(empty_layers=", ".join(dataset["layer"].values[without]))


LAYER_FILE_VERSION = "1"
GROUP_OF_SURFACE = "standard"
GROUP = "snowsim"
# Descriptions of layers in the organizer.
TRACKED_LAYER = "snow layer, tracked"
SIMULATED = "snow layer, simulated"


def write_layer_files(folder, segment, frames, *, force=False):
    """Write layers of a segment as CReSIS layer files to `folder/CSARP_layer/segment`.

    These are `Data_SEGMENT_FFF.mat` for each frame, and the organizer `layer_SEGMENT.mat`, which
    names the layers. Layer 0 is the surface; layer i is `snow_i`. Every file has all layers of the
    segment, with or without picks, because xopr joins only frames with the same layers.

    Parameters
    ----------
    folder : path_like
        Root of the tree of folders.
    segment : str
        Day and number, such as "20120330_04".
    frames : mapping of int to xarray.Dataset
        By number of the frame: `twtt` [s], `quality` (1 good, 2 moderate, 3 bad), `type` (1 manual,
        2 automatic) on (layer, slow_time), and `Latitude`, `Longitude`, `Elevation` along
        slow_time. A coordinate `layer` names the layers surface and snow_i; without it they are
        numbered in their order. A frame may lack layers of other frames.
    force : bool
        Replace existing files.

    Returns
    -------
    list of Path
        Files written, the organizer last.

    Raises
    ------
    ValueError
        If a file exists and `force` is not set; if the folder has layer files of other frames of
        the segment, whose layers would get other names; if layers cross, or a variable is missing.
    """
    of_paths = {_frame_path(folder, segment, number): frames[number] for number in frames}
    refuse_other_frames(folder, segment, frames)  # before the folder of the segment is made
    contents = _contents(segment, of_paths, TRACKED_LAYER)
    with locked(_parent(folder, segment)):
        # Once more under the lock: another process may have written since.
        refuse_other_frames(folder, segment, frames)
        for path in contents if not force else ():
            refuse_existing(path)
        with written_together():
            for path, content in contents.items():
                write_matlab(path, "layers", content)
    return list(contents)


def write_cresis(path, dataset):
    """Write a simulated echogram or its layers as CReSIS files, MAT v5.

    The file's name holds segment and frame. An echogram becomes an L1B file; layers become a layer
    file and the organizer beside it. ValueError if an organizer there has other names.
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


def numbers_in_names(layers):
    """Numbers of the layers of a dataset from their names, 0 the surface; without names 0, 1, ...

    ValueError for other names than surface and snow_i, which a layer file would not keep.
    """
    if "layer" not in layers.coords:
        return np.arange(layers.sizes["layer"])
    numbers = []
    for name in map(str, layers["layer"].values):
        digits = "0" if name.lower() == SURFACE_NAME else name.removeprefix(TRACKED_PREFIX)
        if not digits.isdecimal():
            msg = f"layer: expected {SURFACE_NAME}, snow_1, snow_2 and so on, found {name!r}"
            raise ValueError(msg)
        numbers.append(int(digits))
    return np.array(numbers)


def refuse_other_frames(folder, segment, numbers):
    """Raise ValueError if a folder has layer files of other frames of the segment.

    One organizer names the layers of all frames, so that all must be tracked at once.
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


def rounded(layers):
    """Layers with values as files of `write_layers` hold them, rounded to `STEPS`.

    Of layers that are one after this, the lower loses its pick.
    """
    for name, step in STEPS.items():  # one by one, to save memory
        values = layers[name].values / step
        np.rint(values, out=values)
        values *= step
        layers = layers.assign({name: (layers[name].dims, values, layers[name].attrs)})
    same = crossing_layers(layers["twtt"].transpose(*LAYER_AXES).values)
    if same.any():
        picks = ["twtt", "twtt_low", "twtt_high"]
        layers = layers.assign(layers[picks].where(~xr.DataArray(same, dims=LAYER_AXES)))
    return layers


def write_layers(path: str | PathLike[str], layers: xr.Dataset, *, force: bool = False) -> None:
    """Write layers as NetCDF, with all variables of the dataset; those of `STEPS` are rounded.

    They may be of one frame or, with `frame` along slow_time, of a segment.
    """
    if not force:
        refuse_existing(path)
    # Level 9 takes twice the time for 2 % fewer bytes.
    encoding = {
        name: {"dtype": "int32", "scale_factor": step, "_FillValue": NOT_PICKED, "complevel": 4}
        for name, step in STEPS.items()
    }
    # As characters: netCDF does not compress text of any length.
    encoding["frame"] = {"dtype": "S1"}
    encoding |= dict.fromkeys(("slow_time", *VALUES_WITHOUT_PICK), {})
    encoding = {name: how for name, how in encoding.items() if name in layers.variables}
    write_dataset(path, layers, compress=True, encoding=encoding)


def refuse_existing(path):
    """Raise ValueError if the file exists."""
    if Path(path).exists():
        raise refusal(path, "file", "none, or --force (force=True) to write over it", "one")


def segment_files(folder, segment, numbers):
    """Paths that `write_layer_files` gives frames of these numbers, the organizer last."""
    parent = _parent(folder, segment)
    frames = [_frame_path(folder, segment, number) for number in numbers]
    return [*frames, parent / f"layer_{segment}.mat"]


def digest_of_inputs(digests, card, bin_s):
    """Attribute `TOGETHER` of the layers of a segment.

    It is made of the digests of its files, in order, of the tracker's card, the range bin of images
    and this version.
    """
    together = hashlib.sha256(f"{card} {__version__} {bin_s}".encode())
    for digest in digests:
        together.update(digest.encode())
    return together.hexdigest()[:16]


def digest_in(path):
    """Attribute `TOGETHER` of a layer file, None if it has none; ValueError if it is damaged."""
    values = read_values(path, (TOGETHER,))
    return getattr(values, "attrs", values).get(TOGETHER)


def _contents(segment, frames, origin):
    """Variables of layer files by path, the organizer last; `frames` holds layers by path."""
    n_layers = 1 + max(int(numbers_in_names(layers).max()) for layers in frames.values())
    contents = {}
    for path, layers in frames.items():
        check_layers(layers, str(path))
        with library_errors(path, "layers: expected with positions along slow_time"):
            contents[path] = _frame_content(segment, layers, n_layers)
    contents[path.with_name(f"layer_{segment}.mat")] = {
        "file_type": "layer_organizer",
        "file_version": LAYER_FILE_VERSION,
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
    """Variables of the layer file of one frame, by name."""
    shape = (n_layers, layers.sizes["slow_time"])
    numbers = numbers_in_names(layers)
    twtt = np.full(shape, np.nan)
    twtt[numbers] = layers["twtt"].transpose("layer", "slow_time").values
    content = {
        "file_type": "layer",
        "file_version": LAYER_FILE_VERSION,
        "gps_time": gps_seconds(layers["slow_time"].values),
        "id": 1.0 + np.arange(n_layers),
        "twtt": twtt,
        "param": parameters(segment, layers.attrs),
    }
    if "peak_twtt" in layers:
        content["peak_twtt"] = np.full(shape, np.nan)
        content["peak_twtt"][numbers] = layers["peak_twtt"].transpose("layer", "slow_time").values
    if TOGETHER in layers.attrs:
        content[TOGETHER] = layers.attrs[TOGETHER]
    if "place" in layers["twtt"].attrs:
        content["place"] = layers["twtt"].attrs["place"]
    for theirs, ours in CRESIS_NAMES.items():
        if ours in POSITION:
            content[theirs] = layers[ours].values.astype(float)
    for name, absent in VALUES_WITHOUT_PICK.items():
        flags = np.full(shape, absent)
        flags[numbers] = layers[name].transpose("layer", "slow_time").values
        content[name] = np.where(np.isfinite(twtt), flags, absent).astype(np.uint8)
    return content


def _layer_names(n_layers):
    return [SURFACE_NAME, *(f"snow_{layer}" for layer in range(1, n_layers))]


def _cell(values):
    """Values as a row of MATLAB cells."""
    return np.fromiter(values, dtype=object)[None]
