"""Scene sets: NetCDF files of many scenes of different heights, read scene by scene."""

import json
from collections.abc import Iterable
from os import PathLike
from pathlib import Path
from typing import Self

import netCDF4
import numpy as np

from snowsim.echogram import Echoes, Kind, Scene
from snowsim.io.containers import check_heaps
from snowsim.io.files import BadFile, library_errors, written_whole

SCENES_FORMAT = "snowsim scenes 2"
# For each variable: its type, its first dimension and its unit. The dimension is `scene`, or one
# along which the rows of all scenes follow each other.
SCENE_VARIABLES = {
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
# These are written last, in this order: the order of writing decides the bytes of the file.
WRITTEN_LAST = ("n_complete_layers", "image", "layer_bins", "complete_layer_bins")
# Group of the file for echoes, and its variables, which are fields of `snowsim.echogram.Echoes`.
ECHO_GROUP = "echoes"
ECHO_VARIABLES = {
    "n_rows": ("i4", "scene", None),
    "bins": ("f8", "row", "bin"),
    "power": ("f8", "row", "W"),
    "variance_bins2": ("f8", "row", "bin2"),
    "decay_rate": ("f8", "row", "bin-1"),
    "kind": ("i1", "row", None),
    "noise_power": ("f8", "scene", "W"),
    "n_looks": ("f8", "scene", "1"),
    "line_gain_spread_db": ("f8", "scene", "dB"),
    "speckle_correlation": ("f8", "scene", "1"),
}
# For an array of a scene, the variable with its number of rows.
COUNT_OF_ARRAY = {
    "layer_bins": "n_layers",
    "complete_layer_bins": "n_complete_layers",
    "kind": "n_rows",
}
# For a dimension, the variable with the number of rows that each scene has along it.
COUNT_OF_DIMENSION = {
    "pixel_row": "n_range_bins",
    "layer_row": "n_layers",
    "complete_row": "n_complete_layers",
    "row": "n_rows",
}


def write_scenes(path, scenes, attributes=None):
    """Write scenes to one file, in order; one scene at a time is held in memory.

    There must be at least one scene, and all must have the same number of range lines and the same
    arrays; else ValueError. `attributes` become global attributes of the file (``method``,
    ``synthetic``).

    Images of all scenes follow each other along `pixel_row`, layers along `layer_row`, as
    contiguous ragged arrays of the CF conventions, section 9.3.3. `n_range_bins`, `n_layers` and
    `n_complete_layers` are the numbers of rows of each scene. Positions of layers are float32,
    which is exact to 1e-4 bins at row 2000. The group `echoes` is laid out alike, in float64.
    """
    with written_whole(path) as aside, netCDF4.Dataset(aside, "w") as file:
        file.format = SCENES_FORMAT
        file.setncatts(attributes or {})
        for scene in scenes:
            values = _values(scene, SCENE_VARIABLES)
            echoes = _values(scene.echoes, ECHO_VARIABLES)
            if not file.dimensions:
                file.createDimension("scene", None)
                file.createDimension("range_line", scene.n_range_lines)
                _define(file, SCENE_VARIABLES, values)
                if echoes:
                    _define(file.createGroup(ECHO_GROUP), ECHO_VARIABLES, echoes)
            held = [*file.variables, *(file[ECHO_GROUP].variables if file.groups else ())]
            n_range_lines = len(file.dimensions["range_line"])
            if set(held) != {*values, *echoes} or scene.n_range_lines != n_range_lines:
                msg = f"{path}: scene {scene.name}: expected {', '.join(held)} of {n_range_lines} "
                msg += f"range lines as in the first scene, got {', '.join([*values, *echoes])}"
                raise ValueError(msg)
            # Taken before anything is written, since writing makes the dimension longer.
            index = len(file.dimensions["scene"])
            if echoes:
                _append(file[ECHO_GROUP], index, echoes)
            last = {name: values.pop(name) for name in WRITTEN_LAST if name in values}
            _append(file, index, values | last)
        if not file.dimensions:
            msg = f"{path}: expected at least one scene to write, got none"
            raise ValueError(msg)


def _values(record, table):
    """Values of a scene, or of its echoes, for the variables of `table`; {} if it has no echoes."""
    values = {name: getattr(record, name, None) for name in table}
    for name, count in COUNT_OF_ARRAY.items():
        if values.get(name) is not None:
            values[count] = len(values[name])
    if "notes" in values:
        values["notes"] = json.dumps(record.notes, sort_keys=True)
    return {name: value for name, value in values.items() if value is not None}


def _define(group, table, values):
    """Make the variables of a group, with shapes from the values of its first scene."""
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
    """Write the values of scene number `index`."""
    starts = {name: len(dimension) for name, dimension in group.dimensions.items()}
    for name, value in values.items():
        first = group[name].dimensions[0]
        rows = index if first == "scene" else slice(starts[first], starts[first] + len(value))
        group[name][rows] = value


class SceneSet:
    """Scenes of one or more files as a sequence; each is read when it is requested.

    Parameters
    ----------
    paths : path_like or iterable of path_like
        Files that `write_scenes` wrote. They stay open until `close`, or the end of a ``with``.

    Raises
    ------
    ValueError
        If a file is not a scene file, or is truncated.
    """

    def __init__(self, paths: str | PathLike[str] | Iterable[str | PathLike[str]]) -> None:
        self._files = []
        self._where = []
        for path in [paths] if isinstance(paths, str | Path) else paths:
            with library_errors(path, "scenes: expected a scene file (NetCDF-4)"):
                check_heaps(Path(path).read_bytes())
                # With weak references the file closes as soon as nothing uses it, not whenever
                # Python next collects cycles of references.
                file = netCDF4.Dataset(path, keepweakref=True)
                self._files.append(file)
                if getattr(file, "format", None) != SCENES_FORMAT:
                    msg = f"scenes: expected a scene file, of attribute format '{SCENES_FORMAT}'"
                    raise BadFile(msg)
                file.set_auto_maskandscale(False)
                groups = [_Group(group) for group in (file, *file.groups.values())]
                for index in range(len(file.dimensions["scene"])):
                    self._where.append((file, groups, index))
        self.attributes = self._files[0].__dict__ if self._files else {}

    def __len__(self) -> int:
        return len(self._where)

    def __getitem__(self, item: int) -> Scene:
        file, groups, index = self._where[item]
        with library_errors(file.filepath(), f"scene {index}: expected one that can be read"):
            values, *held = (group.read(index) for group in groups)
            for echoes in held:
                del echoes["n_rows"]
                values["echoes"] = Echoes(**echoes)
            for name, count in COUNT_OF_ARRAY.items():
                if values.pop(count, None) is not None:
                    values[name] = values[name].astype(float)
            return Scene(**values | {"notes": json.loads(values["notes"])})

    def close(self) -> None:
        """Close the files."""
        for file in self._files:
            file.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()


class _Group:
    """Variables of one group: numbers of all scenes are in memory, rows are read scene by scene."""

    def __init__(self, group):
        self._columns = {}
        self._arrays = {}
        for name, variable in group.variables.items():
            row = variable.dimensions[0]
            if row != "scene":
                ends = np.cumsum(group[COUNT_OF_DIMENSION[row]][:])
                self._arrays[name] = (variable, np.append(0, ends))
            else:
                self._columns[name] = variable[:] if variable.ndim > 1 else variable[:].tolist()

    def read(self, index):
        """Values of one scene, by name of the variable."""
        values = {name: column[index] for name, column in self._columns.items()}
        for name, (variable, ends) in self._arrays.items():
            values[name] = np.asarray(variable[ends[index] : ends[index + 1]])
            is_float = variable.dtype.kind == "f"
            if is_float and (values[name] == variable.get_fill_value()).any():
                msg = f"{name}: expected numbers, found values that were never written"
                raise BadFile(msg)
        return values
