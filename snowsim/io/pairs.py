"""Image pairs in the layout of the published benchmark, read and written."""

import dataclasses
import hashlib
import io
import json
import re
import warnings
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from PIL import Image, ImageOps
from PIL.PngImagePlugin import PngInfo

from snowsim.echogram import (
    Scene,
    check_choice,
    check_layer_bins,
    echogram,
    from_uint8,
    layer_mask,
)
from snowsim.io.files import (
    content_of,
    library_errors,
    listed,
    picture_format,
    refusal,
    report,
    write_bytes,
    written_together,
)
from snowsim.limits import BIN_S_LIMITS, LINE_SPACING_M_LIMITS, check_values
from snowsim.progress import with_progress

MAXIMUM_PIXELS = 2**26  # 256 columns of 262144 rows; Pillow itself warns above 9e7 pixels
# Limits of the decibels that the greys of an image span where it does not say. Within them, the
# span makes its darkest row the noise floor.
CONTRASTS_DB = (20.0, 100.0)
BLURRED = "a JPEG image: its blocks of 8 pixels blur layers and speckle"
# Numbers of a scene that its PNG image holds as text chunks, and their types.
NUMBERS_IN_TEXT = {"noise_floor_db": float, "maximum_db": float, "zone": int}
ANY_GREY = "grey of 1, 8 or 16 bits, or of three equal colours"
GREY_LABELS = "grey of 1 or 8 bits"
# As Pillow calls them.
MODES = {
    "8-bit grey": ("L",),
    GREY_LABELS: ("1", "L"),
    ANY_GREY: ("1", "L", "I;16", "RGB", "RGBA"),
}


def read_image(path, expected="8-bit grey", content=None):
    """Image (range_bin, range_line) of a PNG or JPEG file, and a dict of its `NUMBERS_IN_TEXT`.

    Pixels are uint8 or uint16, or bool if the file has 1 bit a pixel. An image is turned as its
    EXIF orientation says, as programs show it. `expected` is a key of `MODES`. A damaged file,
    another mode and more than `MAXIMUM_PIXELS` pixels are refused. If `content`, the bytes of the
    file, is given, `path` is only named in errors.
    """
    most = f"a whole grey image of at most {MAXIMUM_PIXELS} pixels"
    with library_errors(path, f"PNG or JPEG image: expected {most}"), warnings.catch_warnings():
        warnings.simplefilter("error", Image.DecompressionBombWarning)
        content = content_of(path) if content is None else content
        source = {"fp": io.BytesIO(content), "formats": [picture_format(content) or "PNG"]}
        Image.open(**source).verify()  # reading the pixels does not compare the checksums
        with Image.open(**source) as file:
            columns, rows = file.size
            if columns * rows > MAXIMUM_PIXELS:
                raise refusal(path, "image", most, f"{rows} rows of {columns}")
            values = np.array(ImageOps.exif_transpose(file))
            texts = getattr(file, "text", {})  # JPEG files have none
            colours = values[..., :3] if values.ndim == 3 else values[..., None]
            if file.mode not in MODES[expected] or (colours != colours[..., :1]).any():
                raise refusal(path, "image", expected, f"mode {file.mode}")
        numbers = {
            name: kind(texts[name]) for name, kind in NUMBERS_IN_TEXT.items() if name in texts
        }
    return colours[..., 0], numbers


def read_image_as_echogram(path, bin_s, content=None):
    """Echogram dataset of an 8-bit grey image with range bins of `bin_s` seconds.

    Without numbers in the image, its darkest row is taken for the noise floor. `content` are the
    bytes of the file, read if they are not given.
    """
    image, numbers = read_image(path, content=content)
    floor_db = numbers.get("noise_floor_db", 0.0)
    darkest = image.mean(axis=1).min()
    contrast_db = np.clip(10 * (255 / max(darkest, 1.0) - 1), *CONTRASTS_DB)
    power_db = from_uint8(image, floor_db, numbers.get("maximum_db", floor_db + contrast_db))
    power = (10 ** (power_db / 10)).astype(np.float32)
    twtt = bin_s * np.arange(len(power))
    return echogram(power, twtt=twtt, attrs={"source_format": "image"})


