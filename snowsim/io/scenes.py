"""Scene sets on disk: ragged NetCDF files, written whole or not at all, read scene by scene."""

import json
from dataclasses import dataclass
from pathlib import Path

import netCDF4
import numpy as np

from snowsim.echoes import Echoes, Kind
from snowsim.echogram import Scene
from snowsim.io.files import written_whole
from snowsim.io.guard import library_errors

FORMAT = "snowsim scenes 1"
# Optional arrays of a scene: attribute, the ragged dimension it stacks along, type on disk.
ARRAYS = {
    "image": ("pixel_row", "u1"),
    "layer_bins": ("layer_row", "f4"),
    "complete_layer_bins": ("complete_row", "f4"),
}
COUNTS = {
    "pixel_row": "n_range_bins",
    "layer_row": "n_layers",
    "complete_row": "n_complete_layers",
}
NUMBERS = {"noise_floor_db": "f8", "maximum_db": "f8", "zone": "i4"}

# The group of a scene's echoes, and what it holds of `snowsim.echoes.Echoes` by units.
GROUP = "echoes"
ALONG_TRACK = {"bins": "bin", "power": "W"}  # (row, range_line)
BY_ROW = {"variance_bins2": "bin2", "decay_rate": "bin-1"}
BY_SCENE = {
    "noise_power": "W",
    "n_looks": "1",
    "line_gain_spread_db": "dB",
    "decay_factor": "1",
}
TEXTURE = {"texture_variance": "1", "texture_length_bins": "bin", "texture_length_lines": "1"}


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
            if not file.dimensions:
                _define(file, scene)
            _check_alike(file, scene, path)
            # Before anything is written: that makes the dimensions longer.
            index = len(file.dimensions["scene"])
            if scene.echoes is not None:
                _append_echoes(file[GROUP], index, scene.echoes)
            _append(file, index, scene)
        if not file.dimensions:
            msg = f"{path}: expected at least one scene to write, got none"
            raise ValueError(msg)


def _present(scene):
    """Names of the optional parts that a scene has."""
    return [name for name in (*ARRAYS, GROUP) if getattr(scene, name) is not None]


def _held(file):
    """Names of the optional parts that scenes of a file have."""
    return [name for name in ARRAYS if name in file.variables] + list(file.groups)


def _define(file, scene):
    file.createDimension("scene", None)
    file.createDimension("range_line", scene.n_range_lines)
    for name, (row, dtype) in ARRAYS.items():
        if getattr(scene, name) is not None:
            file.createDimension(row, None)
            chunks = (64, scene.n_range_lines)
            compressed = {"zlib": dtype != "u1", "complevel": 1}
            file.createVariable(name, dtype, (row, "range_line"), chunksizes=chunks, **compressed)
    numbers = {"name": str, "notes": str, "n_range_bins": "i4", "n_layers": "i4"}
    if scene.complete_layer_bins is not None:
        numbers["n_complete_layers"] = "i4"
    for name, dtype in (numbers | NUMBERS).items():
        file.createVariable(name, dtype, ("scene",))
    if scene.echoes is not None:
        _define_echoes(file.createGroup(GROUP), scene.n_range_lines, scene.echoes)


def _define_echoes(group, n_range_lines, echoes):
    group.createDimension("row", None)
    group.createVariable("n_rows", "i4", ("scene",)).sample_dimension = "row"
    for name, units in ALONG_TRACK.items():
        chunks = (64, n_range_lines)
        dimensions = ("row", "range_line")
        variable = group.createVariable(
            name, "f8", dimensions, chunksizes=chunks, zlib=True, complevel=1
        )
        variable.units = units
    for name, units in BY_ROW.items():
        group.createVariable(name, "f8", ("row",)).units = units
    kind = group.createVariable("kind", "i1", ("row",))
    kind.flag_values = np.array(Kind, dtype=np.int8)
    kind.flag_meanings = " ".join(one.name.lower() for one in Kind)
    numbers = BY_SCENE if echoes.texture is None else BY_SCENE | TEXTURE
    for name, units in numbers.items():
        group.createVariable(name, "f8", ("scene",)).units = units
    if echoes.speckle_correlation is not None:
        group.createDimension("lag", len(echoes.speckle_correlation))
        group.createVariable("speckle_correlation", "f8", ("scene", "lag")).units = "1"


def _check_alike(file, scene, path):
    held = _held(file)
    n_range_lines = len(file.dimensions["range_line"])
    if _present(scene) != held or scene.n_range_lines != n_range_lines:
        msg = f"{path}: scene {scene.name}: expected {held} of {n_range_lines} range lines as in "
        msg += f"the first scene, got {_present(scene)} of {scene.n_range_lines}"
        raise ValueError(msg)


