"""Scenes for other people's code: the published benchmark's layout, layer-number images, xarray NetCDF."""

import io
import json
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import xarray as xr
from PIL import Image
from PIL.PngImagePlugin import PngInfo

from snowsim.echogram import Scene, check_layer_bins
from snowsim.io.containers import read_netcdf
from snowsim.io.files import write_dataset, written_whole
from snowsim.io.guard import existing, library_errors, numeric, refusal
from snowsim.io.images import NUMBERS_IN_TEXT

FORMAT = "snowsim scene 1"
ARRAYS = ("image", "layer_bins", "complete_layer_bins")
LAYERS = ("annotated", "complete")
MAXIMUM_NUMBER = 255  # layer numbers are 8-bit
# Plain names of files. Loaders replace "data_" wherever it stands, and "binary_" in front makes a number image a mask.
NAME = re.compile(r"(?!.*data_)(?!binary_)[A-Za-z0-9][A-Za-z0-9_.-]*")


def export_pairs(folder, scenes, *, list_name="all.lst", layers="annotated"):
    """Write scenes in the layout of the published benchmark.

    For each scene `data_<name>.png` (8-bit), `layer_binary_<name>.png` (1-bit) and `layer_<name>.png` (layer numbers,
    the surface being 1), then a list file with one `data_*.png` a line: what the loader of the published tracker
    code reads. Decibels of the grey levels go into text chunks of the image. The same scenes give the same bytes.

    Parameters
    ----------
    folder : path_like
        May hold other sets already, each with its list.
    scenes : iterable of Scene
        With images; one is held at a time.
    list_name : str
        Such as "train.lst".
    layers : {"annotated", "complete"}
        Which layers are the labels, for scenes that know both.

    Returns
    -------
    dict
        `n_scenes`, and `n_merged_pixels`: places where two layers round to one pixel, so that the upper one's is lost.

    Raises
    ------
    ValueError
        If a scene has no image, more than 255 layers, or a name that is no plain file name or comes twice; if the
        folder is itself called `*data_*`, which that loader would replace along with the file's name.

    Notes
    -----
    Read back, images are exact and layers are rounded to whole bins; what leaves the window is not drawn.
    """
    folder = Path(folder)
    if layers not in LAYERS:
        msg = f"layers must be one of {', '.join(LAYERS)}, got {layers}"
        raise ValueError(msg)
    if "data_" in folder.name:
        msg = f"{folder}: the folder's name must not contain data_, which loaders replace along with the file's"
        raise ValueError(msg)
    names, n_merged = [], 0
    for scene in scenes:
        _check_name(scene, names, folder)
        if scene.image is None:
            msg = f"{folder}: scene {scene.name}: expected an image to export, got none"
            raise ValueError(msg)
        layer_bins = _labels(scene, layers)
        numbers, merged = layer_numbers(layer_bins, scene.n_range_bins)
        texts = {name: repr(kind(getattr(scene, name))) for name, kind in NUMBERS_IN_TEXT.items()}
        _write_png(folder / f"data_{scene.name}.png", scene.image, texts)
        _write_png(folder / f"layer_binary_{scene.name}.png", numbers > 0)
        _write_png(folder / f"layer_{scene.name}.png", numbers)
        names.append(scene.name)
        n_merged += merged
    _write_list(folder, list_name, [f"data_{name}.png" for name in names])
    return {"n_scenes": len(names), "n_merged_pixels": n_merged}


def layer_numbers(layer_bins, n_range_bins):
    """Image of layer numbers, the surface being 1 and no layer 0.

    Parameters
    ----------
    layer_bins : array_like, (layer, range_line)
        Fractional range bins; NaN where absent. Layers outside the window leave no pixel.
    n_range_bins : int
        Height of the image.

    Returns
    -------
    numbers : ndarray of uint8, (range_bin, range_line)
        One pixel per layer and range line at the rounded bin; of two layers at one pixel, the lower.
    n_merged : int
        Pixels lost to a layer below.

    Raises
    ------
    ValueError
        If there are more than 255 layers.
    """
    layer_bins = np.asarray(layer_bins, dtype=float)
    if layer_bins.shape[0] > MAXIMUM_NUMBER:
        msg = f"layer numbers hold at most {MAXIMUM_NUMBER} layers, got {layer_bins.shape[0]}"
        raise ValueError(msg)
    numbers = np.zeros((n_range_bins, layer_bins.shape[1]), dtype=np.uint8)
    n_drawn = 0
    for number, bins in enumerate(layer_bins, start=1):
        lines = np.flatnonzero(np.isfinite(bins) & (bins > -0.5) & (bins < n_range_bins - 0.5))
        numbers[np.rint(bins[lines]).astype(int), lines] = number
        n_drawn += lines.size
    return numbers, n_drawn - int(np.count_nonzero(numbers))


