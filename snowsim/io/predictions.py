"""What a tracker made and what is true, in other people's files: edge maps, picks, masks."""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from snowsim.constants import OUTPUTS
from snowsim.echogram import check_layer_bins, layer_mask
from snowsim.io import read_layers
from snowsim.io.containers import read_netcdf
from snowsim.io.guard import existing, library_errors, listed, numeric, refusal
from snowsim.io.images import ANY_GREY, read_image
from snowsim.io.png_pairs import Labels, png_labels
from snowsim.io.sniff import names_in

ENDINGS = (".png", ".npy", ".nc")
# Of the published predictor, beside its outputs: sums and strips of them.
PICTURES = ("merge", "jpg_out")
# How names of files begin, those of labels first.
LABELLED = ("layer_binary_", "layer_", "scene_", "", "data_")
MAPPED = ("", "scene_", "data_", "layer_", "layer_binary_")  # the same of edge maps
NAME = re.compile(f"({'|'.join(sorted(LABELLED, reverse=True))})(.*)")
# Beside the layers that `snowsim track` writes: its pictures, and what names a segment's layers.
NO_LAYERS = re.compile(r".*_picks\.png|layer_\d{8}_\d{2}\.mat")
# Variables of NetCDF files.
MAPS = ("probability", "prediction", "edges")
LABELS = ("layer_bins", "mask")
AXES = (
    ("range_bin", "range_line"),
    ("twtt", "slow_time"),
    ("layer", "range_line"),
    ("layer", "slow_time"),
)


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
    if predictions.name in PICTURES:
        expected = f"maps of one output ({', '.join(OUTPUTS)})"
        raise refusal(predictions, "predictions", expected, "pictures of several")
    inside = predictions / (output or "fuse")
    if inside.is_dir():
        predictions = inside
    elif output is not None:
        raise refusal(predictions, "predictions", f"a folder {output}", "none")
    endings = (*ENDINGS, ".mat") if picks else ENDINGS
    made = _by_name(predictions, LABELLED if picks else MAPPED, endings)
    truths = _by_name(truth, LABELLED, endings)
    alone = sorted(made.keys() - truths.keys())
    if len(alone) == len(made):
        expected = f"files {', '.join(endings)}, each with a truth of its name in {truth}"
        found = f"{len(made)}, without truth: {listed(alone)}" if made else "no file"
        raise refusal(predictions, "pairs", expected, found)
    true = [name for name, path in truths.items() if not path.stem.startswith("data_")]
    paired = made.keys() & truths.keys() | set(true)
    return [(name, made.get(name), truths[name]) for name in sorted(paired)], alone


def _by_name(folder, order, endings):
    """Files of a folder by name, of each the one whose prefix comes first in `order`.

    Two of the same stem are refused.
    """
    if not folder.is_dir():
        raise refusal(folder, "path", "a folder", "a file" if folder.exists() else "nothing")
    held = [path for path in sorted(folder.glob("[!.]*")) if path.suffix in endings]
    paths = [path for path in held if not NO_LAYERS.fullmatch(path.name)]
    stems = [path.stem for path in paths]
    twice = [path.name for path in paths if stems.count(path.stem) > 1]
    if twice:
        raise refusal(folder, "files", "names that differ", listed(twice))
    files = {}
    for path in sorted(paths, key=lambda path: order.index(NAME.match(path.stem)[1])):
        files.setdefault(_name(path), path)
    return files


def _name(path):
    """What follows the prefix; a scene may be called scene_NAME, layers NAME_layers, too."""
    return NAME.match(path.stem)[2].removeprefix("scene_").removesuffix("_layers")


def read_map(path):
    """Edge map of a file, (range_bin, range_line), in [0, 1] or refused.

    Whole numbers of 8 or 16 bits are divided by their largest. A NetCDF file has it as
    `probability`, `prediction` or `edges`, or as its only image.
    """
    path = existing(path)
    values = _grey(path) if path.suffix == ".png" else _array(path, MAPS)[1]
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
    path = existing(path)
    is_layers = path.suffix == ".mat" or (path.suffix == ".nc" and "twtt" in names_in(path))
    if not is_layers:
        return Picks(read_labels(path)[1])
    layers = read_layers(path)
    if "row" in layers:
        return Picks(layers["row"].values)
    if bin_s is None:
        raise refusal(path, "twtt", "bin_s (--bin-s), the echogram's range bin in seconds", "none")
    return Picks(layers["twtt"].values / bin_s, layers["slow_time"].values)