def _append(file, index, scene):
    starts = {row: len(file.dimensions[row]) for row in COUNTS if row in file.dimensions}
    file["name"][index] = scene.name
    file["notes"][index] = json.dumps(scene.notes, sort_keys=True)
    file["n_range_bins"][index] = scene.n_range_bins
    file["n_layers"][index] = scene.layer_bins.shape[0]
    for name in NUMBERS:
        file[name][index] = getattr(scene, name)
    if scene.complete_layer_bins is not None:
        file["n_complete_layers"][index] = scene.complete_layer_bins.shape[0]
    for name, (row, _) in ARRAYS.items():
        if name in file.variables:
            values = getattr(scene, name)
            file[name][starts[row] : starts[row] + len(values)] = values


def _append_echoes(group, index, echoes):
    start = len(group.dimensions["row"])
    n_rows = len(echoes.kind)
    group["n_rows"][index] = n_rows
    for name in (*ALONG_TRACK, *BY_ROW, "kind"):
        group[name][start : start + n_rows] = getattr(echoes, name)
    for name in BY_SCENE:
        group[name][index] = getattr(echoes, name)
    if echoes.texture is not None:
        for name, value in zip(TEXTURE, echoes.texture, strict=True):
            group[name][index] = value
    if echoes.speckle_correlation is not None:
        group["speckle_correlation"][index] = echoes.speckle_correlation


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
        paths = [paths] if isinstance(paths, str | Path) else list(paths)
        self._files = []
        self._where = []
        for path in paths:
            self._index(path)
        self.attributes = self._files[0].__dict__ if self._files else {}

    def _index(self, path):
        try:
            # Without cycles of references a file closes with its last user, not whenever Python
            # collects garbage.
            file = netCDF4.Dataset(path, keepweakref=True)
        except (OSError, RuntimeError) as error:
            msg = f"{path}: expected a scene file (NetCDF-4), cannot be read: {error}"
            raise ValueError(msg) from error
        found = getattr(file, "format", None)
        if found != FORMAT:
            msg = f"{path}: expected attribute format '{FORMAT}', got {found!r}"
            raise ValueError(msg)
        file.set_auto_maskandscale(False)
        self._files.append(file)
        with library_errors(path, "scenes", "ones that can be read"):
            rows = {
                row: _slices(file[count][:])
                for row, count in COUNTS.items()
                if count in file.variables
            }
            if GROUP in file.groups:
                rows[GROUP] = _slices(file[GROUP]["n_rows"][:])
            numbers = {name: file[name][:].tolist() for name in ("name", "notes", *NUMBERS)}
            for index in range(len(numbers["name"])):
                own_rows = {name: slices[index] for name, slices in rows.items()}
                own_numbers = {name: values[index] for name, values in numbers.items()}
                self._where.append(_Place(file, index, own_rows, own_numbers))

    def __len__(self):
        return len(self._where)

    def __getitem__(self, item):
        place = self._where[item]
        file = place.file
        with library_errors(file.filepath(), f"scene {place.index}", "one that can be read"):
            arrays = {}
            for name, (row, dtype) in ARRAYS.items():
                if name in file.variables:
                    values = np.asarray(file[name][place.rows[row]])
                    arrays[name] = values if dtype == "u1" else values.astype(float)
            pixels = place.rows["pixel_row"]
            return Scene(
                **place.numbers | {"notes": json.loads(place.numbers["notes"])},
                **arrays,
                n_range_bins=int(pixels.stop - pixels.start),
                echoes=_read_echoes(place) if GROUP in file.groups else None,
            )

    def close(self):
        """Close the files."""
        for file in self._files:
            file.close()

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        self.close()


@dataclass(frozen=True)
class _Place:
    """Where a scene lies, by file, index and rows in ragged arrays; its name, notes and numbers."""

    file: netCDF4.Dataset
    index: int
    rows: dict
    numbers: dict


def _slices(counts):
    """Where each scene's rows lie in a ragged array, from how many it has."""
    ends = np.cumsum(counts)
    return [slice(end - count, end) for end, count in zip(ends, counts, strict=True)]


def _read_echoes(place):
    group = place.file[GROUP]
    rows = place.rows[GROUP]
    arrays = {name: np.asarray(group[name][rows]) for name in (*ALONG_TRACK, *BY_ROW, "kind")}
    numbers = {name: float(group[name][place.index]) for name in BY_SCENE}
    texture = None
    if "texture_variance" in group.variables:
        texture = tuple(float(group[name][place.index]) for name in TEXTURE)
    correlation = None
    if "speckle_correlation" in group.variables:
        correlation = np.asarray(group["speckle_correlation"][place.index])
    return Echoes(**arrays, **numbers, texture=texture, speckle_correlation=correlation)
