"""Scene sets on disk: ragged NetCDF files, written whole or not at all, read scene by scene."""

import json
from pathlib import Path

import netCDF4
import numpy as np

from snowsim.echogram import Echoes, Kind, Scene
from snowsim.io.containers import check_heaps
from snowsim.io.files import BadFile, library_errors, written_whole

FORMAT = "snowsim scenes 2"
# Type of every variable, its first dimension, `scene` or one along which scenes stand below
# each other, and its unit.
SCENE = {
    "image": ("u1", "pixel_row", None),
    "layer_bins": ("f4", "layer_row", None),
    "complete_layer_bins": ("f4", "complete_row", None),
    "name": (str, "scene", None),
    "notes": (str, "scene", None),
    "n_range_bins": ("i4", "scene", None),
    "n_layers": ("i4", "scene", None),
    "n_complete_layers": ("i4", "scene", None),
    "noise_floor_db": ("f8", "scene", None),
    "maximum_db": ("f8", "scene", None),
    "zone": ("i4", "scene", None),
}
# What is written after the other numbers of a scene: files repeat to the byte.
LAST = ("n_complete_layers", "image", "layer_bins", "complete_layer_bins")
# The group of a scene's echoes, and what it holds of `snowsim.echogram.Echoes`.
GROUP = "echoes"
ECHOES = {
    "n_rows": ("i4", "scene", None),
    "bins": ("f8", "row", "bin"),
    "power": ("f8", "row", "W"),
    "variance_bins2": ("f8", "row", "bin2"),
    "decay_rate": ("f8", "row", "bin-1"),
    "kind": ("i1", "row", None),
    "noise_power": ("f8", "scene", "W"),
    "n_looks": ("f8", "scene", "1"),
    "line_gain_spread_db": ("f8", "scene", "dB"),
    "decay_factor": ("f8", "scene", "1"),
    "speckle_correlation": ("f8", "scene", "1"),
}
# Which variable tells how many rows another has.
COUNTED = {"layer_bins": "n_layers", "complete_layer_bins": "n_complete_layers", "kind": "n_rows"}
# How many rows a scene has along a dimension.
COUNTS = {
    "pixel_row": "n_range_bins",
    "layer_row": "n_layers",
    "complete_row": "n_complete_layers",
    "row": "n_rows",
}


def write_scenes(path, scenes, attributes=None):
    """Write scenes to one file, in order, holding one at a time.

    At least one, all with the same number of range lines and the same arrays present; others are
    refused. `attributes` are global (what made them; ``synthetic``). Images and layers of all
    scenes stand below each other (the contiguous ragged arrays of the CF conventions, section
    9.3.3); `n_range_bins`, `n_layers` and `n_complete_layers` tell where each begins. Layer bins
    are float32: 1e-4 bins at row 2000. The group `echoes` is laid out alike, in float64.
    """
    with written_whole(path) as aside, netCDF4.Dataset(aside, "w") as file:
        file.format = FORMAT
        file.setncatts(attributes or {})
        for scene in scenes:
            values = _values(scene, SCENE)
            echoes = _values(scene.echoes, ECHOES)
            if not file.dimensions:
                file.createDimension("scene", None)
                file.createDimension("range_line", scene.n_range_lines)
                _define(file, SCENE, values)
                if echoes:
                    _define(file.createGroup(GROUP), ECHOES, echoes)
            held = [*file.variables, *(file[GROUP].variables if file.groups else ())]
            n_range_lines = len(file.dimensions["range_line"])
            if set(held) != {*values, *echoes} or scene.n_range_lines != n_range_lines:
                msg = f"{path}: scene {scene.name}: expected {', '.join(held)} of {n_range_lines} "
                msg += f"range lines as in the first scene, got {', '.join([*values, *echoes])}"
                raise ValueError(msg)
            # Before anything is written: that makes the dimensions longer.
            index = len(file.dimensions["scene"])
            if echoes:
                _append(file[GROUP], index, echoes)
            last = {name: values.pop(name) for name in LAST if name in values}
            _append(file, index, values | last)
        if not file.dimensions:
            msg = f"{path}: expected at least one scene to write, got none"
            raise ValueError(msg)