def read_labels(path, shape=None, image=None):
    """Mask (or None) and layers of a file.

    The mask is bool (range_bin, range_line), layers are (layer, range_line) in range bins. An image
    is a mask (two levels) or holds layer numbers; for those of the published benchmark both are
    read where both are there. An array that has 0 and 1 (or 255) alone is a mask, one of whole
    numbers with 0 twice in a range line holds layer numbers, any other holds range bins, as
    `layer_bins` of a NetCDF file does; it has a mask where `shape` is given, which is that of the
    `image` that must fit the labels.
    """
    path = existing(path)
    if path.suffix == ".png":
        labels = _image_labels(path)
    else:
        name, values = _array(path, LABELS, smallest=(0, 1))
        if name == "layer_bins" or not (_is_mask(values) or _is_numbers(values)):
            return _layers(path, name, values, shape, image)
        labels = _drawn_labels(path, values)
    mask = labels.mask()
    if shape is not None and mask.shape != tuple(shape):
        raise refusal(image, "size", f"{mask.shape} as {path} has", tuple(shape))
    return mask, labels.layer_bins()


def _image_labels(path):
    if path.stem.startswith("layer_"):
        return png_labels(path.with_name(f"data_{NAME.match(path.name)[2]}"), None)
    return _drawn_labels(path, _grey(path))


def _drawn_labels(path, values):
    """Labels of an image that is a mask or holds layer numbers."""
    return Labels(path, values > 0 if _is_mask(values) else values.astype(int))


def _grey(path):
    values, _ = read_image(path, ANY_GREY)
    return values


def _is_mask(values):
    """Whether an image has two levels; layers without a row are none."""
    return len(values) > 0 and any(np.isin(values, (0, on)).all() for on in (1, 255, 65535))


def _is_numbers(values):
    """Whether an image holds layer numbers: layers in range bins are never at 0 twice."""
    twice = ((values == 0).sum(axis=0) > 1).any()
    return twice and np.isin(values, np.arange(256)).all()


def _layers(path, name, values, shape, image):
    """Layers in range bins, and their mask where they must fit an image of a shape."""
    if name == "mask" or (shape is not None and values.shape == tuple(shape)):
        expected = "0 and 1, or layers (layer, range_line) in range bins"
        found = f"{values.dtype} from {values.min():g} to {values.max():g}"
        raise refusal(path, "mask", expected, found)
    check_layer_bins(values, str(path))
    if shape is None:
        return None, values
    n_range_bins, n_lines = shape
    if values.shape[1] != n_lines:
        raise refusal(image, "size", f"{values.shape[1]} range lines as {path} has", n_lines)
    return layer_mask(values, n_range_bins), values


def _array(path, names, smallest=(1, 1)):
    """Name and values of the array in an .npy file (no name) or a NetCDF file.

    Axes of length 1 beyond two, as those of a batch, are left out.
    """
    name, values = ("", _npy(path)) if path.suffix == ".npy" else _variable(path, names)
    what = name or "array"
    alone = [axis for axis, length in enumerate(values.shape) if length == 1]
    values = np.squeeze(values, tuple(alone[: max(values.ndim - 2, 0)]))
    if values.ndim != 2 or any(np.less(values.shape, smallest)):
        expected = "two axes, down range and along track"
        raise refusal(path, what, expected, f"shape {values.shape}")
    return name, numeric(path, what, values)


def _npy(path):
    with library_errors(path, "NPY", "a whole array of numbers"):
        # Mapped: a header that declares more than the file has is refused before room is made.
        return np.array(np.load(path, mmap_mode="r", allow_pickle=False))


def _variable(path, names):
    """Name and values of the first of the variables a NetCDF file has, or of its only image.

    Axes that have names come with the range, or the layers, first.
    """
    stored = read_netcdf(path)
    known = [name for name in names if name in stored]
    images = [name for name, variable in stored.variables.items() if variable.ndim == 2]
    if not known and len(images) != 1:
        expected = f"one of {', '.join(names)}, or one image alone"
        raise refusal(path, "variables", expected, listed(map(str, stored.variables)))
    name = (known or images)[0]
    variable = stored[name]
    for axes in AXES:
        if set(axes) == set(variable.dims):
            variable = variable.transpose(*axes)
    return name, variable.values
