"""What a file is, in words: its format, what it holds, and what to watch for."""

from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from snowsim.echogram import bin_size_s
from snowsim.io import read_echogram, read_layers
from snowsim.io.containers import ECHOGRAMS, LAYERS, format_of, in_words, opened, read_values
from snowsim.io.files import content_of, is_zarr, one_line, picture_format
from snowsim.io.layers import begins_with_surface
from snowsim.io.pairs import ANY_GREY, BLURRED, PairSet, exported_in, read_image, tells_db
from snowsim.io.predictions import read_array
from snowsim.io.scenes import SceneSet
from snowsim.progress import shown

# What a variable in the file of an echogram tells.
TOLD_BY = {
    "Elevation_Correction": "compensated for elevation (Elevation_Correction): undone when read",
    "amplitude": "power stored in dB: linear when read",
    "minData": "power stored in dB, as integers: linear when read",
    "GPS_time": "time in GPS seconds: without leap seconds when read",
}


def describe(path):
    """Lines with `format`, `holds` and `notes`, by these names, of a file or its folder.

    The file is read as a whole: what its reader refuses is refused here, in the reader's own line.
    """
    path = Path(path)
    exported = exported_in(path)
    if exported:
        what = f"a folder of {len(exported)} exported scenes, of which this is one"
        return _said(what, read_values(exported[0]))
    if path.is_dir() and not is_zarr(path):
        return _scenes("a folder of benchmark pairs", PairSet(path))
    if path.suffix == ".npy":
        return _image(read_array(path)[1])
    content = content_of(path)
    form = picture_format(content)
    if form:
        return _image(read_image(path, ANY_GREY, content)[0], [BLURRED] if form == "JPEG" else [])
    stored = opened(path, content)
    kind = format_of(stored, (*ECHOGRAMS, *LAYERS, "scenes", "scene", "statistics"))
    what = in_words(kind)
    if kind in ECHOGRAMS:
        return _echogram(what, read_echogram(stored), stored.names)
    if kind in LAYERS:
        return _layers(what, read_layers(stored))
    if kind == "scenes":
        with SceneSet(path) as scenes:
            return _scenes(what, scenes)
    return _said(what, stored.read())


def _image(values, notes=()):
    levels = np.unique(values).astype(float)
    told = f"{levels.size} levels from {levels[0]:g} to {levels[-1]:g}"
    image = xr.Dataset({"image": (("range_bin", "range_line"), values)})
    return _said("an image or array", image, [told, *notes])


def _said(what, held, notes=()):
    """All of it as lines; `held` is a dataset or table."""
    with xr.set_options(display_max_rows=20):
        return {"format": [what], "holds": str(held).splitlines(), "notes": notes}


def _echogram(what, echogram, stored):
    missing = ~(echogram["Data"].values > 0)
    unknown = ~(echogram["Surface"].values > 0)
    notes = [words for name, words in TOLD_BY.items() if name in stored]
    notes.append(f"range bins of {bin_size_s(echogram):.4g} s")
    if missing.any():
        notes.append(f"{missing.mean():.2%} of pixels hold no power (NaN or 0)")
    if unknown.any():
        notes.append(f"Surface is unknown on {unknown.sum()} range lines")
    if "amplitude" in stored and "quality_mask" not in echogram:
        notes.append("no supplement beside it flags range lines")
    return _said(what, echogram, notes)


def _layers(what, layers):
    labels = layers.get_index("layer").astype(str)
    picked = np.isfinite(layers["twtt"].values).mean(axis=1)
    shares = [f"{label}: {share:.1%} picked" for label, share in zip(labels, picked, strict=True)]
    notes = [one_line("; ".join(shares))]
    if not begins_with_surface(layers):
        notes.append("none is named surface (by the organizer file beside it)")
    return _said(what, layers, notes)


def _scenes(what, scenes):
    rows = []
    n_mute = n_cut = 0
    for scene in shown(scenes, unit="scene"):
        rows.append((scene.n_range_bins, scene.n_range_lines, len(scene.layer_bins)))
        n_mute += scene.image is not None and not tells_db(scene)
        n_cut += scene.notes.get("n_pixels_cut", 0)
    notes = []
    if n_mute:
        notes.append(f"{n_mute} images do not hold their decibels")
    if n_cut:
        notes.append(f"{n_cut} labelled pixels lie below the images")
    sizes = pd.DataFrame(rows, columns=["range_bins", "range_lines", "layers"])
    return _said(f"{what}: {len(rows)} scenes", sizes.agg(["min", "max"]), notes)
