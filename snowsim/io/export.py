"""Scenes for other people's code: the published benchmark's layout, NetCDF or Zarr for xarray."""

import importlib.util
import json
import re
from pathlib import Path

import numpy as np
import xarray as xr

from snowsim.echogram import check_choice, layer_mask
from snowsim.io.files import write_bytes, write_dataset, written_whole
from snowsim.io.guard import refusal
from snowsim.io.images import NUMBERS_IN_TEXT, write_image

FORMAT = "snowsim scene 1"
LAYERS = ("annotated", "complete")
MAXIMUM_NUMBER = 255  # layer numbers are 8-bit
# Plain names of files. Loaders replace "data_" wherever it stands, and "binary_" in front makes a
# number image a mask.
NAME = re.compile(r"(?!.*data_)(?!binary_)[A-Za-z0-9][A-Za-z0-9_.-]*")


def check_empty(folder):
    """Raise ValueError if a folder to write scenes to holds something already."""
    held = sorted(path.name for path in Path(folder).glob("*"))
    if held:
        raise refusal(
            folder, "folder", "an empty or a new one", f"{len(held)} files: {held[0]} ..."
        )


def export_pairs(folder, scenes, *, list_name="all.lst", layers="annotated"):
    """Write scenes in the layout of the published benchmark.

    For each scene `data_<name>.png` (8-bit), `layer_binary_<name>.png` (1-bit) and
    `layer_<name>.png` (layer numbers, the surface being 1), then a list file with one `data_*.png`
    a line: what the loader of the published tracker code reads. Decibels of the grey levels go into
    text chunks of the image. The same scenes give the same bytes. Read back, images are exact and
    layers are rounded to whole bins; what leaves the window is not drawn.

    Scenes are held one at a time; `folder` may hold other sets, each with its list. Labels are the
    "annotated" or, for scenes that know both, the "complete" layers. Returned are `n_scenes` and
    `n_merged_pixels`, lost to a layer below. Names that the loader would trip over, scenes without
    an image and more than 255 layers are refused.
    """
    folder = Path(folder)
    check_choice("layers", layers, LAYERS)
    n_scenes = 0
    n_merged = 0
    for scene in _listed(folder, scenes, list_name, "data_{}.png"):
        if scene.image is None or "data_" in folder.name:
            expected = "an image; the folder's name must not contain data_, which loaders replace"
            raise refusal(folder, scene.name, expected, "none, or such a name")
        layer_bins = scene.layer_bins
        if layers == "complete" and scene.complete_layer_bins is not None:
            layer_bins = scene.complete_layer_bins
        numbers, merged = layer_numbers(layer_bins, scene.n_range_bins)
        contrast = {name: getattr(scene, name) for name in NUMBERS_IN_TEXT}
        write_image(folder / f"data_{scene.name}.png", scene.image, contrast)
        write_image(folder / f"layer_binary_{scene.name}.png", numbers > 0)
        write_image(folder / f"layer_{scene.name}.png", numbers)
        n_scenes += 1
        n_merged += merged
    return {"n_scenes": n_scenes, "n_merged_pixels": n_merged}


def layer_numbers(layer_bins, n_range_bins):
    """Image of layer numbers, uint8 (range_bin, range_line), and how many pixels merged.

    The surface is 1, no layer 0. One pixel per layer (layer, range_line) and line, at the rounded
    bin; of two layers at one pixel, the lower. Layers outside the window leave no pixel.
    """
    if len(layer_bins) > MAXIMUM_NUMBER:
        msg = f"layer numbers hold at most {MAXIMUM_NUMBER} layers, got {len(layer_bins)}"
        raise ValueError(msg)
    numbers = np.zeros((n_range_bins, np.shape(layer_bins)[1]), dtype=np.uint8)
    n_merged = 0
    for number, bins in enumerate(layer_bins, start=1):
        drawn = layer_mask([bins], n_range_bins)
        n_merged += int(np.count_nonzero(numbers[drawn]))
        numbers[drawn] = number
    return numbers, n_merged


def export_netcdf(folder, scenes, *, list_name="all.lst"):
    """Write scenes as one NetCDF file each, `scene_<name>.nc`, for xarray; and a list file.

    Nothing is rounded. `image` (range_bin, range_line), `layer_bins` and perhaps
    `complete_layer_bins` (layer, range_line), `mask`; what grey levels mean, zone and notes are
    attributes. Scenes, with or without images, are held one at a time.
    """
    return _export_datasets(folder, scenes, list_name, "nc", write_dataset)


def export_zarr(folder, scenes, *, list_name="all.lst"):
    """The same as one Zarr store each, `scene_<name>.zarr`; ValueError without the package zarr."""
    if importlib.util.find_spec("zarr") is None:
        raise refusal(folder, "Zarr", "package zarr (pip install 'zarr>=3')", "none")
    return _export_datasets(folder, scenes, list_name, "zarr", _write_store)


def _write_store(path, dataset):
    with written_whole(path) as aside:
        dataset.to_zarr(aside, mode="w", consolidated=False)


def _export_datasets(folder, scenes, list_name, ending, write):
    folder = Path(folder)
    n_scenes = 0
    for scene in _listed(folder, scenes, list_name, f"scene_{{}}.{ending}"):
        write(folder / f"scene_{scene.name}.{ending}", _dataset(scene))
        n_scenes += 1
    return {"n_scenes": n_scenes}


def _dataset(scene):
    attributes = {"format": FORMAT, "name": scene.name, "n_range_bins": scene.n_range_bins}
    for name, kind in NUMBERS_IN_TEXT.items():
        attributes[name] = kind(getattr(scene, name))
    attributes["notes"] = json.dumps(scene.notes, sort_keys=True)
    dataset = xr.Dataset(attrs=attributes)
    for name, rows in {"layer_bins": "layer", "complete_layer_bins": "complete_layer"}.items():
        layer_bins = getattr(scene, name)
        if layer_bins is not None:
            layer_bins = np.asarray(layer_bins, dtype=float)
            dataset[name] = ((rows, "range_line"), layer_bins, {"units": "bin"})
    pixels = ("range_bin", "range_line")
    if scene.image is not None:
        meaning = {"long_name": "0 is noise_floor_db - 10, 255 is maximum_db"}
        dataset["image"] = (pixels, scene.image, meaning)
    mask = scene.mask().astype(np.uint8)
    dataset["mask"] = (pixels, mask, {"long_name": "1 on a layer"})
    return dataset


def _listed(folder, scenes, list_name, file_name):
    """Scenes whose names a loader will not trip over, one by one; then their files are listed."""
    names = []
    for scene in scenes:
        if not NAME.fullmatch(scene.name) or scene.name in names:
            expected = "a plain file name, unlike all others, without data_ and binary_"
            raise refusal(folder, "scene", expected, repr(scene.name))
        yield scene
        names.append(scene.name)
    lines = [f"{file_name.format(name)}\n" for name in names]
    write_bytes(folder / list_name, "".join(lines).encode())
