"""CReSIS layer files, old and new, to layer datasets with named layers ordered from the snow surface down."""

import re
from pathlib import Path

import numpy as np

from snowsim.io.datasets import from_gps_seconds, layers_dataset
from snowsim.io.guard import existing, matrix, numeric, one_line, refusal, vector
from snowsim.io.matlab import names_in_matlab, read_matlab

SURFACE = "surface"
# What the first two entries of an old file are where it gives no names: the format's own convention.
OLD_NAMES = ("surface", "bottom")


def read_cresis_layers(path, *, names=None, missing="refuse", organizer=None):
    """Layers of a new CReSIS layer file (`CSARP_layer`); names come from the organizer file beside it.

    Parameters
    ----------
    path : path_like
    names : iterable of str, optional
        Read these layers only ("surface", "Koenig_2"); by default all.
    missing : {"refuse", "skip"}
        What becomes of a file that has no layer of one of the `names`.
    organizer : path_like, optional
        `layer_YYYYMMDD_SS.mat`; by default the one beside `path`. Without one, layers are named "id 1", "id 2", ...

    Returns
    -------
    xarray.Dataset
        As `snowsim.echogram.check_layers` wants it. `layer` holds the names (group:name where a name comes twice),
        from the surface down; layers without a single pick are left out and listed in `attrs["empty_layers"]`.

    Raises
    ------
    ValueError
        One line with file, variable, expected and found; also if no layer is left, or if layers cross.
    """
    path = existing(path)
    values = read_matlab(path, ("gps_time", "twtt", "id", "quality", "type", "lat", "lon", "elev"))
    for name in ("gps_time", "twtt", "id"):
        if name not in values:
            raise refusal(path, name, "variables gps_time, id, twtt", _listing(path))
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
        flags = np.full((n_layers, n_lines), default) if absent else matrix(path, name, flags, n_layers, n_lines)
        content[name] = _flags(path, name, flags)
    content["names"], content["groups"] = _organized(path, ids, organizer)
    return _finished(path, content, values, ("lat", "lon", "elev"), (names, missing), "CReSIS layer")


def read_cresis_layer_data(path, *, names=None, missing="refuse"):
    """Layers of an old CReSIS layer file (`CSARP_layerData`); as `read_cresis_layers`.

    Picks are `layerData{i}.value{2}.data`; where `value{1}` has a manual pick, the type is 1, else 2. Entries without
    a name are the surface and the bottom, in this order, as the format has it; a third without one is refused.
    """
    path = existing(path)
    values = read_matlab(path, ("layerData", "GPS_time", "Latitude", "Longitude", "Elevation"))
    for name in ("GPS_time", "layerData"):
        if name not in values:
            raise refusal(path, name, "variables GPS_time, layerData", _listing(path))
    gps_time = vector(path, "GPS_time", values["GPS_time"])
    entries = values["layerData"]
    entries = [entries] if isinstance(entries, dict) else entries
    if not isinstance(entries, list) or not entries:
        raise refusal(path, "layerData", "a cell of structs", type(entries).__name__)
    parts = [_entry(path, number, entry, gps_time.size) for number, entry in enumerate(entries)]
    content = {name: np.array([part[name] for part in parts]) for name in ("twtt", "quality", "type")}
    content["names"] = [part["name"] for part in parts]
    content["groups"] = [part["group"] for part in parts]
    content["slow_time"] = from_gps_seconds(path, "GPS_time", gps_time)
    return _finished(
        path, content, values, ("Latitude", "Longitude", "Elevation"), (names, missing), "CReSIS layerData"
    )


def order_from_surface(twtt, names, path="layers"):
    """Order of layers from the surface down, by what lies above what, (layer,) of int.

    Layer i goes before j if it is above it on some line both are picked on. Layers that share no line are ordered by
    their median depth below the surface. The layer named "surface" goes before all others.

    Raises
    ------
    ValueError
        If two layers cross or touch, also by way of others.
    """
    twtt = np.asarray(twtt, dtype=float)
    n_layers = len(names)
    with np.errstate(invalid="ignore"):
        above = np.array([[np.any(twtt[i] <= twtt[j]) and i != j for j in range(n_layers)] for i in range(n_layers)])
    both = np.argwhere(above & above.T)
    if both.size:
        i, j = both[0]
        line = int(np.argmax(twtt[i] <= twtt[j])) if np.any(twtt[i] < twtt[j]) else 0
        found = f"{names[i]} and {names[j]} cross or touch near range_line {line}"
        raise refusal(path, "twtt", "layers that keep their order", found)
    surface = surface_among(names)
    if surface is not None:
        if above[:, surface].any():
            other = names[int(np.argmax(above[:, surface]))]
            raise refusal(path, "twtt", "the surface above all layers", f"{other} above it")
        above[surface] = np.arange(n_layers) != surface
        depth = np.array([_median(row - twtt[surface], row) for row in twtt])
    else:
        depth = np.array([_median(row, row) for row in twtt])
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


