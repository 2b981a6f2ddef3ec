"""Scene sets on disk: ragged NetCDF files, written whole or not at all, read lazily scene by scene."""

import json
from pathlib import Path

import netCDF4
import numpy as np

from snowsim.echogram import Scene
from snowsim.io.files import written_whole
from snowsim.io.guard import library_errors

FORMAT = "snowsim scenes 1"
# Optional arrays of a scene: attribute, the ragged dimension it stacks along, type on disk.
ARRAYS = {
    "image": ("pixel_row", "u1"),
    "layer_bins": ("layer_row", "f4"),
    "complete_layer_bins": ("complete_row", "f4"),
    "peak_power": ("complete_row", "f4"),
}
NUMBERS = {"noise_floor_db": "f8", "maximum_db": "f8", "zone": "i4"}


def write_scenes(path, scenes, attributes=None):
    """Write scenes to one file, in order, holding one at a time.

    At least one, all with the same number of range lines and the same arrays present; others are
    refused. `attributes` are global (what made them; ``synthetic``). Images and layers of all
    scenes stand below each other (the contiguous ragged arrays of the CF conventions, section
    9.3.3); `n_range_bins`, `n_layers` and `n_complete_layers` tell where each begins. Layer bins
    are float32: 1e-4 bins at row 2000.
    """
    with written_whole(path) as aside, netCDF4.Dataset(aside, "w") as file:
        file.format = FORMAT
        file.setncatts(attributes or {})
        for scene in scenes:
            if not file.dimensions:
                _define(file, scene)
            _append(file, scene, path)
        if not file.dimensions:
            msg = f"{path}: expected at least one scene to write, got none"
            raise ValueError(msg)


def _present(scene):
    return [name for name in ARRAYS if getattr(scene, name) is not None]


def _define(file, scene):
    file.createDimension("scene", None)
    file.createDimension("range_line", scene.n_range_lines)
    for name in _present(scene):
        dimension, dtype = ARRAYS[name]
        if dimension not in file.dimensions:
            file.createDimension(dimension, None)
        chunks = (64, scene.n_range_lines)
        file.createVariable(
            name,
            dtype,
            (dimension, "range_line"),
            chunksizes=chunks,
            zlib=dtype != "u1",
            complevel=1,
        )
    counts = {"n_range_bins": "i4", "n_layers": "i4"}
    counts |= {"n_complete_layers": "i4"} if scene.complete_layer_bins is not None else {}
    for name, dtype in ({"name": str, "notes": str} | counts | NUMBERS).items():
        file.createVariable(name, dtype, ("scene",))


def _append(file, scene, path):
    held = [name for name in ARRAYS if name in file.variables]
    if _present(scene) != held or scene.n_range_lines != len(file.dimensions["range_line"]):
        msg = f"{path}: scene {scene.name}: expected {held} of {len(file.dimensions['range_line'])} range lines as in "
        msg += f"the first scene, got {_present(scene)} of {scene.n_range_lines}"
        raise ValueError(msg)
    # Before anything is written: that makes the dimensions longer.
    starts = {name: len(dimension) for name, dimension in file.dimensions.items()}
    index = starts["scene"]
    file["name"][index] = scene.name
    file["notes"][index] = json.dumps(scene.notes, sort_keys=True)
    file["n_range_bins"][index] = scene.n_range_bins
    file["n_layers"][index] = scene.layer_bins.shape[0]
    for name in NUMBERS:
        file[name][index] = getattr(scene, name)
    lengths = {"pixel_row": scene.n_range_bins, "layer_row": scene.layer_bins.shape[0]}
    if scene.complete_layer_bins is not None:
        lengths["complete_row"] = file["n_complete_layers"][index] = (
            scene.complete_layer_bins.shape[0]
        )
    for name in held:
        dimension = ARRAYS[name][0]
        file[name][starts[dimension] : starts[dimension] + lengths[dimension]] = getattr(
            scene, name
        )


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
        self._where = []  # (file, index in it, rows by ragged dimension, name, notes and numbers)
        self.zones = []
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
        if getattr(file, "format", None) != FORMAT:
            msg = f"{path}: expected attribute format '{FORMAT}', got {getattr(file, 'format', None)!r}"
            raise ValueError(msg)
        file.set_auto_maskandscale(False)
        self._files.append(file)
        counts = {
            "pixel_row": "n_range_bins",
            "layer_row": "n_layers",
            "complete_row": "n_complete_layers",
        }
        with library_errors(path, "scenes", "ones that can be read"):
            ends = {
                row: np.cumsum(file[name][:])
                for row, name in counts.items()
                if name in file.variables
            }
            columns = (file[name][:].tolist() for name in ("name", "notes", *NUMBERS))
            for i, rest in enumerate(zip(*columns, strict=True)):
                spans = {row: slice(end[i - 1] if i else 0, end[i]) for row, end in ends.items()}
                self._where.append((file, i, spans, rest))
            self.zones += file["zone"][:].tolist()

    def __len__(self):
        return len(self._where)

    def __getitem__(self, item):
        file, index, spans, (scene, notes, *numbers) = self._where[item]
        with library_errors(file.filepath(), f"scene {index}", "one that can be read"):
            arrays = {}
            for name, (_, dtype) in ARRAYS.items():
                if name in file.variables:
                    # Files of 0.1.0 hold as many complete layers as labelled ones, in the same
                    # rows.
                    values = np.asarray(file[name][spans[file[name].dimensions[0]]])
                    arrays[name] = values if dtype == "u1" else values.astype(float)
            numbers = dict(zip(NUMBERS, numbers, strict=True))
            n_range_bins = int(spans["pixel_row"].stop - spans["pixel_row"].start)
            return Scene(scene, n_range_bins, **arrays, **numbers, notes=json.loads(notes))

    def close(self):
        """Close the files."""
        for file in self._files:
            file.close()

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        self.close()
