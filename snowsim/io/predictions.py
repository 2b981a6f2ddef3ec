"""What a tracker made and what is true, in other people's files: edge maps, picks, masks."""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from snowsim.constants import OUTPUTS
from snowsim.echogram import check_layer_bins, layer_mask
from snowsim.io import read_layers
from snowsim.io.containers import opened
from snowsim.io.files import content_of, library_errors, listed, picture_format, refusal
from snowsim.io.pairs import ANY_GREY, layers_of_labels, pair_labels, read_image

ENDINGS = (".png", ".npy", ".nc")
# Folders of the published predictor beside its outputs: sums and strips of them.
PICTURES = ("merge", "jpg_out")
# How names of files begin, those of labels first.
LABELLED = ("layer_binary_", "layer_", "scene_", "", "data_")
MAPPED = ("", "scene_", "data_", "layer_", "layer_binary_")  # the same of edge maps
NAME = re.compile("(layer_binary_|layer_|data_|scene_|)(?:scene_)?(.*?)(?:_layers)?")
# Beside the layers that `snowsim track` writes: its pictures, and what names a segment's layers.
NO_LAYERS = re.compile(r".*_picks\.png|layer_\d{8}_\d{2}\.mat")
# Variables of NetCDF files.
MAPS = ("probability", "prediction", "edges")
LABELS = ("layer_bins", "mask")
DOWN_FIRST = ("layer", "range_bin", "twtt")  # axes of arrays


def pair_files(predictions, truth, *, output=None, picks=False):
    """Every truth with its prediction, and names of predictions without a truth.

    A list of (name, path or None, path of the truth) by name: a truth without a prediction, unless
    it is an image `data_*`, comes with None. Both are folders of .png, .npy or .nc files, of picks
    also .mat, or a file each. In a folder that holds the published predictor's, the one of `output`
    is taken, by default `fuse`; never `merge` or `jpg_out`. Files are paired by what follows
    `data_`, `layer_binary_`, `layer_` or `scene_`; of several, truth (and `picks`) is the first of
    `LABELLED`, a map that of `MAPPED`. Refused where no prediction has a truth.
    """
    predictions = Path(predictions)
    truth = Path(truth)
    if predictions.is_file() and truth.is_file():
        return [(_name(predictions), predictions, truth)], []
    inside = predictions / (output or "fuse")
    is_pictures = predictions.name in PICTURES
    if is_pictures or (output is not None and not inside.is_dir()):
        expected = f"a folder of one output ({output or ', '.join(OUTPUTS)})"
        found = "pictures of several" if is_pictures else "none"
        raise refusal(predictions, "predictions", expected, found)
    predictions = inside if inside.is_dir() else predictions
    endings = (*ENDINGS, ".mat") if picks else ENDINGS
    made = _by_name(predictions, LABELLED if picks else MAPPED, endings)
    truths = _by_name(truth, LABELLED, endings)
    alone = sorted(made.keys() - truths.keys())
    if len(alone) == len(made):
        expected = f"files {', '.join(endings)}, each with a truth of its name in {truth}"
        raise refusal(predictions, "pairs", expected, f"{len(made)}: {listed(alone)}")
    pairs = [(name, made.get(name), truths[name]) for name in sorted(truths)]
    return [pair for pair in pairs if pair[1] or not pair[2].stem.startswith("data_")], alone


def _by_name(folder, order, endings):
    """Files of a folder by name, of each the one whose prefix comes first in `order`.

    Two of the same stem are refused.
    """
    held = sorted(path for path in folder.glob("[!.]*") if path.suffix in endings)
    held = [path for path in held if not NO_LAYERS.fullmatch(path.name)]
    paths = {path.stem: path for path in held}
    twice = [path.name for path in held if paths[path.stem] != path]
    if twice or not folder.is_dir():
        found = listed(twice) if twice else "no folder"
        raise refusal(folder, "path", "a folder of files whose names differ", found)
    files = {}
    for stem in sorted(paths, key=lambda stem: order.index(NAME.fullmatch(stem)[1])):
        files.setdefault(_name(paths[stem]), paths[stem])
    return files


def _name(path):
    """What follows the prefix; a scene may be called scene_NAME, layers NAME_layers, too."""
    return NAME.fullmatch(path.stem)[2]


def read_map(path):
    """Edge map of a file, (range_bin, range_line), in [0, 1] or refused.

    Whole numbers of 8 or 16 bits are divided by their largest. A NetCDF file has it as
    `probability`, `prediction` or `edges`, or as its only image.
    """
    _, values = read_array(path, MAPS)
    if values.dtype in (np.uint8, np.uint16):
        largest = np.iinfo(values.dtype).max
        if values.max() == 1:
            expected = f"8-bit or 16-bit numbers up to {largest}, or floats up to 1"
            raise refusal(path, "map", expected, "whole numbers up to 1")
        values = values / largest
    outside = ~((values >= 0) & (values <= 1))  # NaN, too
    if outside.any():
        row, line = np.argwhere(outside)[0]
        found = f"{values[row, line]:g} at range_bin {row}, range_line {line}"
        raise refusal(path, "map", "8-bit numbers, or numbers in [0, 1]", found)
    return values.astype(float)