def _values(record, table):
    """What the file holds of a scene, or of its echoes if it has any, by name."""
    values = {name: getattr(record, name, None) for name in table}
    for name, count in COUNTED.items():
        if values.get(name) is not None:
            values[count] = len(values[name])
    if "notes" in values:
        values["notes"] = json.dumps(record.notes, sort_keys=True)
    return {name: value for name, value in values.items() if value is not None}


def _define(group, table, values):
    """Make variables of a group for the values of its first scene."""
    for name, value in values.items():
        dtype, first, units = table[name]
        dimensions = [first]
        options = {}
        if first != "scene" and first not in group.dimensions:
            group.createDimension(first, None)
        if name == "speckle_correlation":
            group.createDimension("lag", len(value))
            dimensions.append("lag")
        elif np.ndim(value) == 2:
            dimensions.append("range_line")
            chunks = (64, value.shape[1])
            options = {"chunksizes": chunks, "zlib": dtype != "u1", "complevel": 1}
        variable = group.createVariable(name, dtype, dimensions, **options)
        if units:
            variable.units = units
        if name == "n_rows":
            variable.sample_dimension = "row"
        if name == "kind":
            variable.flag_values = np.array(Kind, dtype=np.int8)
            variable.flag_meanings = " ".join(one.name.lower() for one in Kind)


def _append(group, index, values):
    """Write the values of one scene."""
    starts = {name: len(dimension) for name, dimension in group.dimensions.items()}
    for name, value in values.items():
        first = group[name].dimensions[0]
        rows = index if first == "scene" else slice(starts[first], starts[first] + len(value))
        group[name][rows] = value


class SceneSet:
    """Scenes of one or more files as a sequence; a scene is read when it is asked for.

    Parameters
    ----------
    paths : path_like or iterable of path_like
        Files of `write_scenes`.

    Raises
    ------
    ValueError
        If a file is no scene file or was truncated.
    """

    def __init__(self, paths):
        self._files = []
        self._where = []
        for path in [paths] if isinstance(paths, str | Path) else paths:
            with library_errors(path, "scenes: expected a scene file (NetCDF-4)"):
                check_heaps(Path(path).read_bytes())
                # Without cycles of references a file closes with its last user, not whenever Python
                # collects garbage.
                file = netCDF4.Dataset(path, keepweakref=True)
                self._files.append(file)
                if getattr(file, "format", None) != FORMAT:
                    msg = f"scenes: expected a scene file, of attribute format '{FORMAT}'"
                    raise BadFile(msg)
                file.set_auto_maskandscale(False)
                groups = [_Group(group) for group in (file, *file.groups.values())]
                for index in range(len(file.dimensions["scene"])):
                    self._where.append((file, groups, index))
        self.attributes = self._files[0].__dict__ if self._files else {}

    def __len__(self):
        return len(self._where)

    def __getitem__(self, item):
        file, groups, index = self._where[item]
        with library_errors(file.filepath(), f"scene {index}: expected one that can be read"):
            values, *held = (group.read(index) for group in groups)
            for echoes in held:
                del echoes["n_rows"]
                values["echoes"] = Echoes(**echoes)
            for name, count in COUNTED.items():
                if values.pop(count, None) is not None:
                    values[name] = values[name].astype(float)
            return Scene(**values | {"notes": json.loads(values["notes"])})

    def close(self):
        """Close the files."""
        for file in self._files:
            file.close()

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        self.close()


class _Group:
    """Variables of a file's group: rows of one scene are read, numbers of all are held."""

    def __init__(self, group):
        self._columns = {}
        self._arrays = {}
        for name, variable in group.variables.items():
            row = variable.dimensions[0]
            if row != "scene":
                ends = np.cumsum(group[COUNTS[row]][:])
                self._arrays[name] = (variable, np.append(0, ends))
            else:
                self._columns[name] = variable[:] if variable.ndim > 1 else variable[:].tolist()

    def read(self, index):
        """What is held of one scene, by name."""
        values = {name: column[index] for name, column in self._columns.items()}
        for name, (variable, ends) in self._arrays.items():
            values[name] = np.asarray(variable[ends[index] : ends[index + 1]])
            is_float = variable.dtype.kind == "f"
            if is_float and (values[name] == variable.get_fill_value()).any():
                msg = f"{name}: expected numbers, found values that were never written"
                raise BadFile(msg)
        return values