def find_organizer(path):
    """The organizer file beside a new layer file, or None."""
    path = Path(path)
    segment = re.search(r"\d{8}_\d{2}", path.stem)
    organizer = path.with_name(f"layer_{segment.group()}.mat") if segment else path
    return organizer if organizer.is_file() and organizer != path else None


def _median(values, fallback):
    """Median over finite values; over those of `fallback` where there are none."""
    values = values[np.isfinite(values)]
    return np.median(values) if values.size else np.median(fallback[np.isfinite(fallback)])


def _listing(path):
    return one_line(", ".join(sorted(names_in_matlab(path))), 200)


def _flags(path, what, values):
    """Flags as uint8; 0 where a file has NaN in their place."""
    values = np.asarray(values, dtype=float)
    flags = np.where(np.isnan(values), 0, values)
    bad = (flags < 0) | (flags > 255)
    if bad.any():
        raise refusal(path, what, "flags within 0 to 255", f"{flags[bad][0]:g}")
    return flags.astype(np.uint8)


def _organized(path, ids, organizer):
    """Names and groups of layer ids; "id 3" where no organizer file knows them."""
    organizer = find_organizer(path) if organizer is None else existing(organizer)
    named = {}
    if organizer is not None:
        values = read_matlab(organizer, ("lyr_id", "lyr_name", "lyr_group_name"))
        for name in ("lyr_id", "lyr_name"):
            if name not in values:
                raise refusal(organizer, name, "variables lyr_id, lyr_name", _listing(organizer))
        known = vector(organizer, "lyr_id", values["lyr_id"])
        names = _texts(organizer, "lyr_name", values["lyr_name"], known.size)
        groups = _texts(organizer, "lyr_group_name", values.get("lyr_group_name", [""] * known.size), known.size)
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
    if not isinstance(value, list) or len(value) < 2 or not all(isinstance(v, dict) and "data" in v for v in value[:2]):
        raise refusal(path, f"{where}.value", "two structs with data", type(value).__name__)
    manual = value[0]["data"]
    manual = np.full(n_lines, np.nan) if np.size(manual) == 0 else vector(path, f"{where}.value{{1}}", manual, n_lines)
    picks = vector(path, f"{where}.value{{2}}.data", value[1]["data"], n_lines)
    quality = entry.get("quality")
    quality = np.ones(n_lines) if np.size(quality) != n_lines else vector(path, f"{where}.quality", quality, n_lines)
    name = entry.get("name")
    if not isinstance(name, str) or not name:
        if number >= len(OLD_NAMES):
            raise refusal(path, f"{where}.name", "a name", "none")
        name = OLD_NAMES[number]
    group = entry.get("group_name")
    return {
        "twtt": picks,
        "quality": _flags(path, f"{where}.quality", quality),
        "type": np.where(np.isfinite(manual), 1, 2).astype(np.uint8),
        "name": name,
        "group": group if isinstance(group, str) else "",
    }


def _finished(path, content, values, positions, wanted, source):
    """Drop layers without picks, select by name, order from the surface down, and hand on to the validator."""
    if np.isinf(content["twtt"]).any():
        raise refusal(path, "twtt", "finite travel times or NaN", "infinite ones")
    layer_names = list(content["names"])
    twice = {name for name in layer_names if layer_names.count(name) > 1}
    groups = content["groups"]
    layer_names = [f"{group}:{n}" if n in twice else n for n, group in zip(layer_names, groups, strict=True)]
    if len(set(layer_names)) < len(layer_names):
        raise refusal(path, "layers", "names that differ", one_line(", ".join(layer_names), 200))
    names, missing = wanted
    for name in names or ():
        if name not in layer_names and missing == "refuse":
            raise refusal(path, "layers", f"one named {name}", one_line(", ".join(layer_names), 200))
    picked = np.isfinite(content["twtt"]).any(axis=1)
    empty = [name for name, has in zip(layer_names, picked, strict=True) if not has]
    keep = [i for i, name in enumerate(layer_names) if picked[i] and (names is None or name in set(names))]
    if not keep:
        raise refusal(path, "twtt", "at least one layer with picks", f"only NaN in {one_line(', '.join(empty), 200)}")
    order = order_from_surface(content["twtt"][keep], [layer_names[i] for i in keep], path)
    keep = [keep[i] for i in order]
    chosen = {name: content[name][keep] for name in ("twtt", "quality", "type")}
    chosen |= {"names": [layer_names[i] for i in keep], "groups": [groups[i] for i in keep]}
    chosen["slow_time"] = content["slow_time"]
    for name, ours in zip(positions, ("Latitude", "Longitude", "Elevation"), strict=True):
        if name in values:
            chosen[ours] = vector(path, name, numeric(path, name, values[name]), chosen["slow_time"].size)
    return layers_dataset(path, chosen, {"source_format": source, "empty_layers": ", ".join(empty)})
