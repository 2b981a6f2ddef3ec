"""The published benchmark's pairs of image and labels, as PNG or MAT, read scene by scene."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from snowsim.echogram import Scene, check_choice, check_layer_bins, to_uint8
from snowsim.io.containers import read_matlab
from snowsim.io.guard import is_png, library_errors, listed, refusal, report
from snowsim.io.images import read_image, read_mask
from snowsim.progress import shown

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
        path = Path(path)
        check_choice("data_scale", data_scale, (None, *DATA_SCALES))
        self._data_scale = data_scale
        if path.is_dir():
            self._paths = sorted(path.glob("data_*.png")) or sorted(path.glob("data_*.mat"))
        else:
            with library_errors(path, "expected a folder, or a list with one file name a line"):
                lines = path.read_text(encoding="utf-8-sig").splitlines()
            self._paths = [path.parent / line.split()[0] for line in lines if line.strip()]
        self.names = [scene_name(file) for file in self._paths]
        missing = [file.name for file in self._paths if not file.is_file()]
        twice = {name for name in self.names if self.names.count(name) > 1}
        if not self.names or missing or twice:
            expected = "files data_*.png or data_*.mat that are there, of names that differ"
            found = f"{len(self)}, {len(missing)} missing: {listed(missing)}; "
            raise refusal(path, "scenes", expected, f"{found}twice: {listed(twice)}")

    def __len__(self):
        return len(self._paths)

    def __getitem__(self, item):
        return read_pair(self._paths[item], data_scale=self._data_scale)

    def files(self, span):
        """Files a slice of scenes is read from: images and labels."""
        paths = self._paths[span]
        return paths + [label for path in paths for label in labels_beside(path)]

    def check(self):
        """Read every scene once; one ValueError names all that fail.

        Those not as wide as most fail, too. Returned is a list of a dict for each scene: `name`,
        `n_range_bins`, `n_range_lines`, `n_layers`, and whether it `tells_db`.
        """
        rows = []
        failed = []
        for item in shown(range(len(self)), unit="scene"):
            try:
                scene = self[item]
            except ValueError as error:
                failed.append(str(error))
                continue
            sizes = {"n_range_bins": scene.n_range_bins, "n_range_lines": scene.n_range_lines}
            told = {"n_layers": len(scene.layer_bins), "tells_db": tells_db(scene)}
            rows.append({"name": scene.name} | sizes | told)
        widths = [row["n_range_lines"] for row in rows]
        usual = max(widths, key=widths.count, default=None)
        expected = f"width: expected {usual} range lines as in most"
        for row in rows:
            if row["n_range_lines"] != usual:
                failed.append(f"{row['name']}: {expected}, found {row['n_range_lines']}")
        report(failed, f"{len(failed)} of {len(self)} scenes fail:")
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
    path = Path(path)
    with library_errors(path):
        image, numbers = read_image(path) if is_png(path) else _mat_image(path, data_scale)
        label, drawn = pair_labels(path)
    if drawn.shape != image.shape:
        raise refusal(label, "size", f"that of the image, {image.shape}", drawn.shape)
    layer_bins = layers_of_labels(drawn, label)
    if not np.isfinite(layer_bins).any():
        raise refusal(label, "labels", "at least one layer", "none")
    check_layer_bins(layer_bins, str(label))
    return Scene(scene_name(path), len(image), layer_bins, image=image, **numbers)


def layers_of_labels(drawn, where="labels"):
    """Layers of labels (range_bin, range_line), (layer, range_line) in range bins.

    Labels are layer numbers, the middle of each layer's pixels is taken; or a mask, of bool, in
    which the k-th run of pixels from the top of a column is layer k. More than half of the pixels
    of a mask on, as in an inverted one, are refused, but for images one range bin high; and numbers
    that leave a run, as of regions, or are mostly missing, as of numbers scaled to be seen.
    """
    if drawn.dtype == bool:
        if len(drawn) > 1 and drawn.mean() > MAXIMUM_SHARE_ON:
            found = f"{100 * drawn.mean():.0f} % of pixels on: inverted?"
            raise refusal(where, "mask", "layers on a dark ground", found)
        begins = drawn.copy()
        begins[1:] &= ~drawn[:-1]
        drawn = np.where(drawn, np.cumsum(begins, axis=0), 0)
    rows, lines = np.nonzero(drawn)
    pixels = pd.DataFrame({"layer": drawn[rows, lines], "line": lines, "row": rows})
    runs = pixels.groupby(["layer", "line"])["row"].agg(["count", "min", "max"])
    n_layers = int(drawn.max(initial=0))
    n_apart = int((runs["max"] - runs["min"] >= runs["count"]).sum())
    n_found = pixels["layer"].nunique()
    thickness = runs["count"].median()
    if n_apart or 2 * n_found < n_layers or thickness > THICKEST_PIXELS:
        expected = "1, 2, 3 and so on from the surface down, each one run of pixels in a column, "
        expected += f"of at most {THICKEST_PIXELS}"
        found = f"{n_found} of numbers up to {n_layers}, {thickness:.0f} pixels a "
        found += f"column in the median, {n_apart} times apart: regions, or scaled to be seen?"
        raise refusal(where, "layer numbers", expected, found)
    middles = ((runs["min"] + runs["max"]) / 2).unstack("line")
    return middles.reindex(range(1, n_layers + 1)).reindex(columns=range(drawn.shape[1])).to_numpy()


def labels_beside(path):
    """Label files named after an image `data_*`: of layer numbers, of a mask."""
    name = path.name.removeprefix("data_")
    labels = [path.with_name(prefix + name) for prefix in LABEL_PREFIXES]
    return [label for label in labels if label.is_file()]


def pair_labels(path):
    """File and labels of an image `data_*`: uint8 layer numbers, or a mask of bool.

    They are beside it, or within it if it is a MAT file. Numbers and a mask must agree.
    """
    first, *others = labels_beside(path) or [path]
    if first == path and path.suffix == ".png":
        raise refusal(path, "labels", "a file layer_* or layer_binary_* beside it", "none")
    drawn = _drawn_labels(first)
    for other in others:
        if not np.array_equal(_drawn_labels(other), drawn > 0):
            raise refusal(other, "mask", f"what {first.name} has", "a difference")
    return first, drawn


def _drawn_labels(path):
    is_mask = path.name.startswith("layer_binary_")
    if path.suffix == ".png":
        return read_mask(path) if is_mask else read_image(path)[0]
    values = np.atleast_2d(read_matlab(path, ("layer",))["layer"])
    if not _is_8_bit(values):
        raise refusal(path, "layer", "whole numbers from 0 to 255", values.dtype)
    return values > 0 if is_mask or values.dtype == bool else values.astype(np.uint8)


def _mat_image(path, data_scale):
    """8-bit image of `data`, and the numbers that tell what it stands for."""
    data = np.atleast_2d(read_matlab(path, ("data",))["data"])
    if data_scale is None and _is_8_bit(data):
        return data.astype(np.uint8), {}
    scale = "db" if data.min() < 0 else data_scale
    if scale is None:
        raise refusal(path, "data", f"whole numbers to 255, or data_scale of {DATA_SCALES}", scale)
    power = 10 ** (data / 10) if scale == "db" else data.astype(float)
    image, noise_floor_db, maximum_db = to_uint8(power)
    return image, {"noise_floor_db": noise_floor_db, "maximum_db": maximum_db}


def _is_8_bit(values):
    """Whether all are whole numbers from 0 to 255."""
    return bool(((values >= 0) & (values <= 255) & (values == np.floor(values))).all())