def read_mask(path):
    """Mask (range_bin, range_line), bool, from an image of at most two grey levels, one being 0."""
    values, _ = read_image(path, ANY_GREY)
    levels = np.unique(values)
    if levels.size > 2 or (levels.size == 2 and levels[0] != 0):
        found = f"{levels.size} levels from {levels[0]} to {levels[-1]}"
        raise refusal(path, "mask", "1 bit, or two grey levels of which one is 0", found)
    return values > 0


def write_image(path, image, numbers=None):
    """Write a PNG, whole or not at all; `numbers` (see `NUMBERS_IN_TEXT`) become text chunks.

    The same pixels and numbers always give the same bytes.
    """
    info = PngInfo()
    for name, number in (numbers or {}).items():
        info.add_text(name, repr(NUMBERS_IN_TEXT[name](number)))
    buffer = io.BytesIO()
    picture = Image.fromarray(np.ascontiguousarray(image))
    picture.save(buffer, format="PNG", compress_level=6, pnginfo=info)
    write_bytes(path, buffer.getvalue())


# A mask with one pixel per layer and column has a few per cent of its pixels on, an inverted mask
# nearly all.
MAXIMUM_SHARE_ON = 0.5
MAXIMUM_THICKNESS_PIXELS = 15  # of a layer in a column, in the median
# File beside the images with their range bin [s] and line spacing [m], by these names in JSON, each
# with its limits.
SPACING_FILE = "spacing.json"
SPACING = {"bin_size_s": BIN_S_LIMITS, "line_spacing_m": LINE_SPACING_M_LIMITS}
LABEL_PREFIXES = ("layer_", "layer_binary_")


class PairSet(Sequence):
    """Scenes in the layout of the published benchmark; each is read when it is requested.

    `path` is a folder, in which every `data_*.png` is a scene (in order of names), or a list file
    with one such name a line, relative to the folder of the list. A second name on the line (the
    label in published lists) is ignored. Refused are: no scene, a missing file, a name that occurs
    twice, and files other than PNG.

    A label is found by putting `layer_` (layer numbers) or `layer_binary_` (mask) in place of
    `data_`. Layer number k is row k - 1 of `layer_bins`; numbers that occur nowhere between others
    leave a row of NaN. A mask alone has no numbers: the k-th run of pixels from the top of a
    column is then layer k - 1 there, so below a gap in a layer the deeper ones count up by one;
    positions, and the mask itself, stay exact. A run of several pixels counts at its middle. Where
    both labels are there, they must agree.

    A file ``spacing.json`` beside the images, ``{"bin_size_s": 2.886e-10, "line_spacing_m": 5.2}``,
    holds numbers that become `notes` of every scene. `spacing` has them by folder.
    """

    def __init__(self, path):
        path = Path(path)
        if path.is_dir():
            self._paths = sorted(path.glob("data_*.png")) or sorted(path.glob("data_*.mat"))
        else:
            with library_errors(path, "expected a folder, or a list with one file name a line"):
                lines = path.read_text(encoding="utf-8-sig").splitlines()
            self._paths = [path.parent / line.split()[0] for line in lines if line.strip()]
        for file in self._paths:
            _check_png(file)
        self.names = [scene_name(file) for file in self._paths]
        folders = sorted({file.parent for file in self._paths})
        self.spacing = {folder: read_spacing(folder) for folder in folders}
        missing = [file.name for file in self._paths if not file.is_file()]
        twice = {name for name in self.names if self.names.count(name) > 1}
        if not self.names or missing or twice:
            expected = "files data_*.png that are there, of names that differ"
            found = f"{len(self)}, {len(missing)} missing: {listed(missing)}; "
            found += f"twice: {listed(twice)}"
            if path.is_dir() and [*path.glob("scene_*.nc"), *path.glob("scene_*.zarr")]:
                found = "scenes as NetCDF or Zarr: export the scene set as image pairs instead"
            raise refusal(path, "scenes", expected, found)

    def __len__(self):
        return len(self._paths)

    def __getitem__(self, item):
        path = self._paths[item]
        scene = read_pair(path)
        return dataclasses.replace(scene, notes=scene.notes | self.spacing[path.parent])

    def files(self, span):
        """Paths of the images of a slice of scenes, and of the labels and spacing beside them."""
        paths = self._paths[span]
        told = [folder / SPACING_FILE for folder in {path.parent: None for path in paths}]
        labels = [label for path in paths for label in labels_beside(path)]
        return paths + labels + [file for file in told if file.is_file()]

    def check(self):
        """List of dicts, one for each scene, after every scene was read once.

        A dict has `name`, `n_range_bins`, `n_range_lines`, `n_layers`, `tells_db` and `digest`, the
        SHA-256 of the pixels. One
        ValueError names all scenes that cannot be read, and all whose number of range lines
        differs from that of most scenes.
        """
        rows = []
        failed = []
        for item in with_progress(range(len(self)), unit="scene"):
            try:
                scene = self[item]
            except ValueError as error:
                failed.append(str(error))
                continue
            row = {
                "name": scene.name,
                "n_range_bins": scene.n_range_bins,
                "n_range_lines": scene.n_range_lines,
                "n_layers": len(scene.layer_bins),
                "tells_db": tells_db(scene),
                "digest": hashlib.sha256(scene.image.tobytes()).hexdigest(),
            }
            rows.append(row)
        widths = [row["n_range_lines"] for row in rows]
        usual = max(widths, key=widths.count, default=None)
        expected = f"width: expected {usual} range lines as in most"
        for row in rows:
            if row["n_range_lines"] != usual:
                failed.append(f"{row['name']}: {expected}, found {row['n_range_lines']}")
        report(failed, f"{len(failed)} of {len(self)} scenes fail:")
        return rows


