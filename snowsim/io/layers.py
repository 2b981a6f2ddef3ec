"""Layer files of every format as datasets of named layers, ordered from the snow surface down."""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr

from snowsim.echogram import check_layers
from snowsim.io.datasets import UNITS, check_dimensions, from_gps_seconds, load_opr
from snowsim.io.guard import check_present, existing, matrix, one_line, refusal, vector
from snowsim.io.matlab import read_matlab
from snowsim.io.sniff import names_in

SURFACE = "surface"
# What the first two entries of an old file are where it gives no names: the format's convention.
OLD_NAMES = ("surface", "bottom")
# What a dataset holds on (layer, slow_time), and its attributes.
PICKS = {
    "twtt": {"units": "s"},
    "quality": {"flag_values": "1 good, 2 moderate, 3 bad"},
    "type": {"flag_values": "1 manual, 2 automatic"},
}
GOOD, MANUAL, AUTOMATIC = 1, 1, 2


@dataclass(frozen=True)
class _Layers:
    """Layers as a CReSIS file has them, in its order; `picks` are those of `PICKS`."""

    slow_time: np.ndarray
    picks: dict
    names: list
    groups: list


def read_cresis_layers(path, *, names=None, missing="refuse"):
    """Layers of a new CReSIS layer file (`CSARP_layer`); see `snowsim.io.read_layers`.

    Names come from the organizer file `layer_YYYYMMDD_SS.mat` beside it (group:name where a name
    comes twice), without one they are "id 1", "id 2", ... Layers without a pick are left out and
    listed in `attrs["empty_layers"]`.
    """
    path = existing(path)
    values = read_matlab(path, ("gps_time", "twtt", "id", "quality", "type", "lat", "lon", "elev"))
    check_present(path, ("gps_time", "id", "twtt"), values, names_in)
    gps_time = vector(path, "gps_time", values["gps_time"])
    ids = vector(path, "id", values["id"])
    if ids.size == 0 or np.size(values["twtt"]) == 0:
        raise refusal(path, "twtt", "at least one layer with picks", "no layer (MATLAB_empty)")
    slow_time = from_gps_seconds(path, "gps_time", gps_time)
    shape = (ids.size, gps_time.size)
    picks = {"twtt": matrix(path, "twtt", values["twtt"], *shape).astype(float)}
    for name, default in (("quality", GOOD), ("type", AUTOMATIC)):
        flags = values.get(name)
        if flags is None or np.size(flags) == 0:
            flags = np.full(shape, default)
        picks[name] = _flags(path, name, matrix(path, name, flags, *shape))
    layers = _Layers(slow_time, picks, *_organized(path, ids))
    positions = {"Latitude": "lat", "Longitude": "lon", "Elevation": "elev"}
    dataset = _layers_dataset(path, layers, values, positions, "CReSIS layer")
    return _chosen(path, dataset, names, missing)


def read_cresis_layer_data(path, *, names=None, missing="refuse"):
    """Layers of an old CReSIS layer file (`CSARP_layerData`); as `read_cresis_layers`.

    Picks are `layerData{i}.value{2}.data`; where `value{1}` has a manual pick, the type is 1, else
    2. Entries without a name are the surface and the bottom, in this order, as the format has it; a
    third without one is refused.
    """
    path = existing(path)
    values = read_matlab(path, ("layerData", "GPS_time", "Latitude", "Longitude", "Elevation"))
    check_present(path, ("GPS_time", "layerData"), values, names_in)
    gps_time = vector(path, "GPS_time", values["GPS_time"])
    entries = values["layerData"]
    entries = [entries] if isinstance(entries, dict) else entries
    if not isinstance(entries, list) or not entries:
        raise refusal(path, "layerData", "a cell of structs", type(entries).__name__)
    parts = [_entry(path, number, entry, gps_time.size) for number, entry in enumerate(entries)]
    slow_time = from_gps_seconds(path, "GPS_time", gps_time)
    picks = {name: np.array([part[name] for part in parts]) for name in PICKS}
    labels = [part["name"] for part in parts]
    groups = [part["group"] for part in parts]
    layers = _Layers(slow_time, picks, labels, groups)
    positions = {name: name for name in ("Latitude", "Longitude", "Elevation")}
    dataset = _layers_dataset(path, layers, values, positions, "CReSIS layerData")
    return _chosen(path, dataset, names, missing)


