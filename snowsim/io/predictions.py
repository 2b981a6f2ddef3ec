"""Files that are scored: edge maps and picks of trackers, masks and layers of the truth.

The type of an array says what it holds. A map is an 8-bit grey PNG image, or floats in [0, 1] as
.npy. Labels are whole numbers, as PNG or .npy: a mask, or layer numbers. Layers in range bins are
floats, as .npy; layer files are those of `snowsim.io.read_layers`.
"""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from snowsim.echogram import check_layer_bins, layer_mask
from snowsim.io import read_layers
from snowsim.io.containers import open_container
from snowsim.io.files import content_of, library_errors, listed, picture_format, refusal
from snowsim.io.pairs import ANY_GREY, GREY_LABELS, layers_of_labels, pair_labels, read_image

IMAGES = (".png", ".npy")
LAYER_FILES = (".mat", ".nc")
# Prefixes of file names, those of truth and picks first, or those of edge maps first.
PREFIXES_OF_LABELS = ("layer_binary_", "layer_", "", "data_")
PREFIXES_OF_MAPS = ("", "data_", "layer_", "layer_binary_")
LABEL_FILE = re.compile("(layer_binary_|layer_|data_|)(.*?)(?:_layers)?")
# Correlation above which a map is an image itself, scaled or rounded.
SAME_IMAGE = 0.999
# `snowsim track` writes these beside its layers: pictures, and the names of a segment's layers.
NO_LAYERS = re.compile(r".*_picks(_\d\d)?\.png|layer_\d{8}_\d{2}\.mat")


def pair_files(predictions, truth, *, picks=False):
    """Each truth with its prediction, and the names of predictions without a truth.

    Both are folders, or one file each. The first result is a list of (name, path of the prediction
    or None, path of the truth), by name. Files belong together if their names agree after `data_`,
    `layer_binary_` or `layer_`. Of several files of one name, truth (and picks) is the first of
    `PREFIXES_OF_LABELS`, a map the first of `PREFIXES_OF_MAPS`. An image `data_*` is no truth where
    it has no prediction. Refused: no prediction has a truth, or a file has the name of a pair in
    another format.
    """
    predictions = Path(predictions)
    truth = Path(truth)
    if predictions.is_file() and truth.is_file():
        return [(_name(predictions), predictions, truth)], []
    endings = (*IMAGES, *LAYER_FILES) if picks else IMAGES
    prefixes = PREFIXES_OF_LABELS if picks else PREFIXES_OF_MAPS
    predicted, other_predictions = _files_by_name(predictions, prefixes, endings)
    truths, other_truths = _files_by_name(truth, PREFIXES_OF_LABELS, endings)
    without_truth = sorted(predicted.keys() - truths.keys())
    others = [path for name, path in other_predictions.items() if name in truths]
    others += [other_truths[name] for name in without_truth if name in other_truths]
    if others:
        raise refusal(others[0], "format", " or ".join(endings), others[0].suffix or "no ending")
    if len(without_truth) == len(predicted):
        expected = f"files {', '.join(endings)}, each with a truth of its name in {truth}"
        held = without_truth or [path.name for path in predictions.glob("*")]
        raise refusal(predictions, "pairs", expected, f"{len(predicted)}: {listed(held)}")
    pairs = [(name, predicted.get(name), truths[name]) for name in sorted(truths)]
    pairs = [pair for pair in pairs if pair[1] or not pair[2].stem.startswith("data_")]
    return pairs, without_truth


def _files_by_name(folder, prefixes, endings):
    """Two dicts of the files in a folder by name: those with one of `endings`, and others.

    Of several files of one name the one whose prefix comes first is taken; two of the same stem are
    refused. A file with another ending is left out where one of its name has the right ending.
    """
    if not folder.is_dir():
        raise refusal(folder, "path", "a folder of files whose names differ", "no folder")
    paths = sorted(path for path in folder.glob("[!.]*") if path.is_file())
    paths = [path for path in paths if not NO_LAYERS.fullmatch(path.name)]
    accepted = [path for path in paths if path.suffix in endings]
    stems = [path.stem for path in accepted]
    twice = [path.name for path in accepted if stems.count(path.stem) > 1]
    if twice:
        raise refusal(folder, "path", "a folder of files whose names differ", listed(twice))
    files = {}
    for path in sorted(
        accepted, key=lambda path: prefixes.index(LABEL_FILE.fullmatch(path.stem)[1])
    ):
        files.setdefault(_name(path), path)
    others = {_name(path): path for path in paths if path.suffix not in endings}
    return files, {name: path for name, path in others.items() if name not in files}


def _name(path):
    """Name by which files belong together: without prefix, and without `_layers` at its end."""
    return LABEL_FILE.fullmatch(path.stem)[2]


def read_map(path):
    """Edge map of an 8-bit grey PNG image or of floats in a .npy file.

    Returns floats in [0, 1], (range_bin, range_line). 8-bit numbers are divided by 255; a map that
    only has 0 and 1 of them is refused, and so are values outside [0, 1].
    """
    if path.suffix == ".png":
        values = _read_png(path, "8-bit grey")
        if values.max() == 1:
            raise refusal(path, "map", "8-bit numbers up to 255", "whole numbers up to 1")
        return values / 255
    values = read_array(path)
    if values.dtype.kind != "f":
        raise refusal(path, "map", "floats in [0, 1], or an 8-bit PNG image", values.dtype)
    outside = ~((values >= 0) & (values <= 1))  # NaN, too
    if outside.any():
        row, line = np.argwhere(outside)[0]
        found = f"{values[row, line]:g} at range_bin {row}, range_line {line}"
        raise refusal(path, "map", "numbers in [0, 1]", found)
    return values.astype(float)


