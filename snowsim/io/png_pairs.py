"""The published benchmark's pairs of image and labels, as PNG or MAT v7.3, read scene by scene."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from snowsim.echogram import Scene, check_choice, check_layer_bins, to_uint8
from snowsim.io.guard import (
    check_present,
    container_of,
    existing,
    library_errors,
    numeric,
    one_line,
    refusal,
)
from snowsim.io.images import read_image, read_mask
from snowsim.io.matlab import read_matlab

# A mask of one pixel per layer and column has a few per cent on; an inverted one nearly all.
MAXIMUM_SHARE_ON = 0.5
THICKEST_PIXELS = 15  # of a layer in a column, in the median
DATA_SCALES = ("power", "db")
LABEL_PREFIXES = ("layer_", "layer_binary_")


class PairSet(Sequence):
    """Scenes in the layout of the published benchmark; a scene is read when it is asked for.

    `path` is a directory, of which every `data_*.png` (if there is none, every `data_*.mat`) is a
    scene, by name; or a list file with one such name a line, relative to the list (a second name,
    the label, is not needed). `data_scale`, "power" or "db", says what floating-point `data` of
    .mat pairs are, which non-negative numbers do not tell. No scene, a missing file or a name that
    comes twice is refused.

    A label is found by putting `layer_` (layer numbers) or `layer_binary_` (mask) in place of
    `data_`. Layer number k is row k - 1 of `layer_bins`; numbers that occur nowhere between others
    leave a row of NaN. A mask alone tells no numbers: the k-th run of pixels from the top of a
    column is then layer k - 1 there, so below a gap in a layer the deeper ones count up by one;
    positions, and the mask itself, stay exact. A run of several pixels counts at its middle. Where
    both labels are there, they must agree.
    """

    def __init__(self, path, *, data_scale=None):
        path = existing(path, directory=True)
        if data_scale is not None:
            check_choice("data_scale", data_scale, DATA_SCALES)
        self._data_scale = data_scale
        if path.is_dir():
            self._paths = sorted(path.glob("data_*.png")) or sorted(path.glob("data_*.mat"))
        else:
            self._paths = _listed(path)
        if not self._paths:
            raise refusal(path, "scenes", "files data_*.png or data_*.mat", "none")
        self.names = [scene_name(file) for file in self._paths]
        twice = [name for name, count in Counter(self.names).items() if count > 1]
        if twice:
            raise refusal(path, "scenes", "names that differ", one_line(", ".join(twice), 200))

    def __len__(self):
        return len(self._paths)

    def __getitem__(self, item):
        return read_pair(self._paths[item], data_scale=self._data_scale)

    def files(self, item):
        """Files a scene, or a slice of scenes, is read from: images and labels."""
        paths = self._paths[item] if isinstance(item, slice) else [self._paths[item]]
        beside = [_beside(path, prefix) for path in paths for prefix in LABEL_PREFIXES]
        return paths + [path for path in beside if path is not None]

    def check(self):
        """Read every scene once; one ValueError names all that fail.

        Those not as wide as most fail, too. Returned is a list of a dict for each scene: `name`,
        `n_range_bins`, `n_range_lines`, `n_layers`, and whether it `tells_db`.
        """
        rows = []
        failed = []
        for path in self._paths:
            try:
                scene = read_pair(path, data_scale=self._data_scale)
            except ValueError as error:
                failed.append(str(error))
                continue
            row = {
                "name": scene.name,
                "n_range_bins": scene.n_range_bins,
                "n_range_lines": scene.n_range_lines,
                "n_layers": len(scene.layer_bins),
                "tells_db": tells_db(scene),
            }
            rows.append(row)
        widths = [row["n_range_lines"] for row in rows]
        usual = max(widths, key=widths.count, default=None)
        for row in rows:
            width = row["n_range_lines"]
            if width != usual:
                expected = f"{usual} range lines as in most"
                failed.append(str(refusal(row["name"], "width", expected, width)))
        if failed:
            msg = "\n".join([f"{len(failed)} of {len(self)} scenes fail:", *failed])
            raise ValueError(msg)
        return rows


def tells_db(scene):
    """Whether it is known what the grey levels of a scene stand for."""
    return bool(np.isfinite([scene.noise_floor_db, scene.maximum_db]).all())


def scene_name(path):
    """Name of the scene an image `data_<name>.png` shows."""
    return path.stem.removeprefix("data_")


def read_pair(path, *, data_scale=None):
    """Scene of one `data_*` file and the labels beside it; see `PairSet`.

    Refused: labels that are missing, of another size, disagree or cross; inverted or anti-aliased
    masks; bad images.
    """
    path = existing(path)
    if container_of(path) == "png":
        image, numbers = read_image(path)
        labels = png_labels(path, image.shape)
    else:
        image, numbers = _mat_image(path, data_scale)
        labels = _mat_labels(path, image.shape)
    layer_bins = labels.layer_bins()
    if not np.isfinite(layer_bins).any():
        raise refusal(labels.path, "labels", "at least one layer", "none")
    check_layer_bins(layer_bins, str(labels.path))
    return Scene(scene_name(path), len(image), layer_bins, image=image, **numbers)


@dataclass(frozen=True)
class Labels:
    """Labels of an image (range_bin, range_line): layer numbers, 0 being none, or a mask alone."""

    path: Path
    values: np.ndarray

    def mask(self):
        """Where a layer is."""
        return self.values > 0

    def layer_bins(self):
        """Layers (layer, range_line) in range bins."""
        is_mask = self.values.dtype == bool
        return (layers_of_mask if is_mask else layers_of_numbers)(self.values, self.path)


def layers_of_numbers(numbers, where="labels"):
    """Layers of an image of layer numbers, (layer, range_line) in range bins; 0 is no layer.

    The pixels of one layer in one column must lie together.
    """
    rows, lines = np.nonzero(numbers)
    layers = numbers[rows, lines].astype(int) - 1
    shape = (int(numbers.max(initial=0)), numbers.shape[1])
    count = np.zeros(shape)
    first = np.full(shape, np.nan)
    last = np.full(shape, np.nan)
    np.add.at(count, (layers, lines), 1)
    np.fmin.at(first, (layers, lines), rows)
    np.fmax.at(last, (layers, lines), rows)
    apart = last - first > count - 1  # NaN, where the layer is absent, is not
    if apart.any():
        layer, line = np.argwhere(apart)[0]
        found = f"{int(count[layer, line])} apart for number {layer + 1} at range_line {line}"
        raise refusal(where, "layer numbers", "one run of pixels per layer and column", found)
    _check_lines(where, count)
    return (first + last) / 2


def _check_lines(where, count):
    """Refuse numbers that name regions, or levels of grey: pixels by layer and column."""
    there = count > 0
    absent = int((~there.any(axis=1)).sum())
    if 2 * absent > len(count):
        found = f"{len(count) - absent} of numbers up to {len(count)}: scaled to be seen?"
        raise refusal(where, "layer numbers", "1, 2, 3 and so on from the surface down", found)
    if there.any() and np.median(count[there]) > THICKEST_PIXELS:
        found = f"{np.median(count[there]):.0f} pixels a column in the median: regions?"
        raise refusal(where, "layer numbers", f"lines of at most {THICKEST_PIXELS} pixels", found)


def layers_of_mask(mask, where="mask"):
    """Layers of a binary mask, (layer, range_line) in range bins.

    The k-th run of pixels from the top of a column is layer k. More than half of the pixels on, as
    in an inverted mask, are refused, but for images one range bin high.
    """
    mask = np.asarray(mask, dtype=bool)
    if len(mask) > 1 and mask.mean() > MAXIMUM_SHARE_ON:
        found = f"{100 * mask.mean():.0f} % of pixels on: inverted?"
        raise refusal(where, "mask", "layers on a dark ground", found)
    begins = mask.copy()
    begins[1:] &= ~mask[:-1]
    runs = np.cumsum(begins, axis=0)
    return layers_of_numbers(np.where(mask, runs, 0), where)


def _listed(path):
    with library_errors(path, "list", "text with one file name a line"):
        lines = [line.split() for line in path.read_text(encoding="utf-8-sig").splitlines()]
    files = [path.parent / words[0] for words in lines if words]
    missing = [file.name for file in files if not file.is_file()]
    if missing:
        found = f"{len(missing)} missing: {', '.join(missing)}"
        raise refusal(path, "list", "files that are there", one_line(found, 200))
    return files


def _beside(path, prefix):
    """The label file named after an image, or None."""
    label = path.with_name(prefix + path.name.removeprefix("data_"))
    return label if path.name.startswith("data_") and label.is_file() else None


def png_labels(path, shape):
    """PNG labels beside an image of this shape, or of any (None); numbers and mask must agree."""
    numbered, binary = (_beside(path, prefix) for prefix in LABEL_PREFIXES)
    if binary is not None:
        mask = Labels(binary, _as_large(binary, read_mask(binary), shape))
        if numbered is None:
            return mask
        shape = mask.values.shape
    if numbered is None:
        raise refusal(path, "labels", "a file layer_* or layer_binary_* beside it", "none")
    numbers, _ = read_image(numbered)
    labels = Labels(numbered, _as_large(numbered, numbers, shape))
    if binary is not None:
        differ = np.argwhere(labels.mask() != mask.values)
        if differ.size:
            row, line = differ[0]
            found = f"a difference at range_bin {row}, range_line {line}"
            raise refusal(binary, "mask", f"what {numbered.name} has", found)
    return labels


def _mat_image(path, data_scale):
    """8-bit image of `data`, and the numbers that tell what it stands for."""
    data = numeric(path, "data", _mat_variable(path, "data"))
    if data.ndim != 2 or data.size == 0:
        raise refusal(path, "data", "a 2-D image", f"shape {data.shape}")
    n_bad = int((~np.isfinite(data)).sum())
    if n_bad:
        raise refusal(path, "data", "finite values", f"{n_bad} that are not")
    if data_scale is None and _is_8_bit(data):
        return data.astype(np.uint8), {}
    scale = "db" if data.min() < 0 else data_scale
    if scale is None:
        found = f"{data.dtype} from {data.min():g} to {data.max():g}"
        expected = "whole numbers from 0 to 255, or data_scale set to power or db"
        raise refusal(path, "data", expected, found)
    power = data.astype(float)
    if scale == "db":
        power = 10 ** (power / 10)
    with library_errors(path, "data", "an echogram"):
        image, noise_floor_db, maximum_db = to_uint8(power)
    return image, {"noise_floor_db": noise_floor_db, "maximum_db": maximum_db}


def _mat_labels(path, shape):
    """Labels of a MAT file beside an image, or of its own."""
    beside = (_beside(path, prefix) for prefix in LABEL_PREFIXES)
    label = next((file for file in beside if file is not None), path)
    values = numeric(label, "layer", _mat_variable(label, "layer"))
    values = _as_large(label, values, shape)
    if not _is_8_bit(values):
        raise refusal(label, "layer", "whole numbers from 0 to 255", values.dtype)
    is_mask = values.dtype == bool or label.name.startswith("layer_binary_")
    return Labels(label, values > 0 if is_mask else values.astype(np.uint8))


def _mat_variable(path, name):
    values = read_matlab(path, (name,))
    check_present(path, (name,), values)
    return values[name]


def _is_8_bit(values):
    """Whether all are whole numbers from 0 to 255."""
    return bool(((values >= 0) & (values <= 255) & (values == np.floor(values))).all())


def _as_large(path, labels, shape):
    """The labels, if their image is as large as that of the echogram."""
    if shape is not None and labels.shape != tuple(shape):
        raise refusal(path, "size", f"that of the image, {shape}", labels.shape)
    return labels