def read_opr_layers(path, *, names=None, missing="refuse"):
    """Layers dataset of Open Polar Radar as it stands on disk, (layer, slow_time); checked.

    A single layer without a `layer` dimension gets one. Layers with names are ordered from the
    surface down; numbered ones keep their order, the first being the surface. `names` selects by
    the values of `layer`.
    """
    dataset = load_opr(path, ("twtt", "slow_time", "quality", "type"))
    for name in PICKS:
        if dataset[name].dims == ("slow_time",):
            dataset[name] = dataset[name].expand_dims("layer")
        check_dimensions(path, dataset, name, ("layer", "slow_time"))
    return _chosen(path, dataset.transpose("layer", "slow_time", ...), names, missing)


def order_from_surface(twtt, names, path="layers"):
    """Order of layers (layer, range_line) from the surface down, (layer,) of int.

    Layer i goes before j if it is above it on some line both are picked on. Layers that share no
    line are ordered by their median depth below the surface. The layer named "surface" goes before
    all others. Layers that cross or touch, also by way of others, are refused.
    """
    twtt = np.asarray(twtt, dtype=float)
    n_layers = len(names)
    above = _above(path, twtt, names)
    surface = surface_among(names)
    top = 0
    if surface is not None:
        if above[:, surface].any():
            other = names[int(np.argmax(above[:, surface]))]
            raise refusal(path, "twtt", "the surface above all layers", f"{other} above it")
        above[surface] = np.arange(n_layers) != surface
        top = twtt[surface]
    depth = [_median(row - top, row) for row in twtt]
    order = []
    left = list(range(n_layers))
    while left:
        free = [layer for layer in left if not above[left, layer].any()]
        if not free:
            ring = ", ".join(names[layer] for layer in left)
            found = one_line(f"a ring of {ring}", 200)
            raise refusal(path, "twtt", "layers that keep their order", found)
        shallowest = min(free, key=depth.__getitem__)
        order.append(shallowest)
        left.remove(shallowest)
    return np.array(order)


def _above(path, twtt, names):
    """Whether a layer lies above another where both are picked, bool (layer, other layer)."""
    above = np.array([(row <= twtt).any(axis=1) for row in twtt])
    np.fill_diagonal(above, False)
    both = np.argwhere(above & above.T)
    if both.size:
        i, j = both[0]
        crosses = np.any(twtt[i] < twtt[j])
        line = int(np.argmax(twtt[i] <= twtt[j])) if crosses else 0
        found = f"{names[i]} and {names[j]} cross or touch near range_line {line}"
        raise refusal(path, "twtt", "layers that keep their order", found)
    return above


def surface_among(names):
    """Which of the names, with or without a group in front, is the snow surface; None if none."""
    for place, name in enumerate(names):
        if name.rpartition(":")[2] == SURFACE:
            return place
    return None


def _median(values, fallback):
    """Median over finite values; over those of `fallback` where there are none."""
    finite = values[np.isfinite(values)]
    if finite.size == 0:
        finite = fallback[np.isfinite(fallback)]
    return np.median(finite)


def _flags(path, what, values):
    """Flags as uint8; 0 where a file has NaN in their place."""
    values = np.asarray(values, dtype=float)
    flags = np.where(np.isnan(values), 0, values)
    bad = (flags < 0) | (flags > 255)
    if bad.any():
        raise refusal(path, what, "flags within 0 to 255", f"{flags[bad][0]:g}")
    return flags.astype(np.uint8)


def find_organizer(path):
    """The organizer file beside a CReSIS layer file, which names its layers, or None."""
    path = Path(path)
    segment = re.search(r"\d{8}_\d{2}", path.stem)
    organizer = path.with_name(f"layer_{segment.group()}.mat") if segment else path
    return organizer if organizer.is_file() and organizer != path else None


def _organized(path, ids):
    """Names and groups of layer ids; "id 3" where no organizer file knows them."""
    named = {}
    organizer = find_organizer(path)
    if organizer:
        values = read_matlab(organizer, ("lyr_id", "lyr_name", "lyr_group_name"))
        check_present(organizer, ("lyr_id", "lyr_name"), values, names_in)
        known = vector(organizer, "lyr_id", values["lyr_id"])
        names = _texts(organizer, "lyr_name", values["lyr_name"], known.size)
        groups = [""] * known.size
        if "lyr_group_name" in values:
            groups = _texts(organizer, "lyr_group_name", values["lyr_group_name"], known.size)
        pairs = zip(names, groups, strict=True)
        named = dict(zip(known, pairs, strict=True))
    pairs = [named.get(number, (f"id {number:g}", "")) for number in ids]
    return [name for name, _ in pairs], [group for _, group in pairs]


