"""Layer files of every format as datasets of named layers, ordered from the snow surface down."""

import re

import numpy as np
import xarray as xr

from snowsim.echogram import check_layers
from snowsim.io.datasets import UNITS, from_gps_seconds, load_opr
from snowsim.io.guard import check_present, existing, matrix, one_line, refusal, vector
from snowsim.io.matlab import read_matlab
from snowsim.io.sniff import names_in

SURFACE = "surface"
# What the first two entries of an old file are where it gives no names: the format's own
# convention.
OLD_NAMES = ("surface", "bottom")
# What a dataset holds on (layer, slow_time), and its attributes.
PICKS = {
    "twtt": {"units": "s"},
    "quality": {"flag_values": "1 good, 2 moderate, 3 bad"},
    "type": {"flag_values": "1 manual, 2 automatic"},
}


def read_cresis_layers(path, *, names=None, missing="refuse"):
    """Layers of a new CReSIS layer file (`CSARP_layer`), all or those of `names`; see `snowsim.io.read_layers`.

    Names come from the organizer file `layer_YYYYMMDD_SS.mat` beside it (group:name where a name
    comes twice), without one they are "id 1", "id 2", ... Layers without a pick are left out and
    listed in `attrs["empty_layers"]`.
    """
    path = existing(path)
    values = read_matlab(path, ("gps_time", "twtt", "id", "quality", "type", "lat", "lon", "elev"))
    check_present(path, ("gps_time", "id", "twtt"), values, names_in)
    gps_time = vector(path, "gps_time", values["gps_time"])
    ids = vector(path, "id", values["id"])
    n_lines, n_layers = gps_time.size, ids.size
    if n_layers == 0 or np.size(values["twtt"]) == 0:
        raise refusal(path, "twtt", "at least one layer with picks", "no layer (MATLAB_empty)")
    content = {"slow_time": from_gps_seconds(path, "gps_time", gps_time)}
    content["twtt"] = matrix(path, "twtt", values["twtt"], n_layers, n_lines).astype(float)
    for name, default in (("quality", 1), ("type", 2)):
        flags = values.get(name, np.empty(0))
        absent = flags is None or np.size(flags) == 0
        flags = (
            np.full((n_layers, n_lines), default)
            if absent
            else matrix(path, name, flags, n_layers, n_lines)
        )
        content[name] = _flags(path, name, flags)
    content["names"], content["groups"] = _organized(path, ids)
    dataset = _layers_dataset(path, content, values, ("lat", "lon", "elev"), "CReSIS layer")
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
    content = {name: np.array([part[name] for part in parts]) for name in PICKS}
    content |= {name: [part[name] for part in parts] for name in ("names", "groups")}
    content["slow_time"] = from_gps_seconds(path, "GPS_time", gps_time)
    dataset = _layers_dataset(
        path, content, values, ("Latitude", "Longitude", "Elevation"), "CReSIS layerData"
    )
    return _chosen(path, dataset, names, missing)


def read_opr_layers(path, *, names=None, missing="refuse"):
    """Layers dataset of Open Polar Radar as it stands on disk, (layer, slow_time); checked.

    A single layer without a `layer` dimension gets one. Layers with names are ordered from the
    surface down; numbered ones keep their order, the first being the surface. `names` selects by
    the values of `layer`.
    """
    dataset = load_opr(path, ("twtt", "slow_time", "quality", "type"))
    single = [name for name in PICKS if dataset[name].dims == ("slow_time",)]
    if single:
        dataset = dataset.assign({name: dataset[name].expand_dims("layer") for name in single})
    for name in PICKS:
        if set(dataset[name].dims) != {"layer", "slow_time"}:
            raise refusal(
                path,
                name,
                "dimensions layer and slow_time",
                ", ".join(map(str, dataset[name].dims)),
            )
    return _chosen(path, dataset.transpose("layer", "slow_time", ...), names, missing)


