"""The published benchmark's pairs of image and labels, as PNG or MAT v7.3, read scene by scene."""

import re
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from snowsim.echogram import Scene, check_choice, check_layer_bins, to_uint8
from snowsim.io.guard import container_of, existing, library_errors, numeric, one_line, refusal
from snowsim.io.images import read_image
from snowsim.io.matlab import read_matlab

MAXIMUM_SHARE_ON = 0.5  # a mask of one pixel per layer and column has a few per cent on; an inverted one nearly all
DATA_SCALES = ("power", "db")


class PairSet(Sequence):
    """Scenes of a directory in the layout of the published benchmark; a scene is read when it is asked for.

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
        beside = [_beside(path, prefix) for path in paths for prefix in ("layer_", "layer_binary_")]
        return [*paths, *(path for path in beside if path is not None)]

    def check(self):
        """Read every scene once; one ValueError names all that fail, also those not as wide as most.

        A list of a dict for each scene: `name`, `n_range_bins`, `n_range_lines`, `n_layers`, and
        whether it `tells_db`.
        """
        rows, failed = [], []
        for path in self._paths:
            try:
                scene = read_pair(path, data_scale=self._data_scale)
            except ValueError as error:
                failed.append(str(error))
                continue
            sizes = {"n_range_bins": scene.n_range_bins, "n_range_lines": scene.n_range_lines}
            tells_db = bool(np.isfinite([scene.noise_floor_db, scene.maximum_db]).all())
            rows.append(
                {
                    "name": scene.name,
                    **sizes,
                    "n_layers": len(scene.layer_bins),
                    "tells_db": tells_db,
                }
            )
        usual = Counter(row["n_range_lines"] for row in rows).most_common(1)
        for row in rows:
            if row["n_range_lines"] != usual[0][0]:
                expected = f"{usual[0][0]} range lines as in most"
                failed.append(str(refusal(row["name"], "width", expected, row["n_range_lines"])))
        if failed:
            msg = "\n".join([f"{len(failed)} of {len(self)} scenes fail:", *failed])
            raise ValueError(msg)
        return rows


def scene_name(path):
    """Name of the scene an image `data_<name>.png` shows."""
    return re.sub("^data_", "", Path(path).stem)


def read_pair(path, *, data_scale=None):
    """Scene of one `data_*` file and the labels beside it; see `PairSet`.

    Refused: labels that are missing, of another size, disagree or cross; inverted or anti-aliased
    masks; bad images.
    """
    path = existing(path)
    if container_of(path) == "png":
        image, texts = read_image(path)
        where, numbers, mask = png_labels(path, image.shape)
    else:
        image, texts = _mat_image(path, data_scale)
        where, numbers, mask = _mat_labels(path, image.shape)
    layer_bins = (
        layers_of_mask(mask, where) if numbers is None else layers_of_numbers(numbers, where)
    )
    if not np.isfinite(layer_bins).any():
        raise refusal(where, "labels", "at least one layer", "none")
    check_layer_bins(layer_bins, str(where))
    return Scene(scene_name(path), image.shape[0], layer_bins, image=image, **texts)


def layers_of_numbers(numbers, where="labels"):
    """Layers of an image of layer numbers, (layer, range_line) in range bins; 0 is no layer.

    The pixels of one layer in one column must lie together.
    """
    numbers = np.asarray(numbers)
    layer_bins = np.full((int(numbers.max(initial=0)), numbers.shape[1]), np.nan)
    rows, lines = np.nonzero(numbers)
    layers = numbers[rows, lines].astype(int) - 1
    shape = layer_bins.shape
    count, lowest, highest = np.zeros(shape), np.full(shape, np.inf), np.full(shape, -np.inf)
    np.add.at(count, (layers, lines), 1)
    np.minimum.at(lowest, (layers, lines), rows)
    np.maximum.at(highest, (layers, lines), rows)
    present = count > 0
    apart = present & (np.where(present, highest - lowest, 0) != count - 1)
    if apart.any():
        layer, line = np.argwhere(apart)[0]
        found = f"{int(count[layer, line])} apart for number {layer + 1} at range_line {line}"
        raise refusal(where, "layer numbers", "one run of pixels per layer and column", found)
    layer_bins[present] = (lowest[present] + highest[present]) / 2
    return layer_bins


def layers_of_mask(mask, where="mask"):
    """Layers of a binary mask, (layer, range_line) in range bins: the k-th run from the top of a column is layer k.

    More than half of the pixels on, as in an inverted mask, are refused, but for images one range
    bin high.
    """
    mask = np.asarray(mask, dtype=bool)
    if len(mask) > 1 and mask.mean() > MAXIMUM_SHARE_ON:
        raise refusal(
            where,
            "mask",
            "layers on a dark ground",
            f"{100 * mask.mean():.0f} % of pixels on: inverted?",
        )
    edge = np.zeros((1, mask.shape[1]), dtype=np.int8)
    steps = np.diff(np.concatenate([edge, mask.astype(np.int8), edge]), axis=0)
    # Transposed, so that both lists run down one column after another and pair up.
    lines, first = np.nonzero(steps.T == 1)
    _, behind = np.nonzero(steps.T == -1)
    run = np.arange(lines.size) - np.searchsorted(lines, lines)
    layer_bins = np.full((int(run.max(initial=-1)) + 1, mask.shape[1]), np.nan)
    layer_bins[run, lines] = (first + behind - 1) / 2
    return layer_bins


def _listed(path):
    with library_errors(path, "list", "text with one file name a line"):
        lines = [line.split() for line in path.read_text(encoding="utf-8").splitlines()]
    files = [path.parent / words[0] for words in lines if words]
    missing = [file.name for file in files if not file.is_file()]
    if missing:
        found = one_line(f"{len(missing)} missing: {', '.join(missing)}", 200)
        raise refusal(path, "list", "files that are there", found)
    return files


def _beside(path, prefix):
    """The label file named after an image, or None."""
    label = path.with_name(prefix + path.name.removeprefix("data_"))
    return label if path.name.startswith("data_") and label.is_file() else None


def png_labels(path, shape):
    """File the PNG labels of an image of this shape, or of any, are from; layer numbers or None, mask or None."""
    numbered, binary = _beside(path, "layer_"), _beside(path, "layer_binary_")
    if numbered is None and binary is None:
        raise refusal(path, "labels", "a file layer_* or layer_binary_* beside it", "none")
    numbers = mask = None
    if binary is not None:
        mask = _as_large(binary, read_image(binary, binary=True)[0], shape)
        shape = mask.shape
    if numbered is not None:
        numbers = _as_large(numbered, read_image(numbered)[0], shape)
    if numbers is not None and mask is not None and ((numbers > 0) != mask).any():
        row, line = np.argwhere((numbers > 0) != mask)[0]
        found = f"a difference at range_bin {row}, range_line {line}"
        raise refusal(binary, "mask", f"what {numbered.name} has", found)
    return numbered or binary, numbers, mask


def _mat_image(path, data_scale):
    """8-bit image of `data`, and what it stands for."""
    values = read_matlab(path, ("data",))
    if "data" not in values:
        raise refusal(path, "data", "variable data", "none")
    data = numeric(path, "data", values["data"])
    if data.ndim != 2 or data.size == 0:
        raise refusal(path, "data", "a 2-D image", f"shape {data.shape}")
    if not np.isfinite(data).all():
        raise refusal(
            path, "data", "finite values", f"{int((~np.isfinite(data)).sum())} that are not"
        )
    if (
        data.min() >= 0
        and data.max() <= 255
        and (data == np.floor(data)).all()
        and data_scale is None
    ):
        return data.astype(np.uint8), {}
    scale = "db" if data.min() < 0 else data_scale
    if scale is None:
        found = f"{data.dtype} from {data.min():g} to {data.max():g}"
        raise refusal(
            path, "data", "whole numbers from 0 to 255, or data_scale set to power or db", found
        )
    power = 10 ** (data.astype(float) / 10) if scale == "db" else data.astype(float)
    with library_errors(path, "data", "an echogram"):
        image, noise_floor_db, maximum_db = to_uint8(power)
    return image, {"noise_floor_db": noise_floor_db, "maximum_db": maximum_db}


def _mat_labels(path, shape):
    label = next(
        (p for p in (_beside(path, "layer_"), _beside(path, "layer_binary_")) if p is not None),
        path,
    )
    values = read_matlab(label, ("layer",))
    if "layer" not in values:
        raise refusal(label, "layer", "variable layer", "none")
    numbers = _as_large(label, numeric(label, "layer", values["layer"]), shape)
    if not ((numbers >= 0) & (numbers <= 255) & (numbers == np.floor(numbers))).all():
        raise refusal(label, "layer", "whole numbers from 0 to 255", numbers.dtype)
    if numbers.dtype == bool or label.name.startswith("layer_binary_"):
        return label, None, numbers > 0
    return label, numbers.astype(np.uint8), None


def _as_large(path, labels, shape):
    """The labels, if their image is as large as that of the echogram."""
    if shape is not None and labels.shape != tuple(shape):
        raise refusal(path, "size", f"that of the image, {shape}", labels.shape)
    return labels