@dataclass(frozen=True)
class Picks:
    """Layers (layer, range_line) in range bins: rows of an image, or, with times, from 0 s on."""

    layer_bins: np.ndarray
    slow_time: np.ndarray | None = None


def read_picks(path, bin_s=None):
    """`Picks` of a file: labels as of `read_labels`, or layers as of `snowsim.io.read_layers`.

    Travel times become range bins of `bin_s` [s]; rows are taken where a tracked image has them.
    """
    stored = opened(path) if path.suffix in (".mat", ".nc") else None
    if stored is None or (path.suffix == ".nc" and "twtt" not in stored.names):
        return Picks(read_labels(path, stored=stored)[1])
    layers = read_layers(stored)
    if "row" in layers:
        return Picks(layers["row"].values)
    if bin_s is None:
        raise refusal(path, "twtt", "bin_s (--bin-s), the echogram's range bin in seconds", "none")
    twtt = layers.get("peak_twtt", layers["twtt"])  # a simulated layer's echo peaks below it
    return Picks(twtt.values / bin_s, layers["slow_time"].values)


def read_labels(path, shape=None, image=None, stored=None):
    """Mask (or None) and layers of a file.

    The mask is bool (range_bin, range_line), layers are (layer, range_line) in range bins. An image
    is a mask (two levels) or holds layer numbers; for those of the published benchmark both are
    read where both are there. An array that has 0 and 1 (or 255) alone is a mask, one of whole
    numbers with 0 twice in a range line holds layer numbers, any other holds range bins, as
    `layer_bins` of a NetCDF file does; it has a mask where `shape` is given, which is that of the
    `image` that must fit the labels. `stored` is the file, if it is open.
    """
    if path.suffix == ".png" and path.stem.startswith("layer_"):
        name = path.stem.removeprefix("layer_").removeprefix("binary_")
        _, drawn = pair_labels(path.with_stem(f"data_{name}"))
    else:
        name, values = read_array(path, LABELS, least_rows=0, stored=stored)
        drawn = None if name == "layer_bins" else _drawn(values, path.suffix == ".png")
        if drawn is None and (name == "mask" or values.shape == shape):
            expected = "0 and 1, or layers (layer, range_line) in range bins"
            raise refusal(path, "mask", expected, f"{values.min():g} to {values.max():g}")
    if drawn is None:
        check_layer_bins(values, str(path))
        layers = values
        mask = None if shape is None else layer_mask(layers, shape[0])
    else:
        layers = layers_of_labels(drawn, path)
        mask = drawn > 0
    if shape is not None and mask.shape != shape:
        raise refusal(image, "size", f"{mask.shape} as {path} has", shape)
    return mask, layers


def _drawn(values, is_image):
    """Labels as `layers_of_labels` takes them of an array, None where it has layers in range bins.

    Layers without a row are no mask; layers in range bins are never at 0 twice.
    """
    if len(values) and any(np.isin(values, (0, on)).all() for on in (1, 255, 65535)):
        return values > 0
    twice = ((values == 0).sum(axis=0) > 1).any()
    is_numbers = twice and np.isin(values, np.arange(256)).all()
    return values.astype(int) if is_image or is_numbers else None


def read_array(path, names=(), least_rows=1, stored=None):
    """Name (of a variable) and values of the array in a .png, .npy or NetCDF file.

    A NetCDF file has the first of the variables `names`, or one image alone; axes that have names
    come with the range, or the layers, first. Axes of length 1 beyond two, as those of a batch, are
    left out.
    """
    name = ""
    content = b"" if stored or path.suffix == ".npy" else content_of(path)
    if path.suffix == ".png" or picture_format(content):
        values, _ = read_image(path, ANY_GREY, content)
    elif path.suffix == ".npy":
        with library_errors(path, "NPY: expected a whole array of numbers"):
            content_of(path, 100)
            # Mapped: a header that declares more than the file has is refused before room is made.
            values = np.array(np.load(path, mmap_mode="r", allow_pickle=False))
    else:
        with library_errors(path):
            stored = opened(stored or path, content).read()
        images = [name for name, variable in stored.variables.items() if variable.ndim == 2]
        found = [name for name in names if name in stored][:1] or images
        if len(found) != 1:
            expected = f"one of {', '.join(names)}, or one image alone"
            raise refusal(path, "variables", expected, listed(stored.variables))
        name = found[0]
        down = [axis for axis in stored[name].dims if axis in DOWN_FIRST]
        values = stored[name].transpose(*down, ...).values
    while values.ndim > 2 and 1 in values.shape:
        values = values.squeeze(values.shape.index(1))
    is_array = values.ndim == 2 and len(values) >= least_rows and values.shape[1] > 0
    if not is_array or values.dtype.kind not in "fiub":
        found = f"shape {values.shape} of {values.dtype}"
        raise refusal(path, name or "array", "numbers, down range and along track", found)
    return name, values