def read_spacing(folder):
    """Range bin [s] and line spacing [m] of the images in a folder, by name; {} if unknown.

    ValueError for other names, and for values that are no numbers or outside their limits.
    """
    path = Path(folder) / SPACING_FILE
    if not path.is_file():
        return {}
    expected = f"{{{', '.join(SPACING)}}}, positive numbers [s, m]"
    with library_errors(path, f"JSON: expected {expected}"):
        held = json.loads(path.read_text(encoding="utf-8"))
    is_known = isinstance(held, dict) and held.keys() <= set(SPACING)
    if not is_known or not all(type(value) in (int, float) for value in held.values()):
        raise refusal(path, "spacing", expected, held)
    for name, value in held.items():
        check_values(f"{path}: {name}", value, *SPACING[name])
    return held


def tells_db(scene):
    """True if the scene holds the decibels of its darkest and its brightest grey level."""
    return bool(np.isfinite([scene.noise_floor_db, scene.maximum_db]).all())


def scene_name(path):
    """Name of the scene in an image file `data_<name>.png`."""
    return path.stem.removeprefix("data_")


def _check_png(path):
    """Raise ValueError if the image of a pair is no PNG file by its name."""
    if path.suffix != ".png":
        expected = "data_*.png (snowsim.io.write_image saves an array of uint8)"
        raise refusal(path, "pair", expected, path.name)


def read_pair(path):
    """Scene from one `data_*.png` and the labels beside it; see `PairSet`.

    Refused are missing labels, labels of another size than the image, two labels that disagree,
    layers that cross, inverted or anti-aliased masks, and damaged images.
    """
    path = Path(path)
    _check_png(path)
    with library_errors(path):
        image, numbers = read_image(path)
        label, drawn = pair_labels(path)
    if drawn.shape != image.shape:
        raise refusal(label, "size", f"that of the image, {image.shape}", drawn.shape)
    layer_bins = layers_of_labels(drawn, label)
    if not np.isfinite(layer_bins).any():
        raise refusal(label, "labels", "at least one layer", "none")
    check_layer_bins(layer_bins, str(label))
    return Scene(scene_name(path), len(image), layer_bins, image=image, **numbers)


