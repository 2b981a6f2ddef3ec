"""What a file is, in words: its format, axes, layers, and the traps found in it."""

from pathlib import Path

import numpy as np
import xarray as xr

from snowsim.constants import SPEED_OF_LIGHT_M_S
from snowsim.echogram import along_track_m, bin_size_s
from snowsim.io import read_echogram, read_layers
from snowsim.io.containers import names_in, read_netcdf
from snowsim.io.guard import is_zarr, one_line, refusal
from snowsim.io.layers import surface_among
from snowsim.io.png_pairs import PairSet, tells_db
from snowsim.io.predictions import read_array
from snowsim.io.scenes import SceneSet
from snowsim.io.sniff import ECHOGRAMS, LAYERS, in_words, sniff
from snowsim.progress import shown

MOST_ROWS = 8  # layers told one by one
# What scenes' notes count.
COUNTED = {
    "n_pixels_cut": "labelled pixels lie below the images",
}


def describe(path):
    """Lines with `format`, `axes`, `layers` and `traps`, by these names, of a file or its folder.

    The file is read as a whole: what its reader refuses is refused here, in the reader's own line.
    """
    path = Path(path)
    exported = sorted(path.glob("scene_*.nc"))
    if exported:
        what = f"a folder of {len(exported)} exported scenes, of which this is one"
        return _dataset(what, read_netcdf(exported[0]))
    if path.is_dir() and not is_zarr(path):
        return _scenes("a folder of benchmark pairs", PairSet(path))
    if path.suffix == ".npy":
        return _image("an array", path)
    kind = sniff(path)
    what = in_words(kind)
    if kind == "png":
        return _image(what, path)
    if kind in ECHOGRAMS:
        return _echogram(what, read_echogram(path), names_in(path))
    if kind in LAYERS:
        return _layers(what, read_layers(path))
    if kind == "scenes":
        with SceneSet(path) as scenes:
            return _scenes(what, scenes)
    if kind in ("statistics", "scene"):
        return _dataset(what, read_netcdf(path))
    raise refusal(path, "format", "an echogram, layers, scenes, an image or an array", what)


def _said(what, axes, layers, traps):
    """All of it; of the traps those that were found."""
    found = [trap for trap, is_there in traps.items() if is_there]
    return {"format": [what], "axes": axes, "layers": layers, "traps": found}


def _echogram(what, echogram, stored):
    twtt_us = 1e6 * echogram["twtt"].values
    times = echogram["slow_time"].values
    bin_s = bin_size_s(echogram)
    bin_cm = 50 * bin_s * SPEED_OF_LIGHT_M_S
    down = f"{twtt_us.size} range bins of {1e9 * bin_s:.4g} ns ({bin_cm:.3g} cm of air), "
    down += f"twtt {twtt_us[0]:.6g} to {twtt_us[-1]:.6g} us"
    along = f"{times.size} range lines over {along_track_m(echogram)[-1]:.4g} m, "
    along += f"{times[0]:.19} to {times[-1]:.19} UTC"
    surface_us = 1e6 * echogram["Surface"].where(echogram["Surface"] > 0)
    n_unknown = int(surface_us.isnull().sum())
    surface = f"surface: {float(surface_us.min()):.6g} to {float(surface_us.max()):.6g} us"
    missing = ~(echogram["Data"].values > 0)
    traps = {
        "compensated for elevation (Elevation_Correction): undone when read": stored
        & {"Elevation_Correction"},
        "power stored in dB: linear when read": stored & {"amplitude", "minData"},
        "time in GPS seconds: without leap seconds when read": stored & {"GPS_time"},
        f"{missing.mean():.2%} of pixels hold no power (NaN or 0)": missing.any(),
        f"Surface is unknown on {n_unknown} range lines": n_unknown,
        "no supplement beside it flags range lines": "amplitude" in stored
        and "quality_mask" not in echogram,
    }
    return _said(what, [down, along], [surface] if n_unknown < times.size else [], traps)


def _layers(what, layers):
    index = layers.get_index("layer")
    labels = [str(label) for label in index]
    picked = np.isfinite(layers["twtt"].values).mean(axis=1)
    empty = layers.attrs.get("empty_layers", "")
    traps = {
        f"without a pick, left out when read: {empty}": empty,
        "none is named surface: frames need one": index.dtype.kind in "OUS"
        and surface_among(labels) != 0,
        "names are not known: no organizer file beside it": labels[0].startswith("id "),
    }
    rows = [f"{label}: {share:.1%} picked" for label, share in zip(labels, picked, strict=True)]
    rest = picked[MOST_ROWS:]
    if rest.size:
        more = f"{rest.size} more to {labels[-1]}: {rest.min():.1%} to {rest.max():.1%} picked"
        rows = [*rows[:MOST_ROWS], more]
    return _said(what, [f"{layers.sizes['slow_time']} range lines"], rows, traps)


def _scenes(what, scenes):
    sizes = []
    mute = "images do not hold their decibels"
    counts = dict.fromkeys((mute, *COUNTED.values()), 0)
    for scene in shown(scenes, unit="scene"):
        sizes.append((scene.n_range_bins, scene.n_range_lines, len(scene.layer_bins)))
        counts[mute] += scene.image is not None and not tells_db(scene)
        for name, words in COUNTED.items():
            counts[words] += int(scene.notes.get(name, 0))
    bins, lines, layers = (f"{min(size)} to {max(size)}" for size in zip(*sizes, strict=True))
    axes = f"{len(sizes)} scenes of {bins} range bins, {lines} range lines"
    traps = {f"{count} {words}": count for words, count in counts.items()}
    return _said(what, [axes], [f"{layers} a scene"], traps)


def _dataset(what, dataset):
    """Of scenes and statistics: lengths of their axes, and their attributes."""
    axes = [", ".join(f"{length} {name}" for name, length in dataset.sizes.items())]
    for name, value in dataset.attrs.items():
        told = value if isinstance(value, str) else f"{value:.6g}"
        axes.append(one_line(f"{name} {told}"))
    layers = [f"{dataset.sizes['layer']}"] if "layer" in dataset.sizes else []
    return _said(what, axes, layers, {})


def _image(what, path):
    """Of an image or array, its size and levels: a mask has two, layer numbers one a layer."""
    _, image = read_array(path)
    levels = np.unique(image).astype(float)
    on = ("range_bin", "range_line")
    attributes = {"levels": levels.size, "lowest": levels[0], "highest": levels[-1]}
    return _dataset(what, xr.Dataset({"image": (on, image)}, attrs=attributes))