def refuse_image(probability, path, truth):
    """Refuse an edge map that is the echogram image beside its truth, whatever its scale.

    Images are `data_NAME.png` or `LABEL_FILE.png` in the folder of the truth.
    """
    for prefix in ("data_", ""):
        beside = truth.with_name(f"{prefix}{_name(truth)}.png")
        if beside == truth or not beside.is_file():
            continue
        with library_errors(beside):
            image = _read_png(beside, ANY_GREY).astype(float)
        if image.shape != probability.shape or np.ptp(image) == 0 or np.ptp(probability) == 0:
            continue
        if np.corrcoef(image.ravel(), probability.ravel())[0, 1] > SAME_IMAGE:
            raise refusal(path, "map", "what a tracker made of an image", f"the image {beside}")


@dataclass(frozen=True)
class Picks:
    """Layers (layer, range_line) in range bins: rows of an image, or, with times, from 0 s on.

    The peak of an echo lies below the interface that it comes from, so a layer has up to two
    places. A layer counts as a peak, which people pick, if its file does not say which it marks.
    """

    peak_bins: np.ndarray | None
    interface_bins: np.ndarray | None = None
    slow_time: np.ndarray | None = None


def read_picks(path, bin_s=None):
    """`Picks` of a file: labels as of `read_labels`, or layers as of `snowsim.io.read_layers`.

    Travel times become range bins of `bin_s` [s]. Layers that were tracked in an image have its
    rows, which need no `bin_s`.
    """
    if path.suffix not in LAYER_FILES:
        return Picks(read_labels(path)[1])
    layers = read_layers(open_container(path))
    if "row" in layers:
        return Picks(layers["row"].values)
    if bin_s is None:
        raise refusal(path, "twtt", "bin_s (--bin-s), the echogram's range bin in seconds", "none")
    bins = layers["twtt"].values / bin_s
    slow_time = layers["slow_time"].values
    if "peak_twtt" in layers:
        return Picks(layers["peak_twtt"].values / bin_s, bins, slow_time)
    place = layers["twtt"].attrs.get("place", "peak")
    if place not in ("peak", "interface"):
        raise refusal(path, "twtt", "attribute place of peak or interface", place)
    if place == "interface":
        return Picks(None, bins, slow_time)
    return Picks(bins, None, slow_time)


def read_labels(path, shape=None, map_path=None):
    """Mask (or None) and layers of a PNG or .npy file.

    The mask is bool, (range_bin, range_line); layers are (layer, range_line) in range bins. Whole
    numbers 0 and 1, or 0 and 255, are a mask, other whole numbers are layer numbers; floats are
    layers in range bins. If both `layer_binary_NAME.png` and `layer_NAME.png` exist, they must
    agree. `shape` is that of the map in `map_path`, which the labels must fit; layers in range bins
    have a mask only if it is given.
    """
    if path.suffix == ".png" and path.stem.startswith("layer_"):
        name = path.stem.removeprefix("layer_").removeprefix("binary_")
        _, drawn = pair_labels(path.with_stem(f"data_{name}"))
    else:
        is_image = path.suffix == ".png"
        values = _read_png(path, GREY_LABELS) if is_image else read_array(path, least_rows=0)
        drawn = None if values.dtype.kind == "f" else _mask_or_numbers(values, path)
    if drawn is None:
        if values.shape == shape:
            expected = "whole numbers (a mask, layer numbers), or floats (layer, range_line)"
            raise refusal(path, "labels", expected, f"floats of the map's shape, {shape}")
        check_layer_bins(values, str(path))
        layers = values
        mask = None if shape is None else layer_mask(layers, shape[0])
    else:
        layers = layers_of_labels(drawn, path)
        mask = drawn > 0
    if shape is not None and mask.shape != shape:
        raise refusal(map_path, "size", f"{mask.shape} as {path} has", shape)
    return mask, layers


def _mask_or_numbers(values, path):
    """Mask of bool if whole numbers are 0 and 1, or 0 and 255; else layer numbers, uint8."""
    if any(np.isin(values, (0, on)).all() for on in (1, 255)):
        return values > 0
    if values.min() != 0 or values.max() > 255:
        expected = "0 off the layers and numbers up to 255 on them (layers in range bins: floats)"
        raise refusal(path, "labels", expected, f"{values.min()} to {values.max()}")
    return values.astype(np.uint8)


def _read_png(path, expected):
    """Values of a PNG image of the grey levels `expected`; other pictures are refused by name."""
    content = content_of(path)
    picture = picture_format(content)
    if picture not in (None, "PNG"):
        raise refusal(path, "format", "PNG", picture)
    values, _ = read_image(path, expected, content)
    return values


def read_array(path, least_rows=1):
    """Numbers of a .npy file, down range and along track; other formats are refused by name.

    Axes of length 1 beyond two, such as those of a batch, are left out.
    """
    if path.suffix != ".npy":
        raise refusal(path, "format", " or ".join(IMAGES), path.suffix or "no ending")
    with library_errors(path, "NPY: expected a whole array of numbers"):
        content_of(path, 100)
        # Mapped: a header that declares more than the file has is refused before room is made.
        values = np.array(np.load(path, mmap_mode="r", allow_pickle=False))
    while values.ndim > 2 and 1 in values.shape:
        values = values.squeeze(values.shape.index(1))
    is_array = values.ndim == 2 and len(values) >= least_rows and values.shape[1] > 0
    if not is_array or values.dtype.kind not in "fiub":
        found = f"shape {values.shape} of {values.dtype}"
        raise refusal(path, "array", "numbers, down range and along track", found)
    return values