def layers_of_labels(drawn, where="labels"):
    """Layers (layer, range_line) in range bins from labels `drawn` (range_bin, range_line).

    Labels are layer numbers, or a mask (bool) in which the k-th run of pixels from the top of a
    column is layer k. A layer lies at the middle of its run of pixels.

    A mask with more than half of its pixels on is refused as inverted, unless it is one range bin
    high. Layer numbers are refused if they fill regions (thick, or several runs in a column), or
    if most of them do not occur, as after scaling them to visible grey levels.
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
    if n_apart or 2 * n_found < n_layers or thickness > MAXIMUM_THICKNESS_PIXELS:
        expected = (
            "1, 2, 3 and so on from the surface down, each one run of pixels in a column, "
            f"of at most {MAXIMUM_THICKNESS_PIXELS}"
        )
        found = (
            f"{n_found} of numbers up to {n_layers}, {thickness:.0f} pixels a "
            f"column in the median, {n_apart} times apart: regions, or scaled to be seen?"
        )
        raise refusal(where, "layer numbers", expected, found)
    middles = ((runs["min"] + runs["max"]) / 2).unstack("line")
    return middles.reindex(index=range(1, n_layers + 1), columns=range(drawn.shape[1])).to_numpy()


def labels_beside(path):
    """Paths of the labels that an image `data_*` has: layer numbers first, then the mask."""
    name = path.name.removeprefix("data_")
    labels = [path.with_name(prefix + name) for prefix in LABEL_PREFIXES]
    return [label for label in labels if label.is_file()]


def pair_labels(path):
    """Path and pixels of the labels of an image `data_*`: layer numbers (uint8) or a mask (bool).

    If the image has both, they must agree, and the layer numbers are returned.
    """
    labels = labels_beside(path)
    if not labels:
        raise refusal(path, "labels", "a file layer_* or layer_binary_* beside it", "none")
    first, *others = labels
    drawn = _drawn_labels(first)
    for other in others:
        if not np.array_equal(_drawn_labels(other), drawn > 0):
            raise refusal(other, "mask", f"what {first.name} has", "a difference")
    return first, drawn


def _drawn_labels(path):
    return read_mask(path) if path.name.startswith("layer_binary_") else read_image(path)[0]


MAXIMUM_NUMBER = 255  # layer numbers are 8-bit
SAME_SPACING = 1e-6  # relative difference of two spacings that are one
# Names of scenes, which become names of files. The published loader replaces "data_" anywhere in a
# name, and "layer_" before a name that begins with "binary_" would look like a mask.
PLAIN_NAME = "a plain file name (letters a to z, digits, _ . -) without data_ and binary_"
SCENE_NAME = re.compile(r"(?!.*data_)(?!binary_)[A-Za-z0-9][A-Za-z0-9_.-]*")


def check_empty(folder):
    """Raise ValueError if a folder to write scenes to is not empty."""
    held = sorted(path.name for path in Path(folder).glob("*"))
    if held:
        wanted = "an empty or a new one, or --force (force=True) to write into it"
        raise refusal(folder, "folder", wanted, f"{len(held)} files: {held[0]} ...")


def warn_of_others(folder, n_written):
    """Warn if a folder holds more scenes than were written to it now."""
    n_others = len(list(Path(folder).glob("data_*.png"))) - n_written
    if n_others:
        warnings.warn(
            f"{folder}: scenes that were there before stay ({n_others}), and what is trained on "
            "the folder has them, too; all.lst names those that are written now",
            UserWarning,
            stacklevel=3,
        )


def export_pairs(folder, scenes, *, list_name="all.lst", layers="annotated"):
    """Write scenes as image pairs in the layout of the published benchmark; `PairSet` reads them.

    For each scene `data_<name>.png` (8-bit), `layer_binary_<name>.png` (1-bit) and
    `layer_<name>.png` (layer numbers, the surface being 1), then a list file with one `data_*.png`
    a line: what the loader of the published tracker code reads. Decibels of the grey levels go into
    text chunks of the image; range bin and line spacing that all scenes have in their notes, into
    ``spacing.json``, see `PairSet`. The same scenes give the same bytes. Read back, images are
    exact and layers are rounded to whole bins; what leaves the window is not drawn.

    Scenes are held in memory one at a time. `folder` may hold other sets, each with its own list.
    Labels are the "annotated" layers or, with `layers="complete"`, the complete layers of the
    scenes that have them.

    Returns `n_scenes` and `n_merged_pixels`, the number of label pixels that a lower layer covers.
    Refused are names that the published loader would misread, scenes without an image, scenes of
    two range bins, also in the ``spacing.json`` of the folder, and more than 255 layers.
    """
    folder = Path(folder)
    check_choice("layers", layers, ("annotated", "complete"))
    names = []
    n_merged = 0
    known = None
    with written_together():
        for scene in scenes:
            if not SCENE_NAME.fullmatch(scene.name) or scene.name in names:
                expected = f"{PLAIN_NAME}, unlike all others"
                raise refusal(folder, "scene", expected, repr(scene.name))
            if scene.image is None or "data_" in folder.name:
                expected = (
                    "an image; the folder's name must not contain data_, which loaders replace"
                )
                raise refusal(folder, scene.name, expected, "none, or such a name")
            layer_bins = scene.layer_bins
            if layers == "complete" and scene.complete_layer_bins is not None:
                layer_bins = scene.complete_layer_bins
            numbers, merged = layer_numbers(layer_bins, scene.n_range_bins)
            contrast = {name: getattr(scene, name) for name in NUMBERS_IN_TEXT}
            write_image(folder / f"data_{scene.name}.png", scene.image, contrast)
            write_image(folder / f"layer_binary_{scene.name}.png", numbers > 0)
            write_image(folder / f"layer_{scene.name}.png", numbers)
            names.append(scene.name)
            n_merged += merged
            known = _same_spacing(scene, known, folder)
        write_bytes(folder / list_name, "".join(f"data_{name}.png\n" for name in names).encode())
        _write_spacing(folder, known or {})
    return {"n_scenes": len(names), "n_merged_pixels": n_merged}


def _same_spacing(scene, known, folder):
    """Spacings that all scenes so far have, by name; `known` of those before, None for the first.

    Lines of frames lie differently far apart, so their spacing is then unknown. ValueError if a
    scene has another range bin.
    """
    own = {name: scene.notes.get(name) for name in SPACING}
    known = own if known is None else known
    alike = _alike(known, own)
    if None not in (own["bin_size_s"], known["bin_size_s"]) and alike["bin_size_s"] is None:
        expected = (
            f"{known['bin_size_s']:g} as of the scenes before; write others to their own folder"
        )
        raise refusal(folder, f"{scene.name}: bin_size_s", expected, f"{own['bin_size_s']:g}")
    return alike


def _alike(first, second):
    """Spacings by name of `SPACING` that are the same in both; None for those that are not."""
    pairs = {name: (first.get(name), second.get(name)) for name in SPACING}
    return {
        name: a if None not in (a, b) and abs(a / b - 1) <= SAME_SPACING else None
        for name, (a, b) in pairs.items()
    }


def _write_spacing(folder, known):
    """Write the spacings that scenes have, beside their image pairs.

    A folder may hold other sets: the file keeps what is true of them, too. ValueError if these have
    another range bin, or if that of the scenes is unknown.
    """
    held = read_spacing(folder)
    if held:
        alike = _alike(held, known)
        if "bin_size_s" in held and alike["bin_size_s"] is None:
            expected = f"the range bin of the scenes, {known.get('bin_size_s') or 'unknown'}"
            remedy = f"{held['bin_size_s']:g} of others (give an empty folder)"
            raise refusal(folder / SPACING_FILE, "bin_size_s", expected, remedy)
        known = alike
    known = {name: value for name, value in known.items() if value is not None}
    if known or held:
        write_bytes(folder / SPACING_FILE, f"{json.dumps(known)}\n".encode())


def layer_numbers(layer_bins, n_range_bins):
    """Image of layer numbers, uint8 (range_bin, range_line), and the number of merged pixels.

    The surface is 1, background is 0. Each layer of `layer_bins` (layer, range_line) is one pixel
    a range line, at its rounded range bin. If two layers fall on one pixel, it shows the lower one,
    and the pixel counts as merged. Layers outside the image are not drawn.
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