def export_netcdf(folder, scenes, *, list_name="all.lst"):
    """Write scenes as one NetCDF file each, `scene_<name>.nc`, for xarray; and a list file. Nothing is rounded.

    Parameters
    ----------
    folder : path_like
    scenes : iterable of Scene
        With or without images; one is held at a time.
    list_name : str

    Returns
    -------
    dict
        `n_scenes`.

    Raises
    ------
    ValueError
        If a name is no plain file name or comes twice.

    Notes
    -----
    `image` (range_bin, range_line), `layer_bins` and perhaps `complete_layer_bins` (layer, range_line), `mask`; what
    grey levels mean, zone and notes are attributes.
    """
    folder = Path(folder)
    names = []
    for scene in scenes:
        _check_name(scene, names, folder)
        write_dataset(folder / f"scene_{scene.name}.nc", scene_dataset(scene))
        names.append(scene.name)
    _write_list(folder, list_name, [f"scene_{name}.nc" for name in names])
    return {"n_scenes": len(names)}


def scene_dataset(scene):
    """A scene as a dataset; see `export_netcdf`."""
    rows = ("range_bin", "range_line")
    variables = {"layer_bins": (("layer", "range_line"), np.asarray(scene.layer_bins, dtype=float), {"units": "bin"})}
    if scene.complete_layer_bins is not None:
        complete = np.asarray(scene.complete_layer_bins, dtype=float)
        variables["complete_layer_bins"] = (("complete_layer", "range_line"), complete, {"units": "bin"})
    if scene.image is not None:
        variables["image"] = (rows, scene.image, {"long_name": "0 is noise_floor_db - 10, 255 is maximum_db"})
    variables["mask"] = (rows, scene.mask().astype(np.uint8), {"long_name": "1 on a layer"})
    attributes = {
        "format": FORMAT,
        "name": scene.name,
        "n_range_bins": scene.n_range_bins,
        "noise_floor_db": float(scene.noise_floor_db),
        "maximum_db": float(scene.maximum_db),
        "zone": int(scene.zone),
        "notes": json.dumps(scene.notes, sort_keys=True),
    }
    return xr.Dataset(variables, attrs=attributes)


class ExportedScenes(Sequence):
    """Scenes of a directory `export_netcdf` wrote, or of one of its lists; a scene is read when it is asked for.

    Parameters
    ----------
    path : path_like
        The directory (every `scene_*.nc`, by name) or a list file in it.

    Raises
    ------
    ValueError
        If there is no scene, or a file of the list is missing.
    """

    def __init__(self, path):
        path = existing(path, directory=True)
        if path.is_dir():
            self._paths = sorted(path.glob("scene_*.nc"))
        else:
            with library_errors(path, "list", "text with one file name a line"):
                self._paths = [path.parent / name for name in path.read_text(encoding="utf-8").split()]
        if not self._paths:
            raise refusal(path, "scenes", "files scene_*.nc", "none")

    def __len__(self):
        return len(self._paths)

    def __getitem__(self, item):
        return read_scene(self._paths[item])


def read_scene(path):
    """Scene of one file of `export_netcdf`; ValueError, one line, if it is none."""
    path = existing(path)
    dataset = read_netcdf(path)
    if dataset.attrs.get("format") != FORMAT:
        raise refusal(path, "format", repr(FORMAT), repr(dataset.attrs.get("format")))
    arrays = {name: dataset[name].values for name in ARRAYS if name in dataset}
    with library_errors(path, "attributes", "those of a scene"):
        scene = Scene(
            name=str(dataset.attrs["name"]),
            n_range_bins=int(dataset.attrs["n_range_bins"]),
            noise_floor_db=float(dataset.attrs["noise_floor_db"]),
            maximum_db=float(dataset.attrs["maximum_db"]),
            zone=int(dataset.attrs["zone"]),
            notes=json.loads(dataset.attrs["notes"]),
            **arrays,
        )
    for name in ("layer_bins", "complete_layer_bins"):
        if name in arrays:
            check_layer_bins(numeric(path, name, arrays[name]), f"{path}: {name}")
    if "layer_bins" not in arrays:
        raise refusal(path, "layer_bins", "a variable layer_bins", "none")
    expected = (scene.n_range_bins, scene.n_range_lines)
    if scene.image is not None and (scene.image.shape != expected or scene.image.dtype != np.uint8):
        raise refusal(path, "image", f"uint8 of shape {expected}", f"{scene.image.dtype} of shape {scene.image.shape}")
    return scene


def _check_name(scene, names, folder):
    if not NAME.fullmatch(scene.name):
        msg = f"{folder}: scene {scene.name!r}: expected a plain file name without data_ and binary_"
        raise ValueError(msg)
    if scene.name in names:
        msg = f"{folder}: scene {scene.name}: expected names that differ, got it twice"
        raise ValueError(msg)


def _labels(scene, layers):
    if layers == "complete" and scene.complete_layer_bins is not None:
        return scene.complete_layer_bins
    return scene.layer_bins


def _write_png(path, image, texts=None):
    """PNG with fixed settings, so that the same pixels give the same bytes."""
    info = PngInfo()
    for name, text in (texts or {}).items():
        info.add_text(name, text)
    buffer = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(image)).save(buffer, format="PNG", compress_level=6, pnginfo=info)
    with written_whole(path) as aside:
        aside.write_bytes(buffer.getvalue())


def _write_list(folder, list_name, lines):
    with written_whole(folder / list_name) as aside:
        aside.write_text("".join(f"{line}\n" for line in lines), encoding="utf-8")