def order_from_surface(twtt, names, path="layers"):
    """Order of layers (layer, range_line) from the surface down, by what lies above what, (layer,) of int.

    Layer i goes before j if it is above it on some line both are picked on. Layers that share no
    line are ordered by their median depth below the surface. The layer named "surface" goes before
    all others. Layers that cross or touch, also by way of others, are refused.
    """
    twtt = np.asarray(twtt, dtype=float)
    n_layers = len(names)
    with np.errstate(invalid="ignore"):
        above = np.array(
            [
                [np.any(twtt[i] <= twtt[j]) and i != j for j in range(n_layers)]
                for i in range(n_layers)
            ]
        )
    both = np.argwhere(above & above.T)
    if both.size:
        i, j = both[0]
        line = int(np.argmax(twtt[i] <= twtt[j])) if np.any(twtt[i] < twtt[j]) else 0
        found = f"{names[i]} and {names[j]} cross or touch near range_line {line}"
        raise refusal(path, "twtt", "layers that keep their order", found)
    surface, top = surface_among(names), 0
    if surface is not None:
        if above[:, surface].any():
            other = names[int(np.argmax(above[:, surface]))]
            raise refusal(path, "twtt", "the surface above all layers", f"{other} above it")
        above[surface] = np.arange(n_layers) != surface
        top = twtt[surface]
    depth = [_median(row - top, row) for row in twtt]
    order, left = [], list(range(n_layers))
    while left:
        free = [i for i in left if not above[left, i].any()]
        if not free:
            found = f"a ring of {', '.join(names[i] for i in left)}"
            raise refusal(path, "twtt", "layers that keep their order", one_line(found, 200))
        order.append(min(free, key=lambda i: depth[i]))
        left.remove(order[-1])
    return np.array(order)


def surface_among(names):
    """Which of the names, with or without a group in front, is the snow surface; None if none is."""
    return next((i for i, name in enumerate(names) if name.rpartition(":")[2] == SURFACE), None)


def _median(values, fallback):
    """Median over finite values; over those of `fallback` where there are none."""
    values = values[np.isfinite(values)]
    return np.median(values) if values.size else np.median(fallback[np.isfinite(fallback)])


def _flags(path, what, values):
    """Flags as uint8; 0 where a file has NaN in their place."""
    values = np.asarray(values, dtype=float)
    flags = np.where(np.isnan(values), 0, values)
    bad = (flags < 0) | (flags > 255)
    if bad.any():
        raise refusal(path, what, "flags within 0 to 255", f"{flags[bad][0]:g}")
    return flags.astype(np.uint8)


def _organized(path, ids):
    """Names and groups of layer ids; "id 3" where no organizer file knows them."""
    segment = re.search(r"\d{8}_\d{2}", path.stem)
    organizer = path.with_name(f"layer_{segment.group()}.mat") if segment else path
    named = {}
    if organizer.is_file() and organizer != path:
        values = read_matlab(organizer, ("lyr_id", "lyr_name", "lyr_group_name"))
        check_present(organizer, ("lyr_id", "lyr_name"), values, names_in)
        known = vector(organizer, "lyr_id", values["lyr_id"])
        names = _texts(organizer, "lyr_name", values["lyr_name"], known.size)
        groups = _texts(
            organizer, "lyr_group_name", values.get("lyr_group_name", [""] * known.size), known.size
        )
        named = {number: pair for number, *pair in zip(known, names, groups, strict=True)}
    pairs = [named.get(number, [f"id {number:g}", ""]) for number in ids]
    return [name for name, _ in pairs], [group for _, group in pairs]


def _texts(path, what, values, length):
    values = [values] if isinstance(values, str) else values
    if not isinstance(values, list) or len(values) != length:
        found = f"{len(values)} values" if isinstance(values, list) else type(values).__name__
        raise refusal(path, what, f"a cell of {length} texts", found)
    return [value if isinstance(value, str) else "" for value in values]