def _texts(path, what, values, length):
    values = [values] if isinstance(values, str) else values
    if not isinstance(values, list):
        raise refusal(path, what, f"a cell of {length} texts", type(values).__name__)
    if len(values) != length:
        raise refusal(path, what, f"a cell of {length} texts", f"{len(values)} values")
    return [value if isinstance(value, str) else "" for value in values]


def _entry(path, number, entry, n_lines):
    """Picks, flags, name and group of one `layerData` entry."""
    where = f"layerData{{{number + 1}}}"
    value = entry.get("value") if isinstance(entry, dict) else None
    structs = value[:2] if isinstance(value, list) else []
    sound = [struct for struct in structs if isinstance(struct, dict) and "data" in struct]
    if len(sound) < 2:
        raise refusal(path, f"{where}.value", "two structs with data", type(value).__name__)
    manual, picks = (struct["data"] for struct in sound)
    picks = vector(path, f"{where}.value{{2}}.data", picks, n_lines)
    kind = np.full(n_lines, AUTOMATIC, dtype=np.uint8)
    if np.size(manual):
        manual = vector(path, f"{where}.value{{1}}", manual, n_lines)
        kind[np.isfinite(manual)] = MANUAL
    quality = np.full(n_lines, GOOD)
    if np.size(entry.get("quality")) == n_lines:
        quality = vector(path, f"{where}.quality", entry["quality"], n_lines)
    name = entry.get("name")
    if not isinstance(name, str) or not name:
        if number >= len(OLD_NAMES):
            raise refusal(path, f"{where}.name", "a name", "none")
        name = OLD_NAMES[number]
    group = entry.get("group_name")
    return {
        "twtt": picks,
        "quality": _flags(path, f"{where}.quality", quality),
        "type": kind,
        "name": name,
        "group": group if isinstance(group, str) else "",
    }


def _layers_dataset(path, layers, values, positions, source):
    """Dataset of all layers of a CReSIS file; `values` have `positions` under its own names."""
    if np.isinf(layers.picks["twtt"]).any():
        raise refusal(path, "twtt", "finite travel times or NaN", "infinite ones")
    names = []
    for name, group in zip(layers.names, layers.groups, strict=True):
        names.append(f"{group}:{name}" if layers.names.count(name) > 1 else name)
    if len(set(names)) < len(names):
        raise refusal(path, "layers", "names that differ", one_line(", ".join(names), 200))
    variables = {}
    for name, attributes in PICKS.items():
        variables[name] = (("layer", "slow_time"), layers.picks[name], attributes)
    for name, theirs in positions.items():
        if theirs in values:
            along_track = vector(path, theirs, values[theirs], layers.slow_time.size)
            variables[name] = ("slow_time", along_track, {"units": UNITS[name]})
    coordinates = {
        "slow_time": layers.slow_time,
        "layer": ("layer", np.asarray(names, dtype=str)),
        "group": ("layer", np.asarray(layers.groups, dtype=str)),
    }
    empty = ", ".join(_without_picks(names, layers.picks["twtt"]))
    return xr.Dataset(variables, coordinates, {"source_format": source, "empty_layers": empty})


def _without_picks(names, twtt):
    return [name for name, row in zip(names, twtt, strict=True) if not np.isfinite(row).any()]


def _chosen(path, dataset, names, missing):
    """Layers of the names wanted, checked.

    Where layers have names, only those with picks, from the surface down.
    """
    index = dataset.get_index("layer")  # numbers where the file has no coordinate of this name
    named = index.dtype.kind in "OUS"
    labels = [str(label) for label in index]
    wanted = labels if names is None else [str(name) for name in names]
    unknown = [name for name in wanted if name not in labels]
    if unknown and missing == "refuse":
        raise refusal(path, "layer", f"one named {unknown[0]}", one_line(", ".join(labels), 200))
    twtt = dataset["twtt"].values
    picked = np.isfinite(twtt).any(axis=1)
    keep = [i for i, label in enumerate(labels) if label in wanted and (picked[i] or not named)]
    if not picked[keep].any():
        empty = one_line(", ".join(_without_picks(labels, twtt)), 200)
        raise refusal(path, "twtt", "at least one layer with picks", f"only NaN in {empty}")
    dataset = dataset.isel(layer=keep)
    if named:
        order = order_from_surface(twtt[keep], [labels[i] for i in keep], path)
        dataset = dataset.isel(layer=order)
    check_layers(dataset, str(path))
    return dataset
