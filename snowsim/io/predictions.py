"""What a tracker made and what is true, in other people's files: edge maps, picks, masks; which belong together."""

import re
from pathlib import Path

import numpy as np

from snowsim.constants import OUTPUTS
from snowsim.echogram import check_layer_bins, layer_mask
from snowsim.io.containers import read_netcdf
from snowsim.io.guard import check_size, existing, library_errors, numeric, one_line, refusal
from snowsim.io.images import read_image
from snowsim.io.png_pairs import layers_of_mask, layers_of_numbers, png_labels

ENDINGS = (".png", ".npy", ".nc")
PICTURES = (
    "merge",
    "jpg_out",
)  # of the published predictor, beside its outputs: sums and strips of them
LABELLED = (
    "layer_binary_",
    "layer_",
    "scene_",
    "",
    "data_",
)  # how names of files begin, those of labels first
NAME = re.compile(f"({'|'.join(sorted(LABELLED, reverse=True))})(.*)")
MAPS, LABELS = (
    ("probability", "prediction", "edges"),
    ("layer_bins", "mask"),
)  # variables of NetCDF files
AXES = (
    ("range_bin", "range_line"),
    ("twtt", "slow_time"),
    ("layer", "range_line"),
    ("layer", "slow_time"),
)


def pair_files(predictions, truth, *, output=None, picks=False):
    """Every prediction with its truth, a list of (name, path, path of the truth) by name; ValueError if one has none.

    Both are folders of .png, .npy or .nc files, or a file each. In a folder that holds the
    published predictor's, the one of `output` is taken, by default `fuse`; never `merge` or
    `jpg_out`. Files are paired by what follows `data_`, `layer_binary_`, `layer_` or `scene_`; of
    several, truth (and `picks`) is the first of `LABELLED`, a map the last.
    """
    predictions, truth = Path(predictions), Path(truth)
    if predictions.is_file() and truth.is_file():
        return [(_name(predictions), predictions, truth)]
    inside = predictions / (output or "fuse")
    if predictions.name in PICTURES or (output is not None and not inside.is_dir()):
        expected = f"a folder {output}" if output else f"maps of one output ({', '.join(OUTPUTS)})"
        raise refusal(
            predictions, "predictions", expected, "none" if output else "pictures of several"
        )
    made = _by_name(
        inside if inside.is_dir() else predictions, LABELLED if picks else LABELLED[::-1]
    )
    truths = _by_name(truth, LABELLED)
    alone = sorted(set(made) - set(truths))
    if alone or not made:
        expected = f"files {', '.join(ENDINGS)}, each with a truth of its name in {truth}"
        found = f"{len(made)}, without truth: {', '.join(alone)}" if made else "no file"
        raise refusal(predictions, "pairs", expected, one_line(found, 200))
    return [(name, made[name], truths[name]) for name in sorted(made)]


def _by_name(folder, order):
    """Files of a folder by name, of each the one whose prefix comes first in `order`; ValueError if two have it."""
    if not folder.is_dir():
        raise refusal(folder, "path", "a folder", "a file" if folder.exists() else "nothing")
    paths = [
        path
        for path in folder.iterdir()
        if path.suffix in ENDINGS and not path.name.startswith(".")
    ]
    files, stems = {}, {}
    for path in sorted(paths, key=lambda path: (order.index(NAME.match(path.stem)[1]), path)):
        if stems.setdefault(path.stem, path) != path:
            raise refusal(
                folder, "files", "names that differ", f"{stems[path.stem].name} and {path.name}"
            )
        files.setdefault(_name(path), path)
    return files


def _name(path):
    """What follows the prefix; a scene may be called scene_NAME, too."""
    return NAME.match(path.stem)[2].removeprefix("scene_")