def _entry(path, number, entry, n_lines):
    """Picks, flags and names of one `layerData` entry."""
    where = f"layerData{{{number + 1}}}"
    value = entry.get("value") if isinstance(entry, dict) else None
    if (
        not isinstance(value, list)
        or len(value) < 2
        or not all(isinstance(v, dict) and "data" in v for v in value[:2])
    ):
        raise refusal(path, f"{where}.value", "two structs with data", type(value).__name__)
    manual = value[0]["data"]
    manual = (
        np.full(n_lines, np.nan)
        if np.size(manual) == 0
        else vector(path, f"{where}.value{{1}}", manual, n_lines)
    )
    picks = vector(path, f"{where}.value{{2}}.data", value[1]["data"], n_lines)
    quality = entry.get("quality")
    quality = (
        np.ones(n_lines)
        if np.size(quality) != n_lines
        else vector(path, f"{where}.quality", quality, n_lines)
    )
    name = entry.get("name")
    if not isinstance(name, str) or not name:
        if number >= len(OLD_NAMES):
            raise refusal(path, f"{where}.name", "a name", "none")
        name = OLD_NAMES[number]
    group = entry.get("group_name")
    kind = np.where(np.isfinite(manual), 1, 2).astype(np.uint8)
    found = {"twtt": picks, "quality": _flags(path, f"{where}.quality", quality), "type": kind}
    return found | {"names": name, "groups": group if isinstance(group, str) else ""}


def _layers_dataset(path, content, values, positions, source):
    """Dataset of all layers of a CReSIS file; positions are read from `values` under the format's own names."""
    if np.isinf(content["twtt"]).any():
        raise refusal(path, "twtt", "finite travel times or NaN", "infinite ones")
    names, groups = content["names"], content["groups"]
    names = [
        f"{group}:{n}" if names.count(n) > 1 else n for n, group in zip(names, groups, strict=True)
    ]
    if len(set(names)) < len(names):
        raise refusal(path, "layers", "names that differ", one_line(", ".join(names), 200))
    picked = np.isfinite(content["twtt"]).any(axis=1)
    variables = {
        name: (("layer", "slow_time"), content[name], attributes)
        for name, attributes in PICKS.items()
    }
    for name, ours in zip(positions, ("Latitude", "Longitude", "Elevation"), strict=True):
        if name in values:
            along_track = vector(path, name, values[name], content["slow_time"].size)
            variables[ours] = ("slow_time", along_track, {"units": UNITS[ours]})
    coordinates = {
        "slow_time": content["slow_time"],
        "layer": ("layer", np.asarray(names, dtype=str)),
        "group": ("layer", np.asarray(groups, dtype=str)),
    }
    empty = ", ".join(name for name, has in zip(names, picked, strict=True) if not has)
    return xr.Dataset(variables, coordinates, {"source_format": source, "empty_layers": empty})


def _chosen(path, dataset, names, missing):
    """Layers of the names wanted, checked; where they have names, only those with picks, from the surface down."""
    index = dataset.get_index("layer")  # numbers where the file has no coordinate of this name
    named = index.dtype.kind in "OUS"
    labels = [str(label) for label in index]
    wanted = labels if names is None else [str(name) for name in names]
    for name in wanted:
        if name not in labels and missing == "refuse":
            raise refusal(path, "layer", f"one named {name}", one_line(", ".join(labels), 200))
    picked = np.isfinite(dataset["twtt"].values).any(axis=1)
    keep = [i for i, label in enumerate(labels) if label in wanted and (picked[i] or not named)]
    if not picked[keep].any():
        empty = ", ".join(label for label, has in zip(labels, picked, strict=True) if not has)
        raise refusal(
            path, "twtt", "at least one layer with picks", f"only NaN in {one_line(empty, 200)}"
        )
    dataset = dataset.isel(layer=keep)
    if named:
        order = order_from_surface(dataset["twtt"].values, [labels[i] for i in keep], path)
        dataset = dataset.isel(layer=order)
    check_layers(dataset, str(path))
    return dataset