def read_map(path):
    """Edge map of a file, (range_bin, range_line), in [0, 1] or refused; whole numbers of 8 bits are divided by 255.

    A NetCDF file has it as `probability`, `prediction` or `edges`, or as its only image.
    """
    path = existing(path)
    values = read_image(path, binary=None)[0] if path.suffix == ".png" else _array(path, MAPS)[1]
    if values.dtype == np.uint8:
        if values.max() == 1:
            raise refusal(
                path, "map", "8-bit numbers up to 255, or floats up to 1", "8-bit numbers up to 1"
            )
        values = values / 255
    outside = ~((values >= 0) & (values <= 1))  # NaN, too
    if outside.any():
        row, line = np.argwhere(outside)[0]
        found = f"{values[row, line]:g} at range_bin {row}, range_line {line}"
        raise refusal(path, "map", "8-bit numbers, or numbers in [0, 1]", found)
    return values.astype(float)


def read_labels(path, shape=None):
    """Mask (or None) and layers of a file: bool (range_bin, range_line), and range bins (layer, range_line).

    An image is a mask (two levels) or holds layer numbers; for those of the published benchmark
    both are read where both are there. An array that has 0 and 1 (or 255) alone is a mask, any
    other holds range bins, as `layer_bins` of a NetCDF file does; it has a mask where `shape` is
    given, which is that of the image the labels must fit.
    """
    path = existing(path)
    where, numbers, is_image = path, None, path.suffix == ".png"
    if is_image and path.stem.startswith("layer_"):
        where, numbers, mask = png_labels(path.with_name(f"data_{NAME.match(path.name)[2]}"), shape)
        mask = numbers > 0 if mask is None else mask
    else:
        name, values = (
            ("mask", read_image(path, binary=None)[0]) if is_image else _array(path, LABELS)
        )
        is_mask = name != "layer_bins" and any(
            np.isin(values, levels).all() for levels in ((0, 1), (0, 255))
        )
        if not (is_mask or is_image):
            return _layers(path, name, values, shape)
        numbers, mask = None if is_mask else values, values > 0
    if shape is not None and mask.shape != tuple(shape):
        raise refusal(path, "size", f"that of the prediction, {tuple(shape)}", mask.shape)
    return mask, layers_of_mask(mask, where) if numbers is None else layers_of_numbers(
        numbers, where
    )


def _layers(path, name, values, shape):
    if name == "mask" or (shape is not None and values.shape == tuple(shape)):
        expected = "0 and 1, or layers (layer, range_line) in range bins"
        raise refusal(
            path, "mask", expected, f"{values.dtype} from {values.min():g} to {values.max():g}"
        )
    check_layer_bins(values, str(path))
    if shape is not None and values.shape[1] != shape[1]:
        raise refusal(
            path, "size", f"{shape[1]} range lines as the prediction has", values.shape[1]
        )
    return (None if shape is None else layer_mask(values, shape[0])), values


def _array(path, names):
    """Name and values of the array in an .npy file (no name), or of the first of the variables that a file has.

    Of a NetCDF file with none of them, its only image. Axes that have names come with the range, or
    the layers, first.
    """
    if path.suffix == ".npy":
        with library_errors(path, "NPY", "a whole array of numbers"):
            # Mapped: a header that declares more than the file has is refused before room is made.
            stored = np.load(path, mmap_mode="r", allow_pickle=False)
        check_size(path, "NPY", stored.shape, stored.dtype.itemsize)
        name, values = "", np.array(stored)
    else:
        stored = read_netcdf(path)
        images = [name for name in names if name in stored] or [
            n for n in stored.variables if stored[n].ndim == 2
        ]
        if not images or (images[0] not in names and len(images) > 1):
            found = one_line(", ".join(map(str, stored.variables)) or "none", 200)
            raise refusal(
                path, "variables", f"one of {', '.join(names)}, or one image alone", found
            )
        name, variable = images[0], stored[images[0]]
        axes = next((axes for axes in AXES if set(axes) == set(variable.dims)), variable.dims)
        values = variable.transpose(*axes).values
    if values.ndim != 2 or values.size == 0:
        raise refusal(
            path, name or "array", "two axes, down range and along track", f"shape {values.shape}"
        )
    return name, numeric(path, name or "array", values)
