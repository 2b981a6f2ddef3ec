"""What a file is, in words: its format, axes, layers, and the traps found in it."""

from pathlib import Path

import numpy as np

from snowsim.constants import SPEED_OF_LIGHT_M_S
from snowsim.echogram import along_track_m, bin_size_s
from snowsim.io import read_echogram, read_layers
from snowsim.io.containers import names_in, read_netcdf
from snowsim.io.guard import is_zarr, refusal
from snowsim.io.layers import surface_among
from snowsim.io.png_pairs import PairSet, tells_db
from snowsim.io.predictions import read_labels, read_map
from snowsim.io.scenes import SceneSet
from snowsim.io.sniff import ECHOGRAMS, in_words, sniff

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
    if path.is_dir() and not is_zarr(path):
        exported = sorted(path.glob("scene_*.nc"))
        if exported:
            what = f"a folder of {len(exported)} exported scenes, of which this is one"
            return _dataset(what, read_netcdf(exported[0]))
        pairs = PairSet(path)
        pairs.check()
        return _scenes("a folder of benchmark pairs", pairs)
    if path.suffix == ".npy":
        return _image("an array", path)
    kind = sniff(path)
    what = in_words(kind)
    if kind == "png":
        return _image(what, path)
    if kind in ECHOGRAMS:
        return _echogram(what, read_echogram(path), names_in(path))
    if kind in ("cresis_layer", "cresis_layer_data", "opr_layers"):
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
    twtt = echogram["twtt"].values
    lines = echogram["slow_time"].values
    bin_s = bin_size_s(echogram)
    bin_cm = 50 * bin_s * SPEED_OF_LIGHT_M_S
    down = f"{twtt.size} range bins of {1e9 * bin_s:.4g} ns ({bin_cm:.3g} cm of air), "
    down += f"twtt {1e6 * twtt[0]:.6g} to {1e6 * twtt[-1]:.6g} us"
    along = f"{lines.size} range lines over {along_track_m(echogram)[-1]:.4g} m, "
    along += f"{lines[0]:.19} to {lines[-1]:.19} UTC"

    power = echogram["Data"].values
    missing = ~(power > 0)
    n_empty = missing.all(axis=0).sum()
    n_last = (np.where(missing, 0, power).argmax(axis=0) == twtt.size - 1).sum()
    known_s = echogram["Surface"].where(echogram["Surface"] > 0).dropna("slow_time").values
    n_unknown = lines.size - known_s.size
    surface = []
    if known_s.size:
        surface = [f"surface: {1e6 * known_s.min():.6g} to {1e6 * known_s.max():.6g} us"]
    compensated = "Elevation_Correction" in stored
    no_flags = "amplitude" in stored and "quality_mask" not in echogram
    traps = {
        "compensated for elevation (Elevation_Correction): undone when read": compensated,
        "power stored in dB: linear when read": stored & {"amplitude", "minData"},
        "time in GPS seconds: without leap seconds when read": "GPS_time" in stored,
        f"{missing.mean():.2%} of pixels hold no power (NaN or 0)": missing.any(),
        f"{n_empty} range lines hold no power at all": n_empty,
        f"{n_last} range lines are strongest in their last bin": n_last,
        f"Surface is unknown on {n_unknown} range lines": n_unknown,
        "no supplement beside it flags range lines": no_flags,
    }
    return _said(what, [down, along], surface, traps)


def _layers(what, layers):
    index = layers.get_index("layer")
    labels = [str(label) for label in index]
    picked = np.isfinite(layers["twtt"].values).mean(axis=1)
    empty = layers.attrs.get("empty_layers", "")
    no_surface = index.dtype.kind in "OUS" and surface_among(labels) != 0
    nameless = any(label.startswith("id ") for label in labels)
    traps = {
        f"without a pick, left out when read: {empty}": empty,
        "none is named surface: frames need one": no_surface,
        "names are not known: no organizer file beside it": nameless,
    }
    rows = [f"{label}: {share:.1%} picked" for label, share in zip(labels, picked, strict=True)]
    rest = picked[MOST_ROWS:]
    if rest.size:
        more = f"{rest.size} more to {labels[-1]}: {rest.min():.1%} to {rest.max():.1%} picked"
        rows = [*rows[:MOST_ROWS], more]
    return _said(what, [f"{layers.sizes['slow_time']} range lines"], rows, traps)


def _scenes(what, scenes):
    sizes = []
    counts = dict.fromkeys(("mute", *COUNTED), 0)
    for scene in scenes:
        sizes.append((scene.n_range_bins, scene.n_range_lines, len(scene.layer_bins)))
        counts["mute"] += scene.image is not None and not tells_db(scene)
        for name in COUNTED:
            counts[name] += int(scene.notes.get(name, 0))
    bins, lines, layers = (f"{min(size)} to {max(size)}" for size in zip(*sizes, strict=True))
    axes = f"{len(sizes)} scenes of {bins} range bins, {lines} range lines"
    told = {"mute": "images do not hold their decibels"} | COUNTED
    traps = {f"{counts[name]} {words}": counts[name] for name, words in told.items()}
    return _said(what, [axes], [f"{layers} a scene"], traps)


def _dataset(what, dataset):
    """Of scenes and statistics: lengths of their axes, and what their attributes say."""
    axes = ", ".join(f"{length} {name}" for name, length in dataset.sizes.items())
    texts = [name for name, value in dataset.attrs.items() if isinstance(value, str)]
    numbers = [f"{name} {dataset.attrs[name]:.6g}" for name in dataset.attrs.keys() - texts]
    traps = {f"{name}: {dataset.attrs[name]}": dataset.attrs[name] for name in texts}
    layers = [f"{dataset.sizes['layer']}"] if "layer" in dataset.sizes else []
    return _said(what, [axes, *sorted(numbers)], layers, traps)


def _image(what, path):
    """Layers, where the file can be read as such, else an edge map or image."""
    try:
        mask, layers = read_labels(path)
    except ValueError:
        values = read_map(path)
        traps = {"mostly bright: dark layers on a bright ground?": np.median(values) > 0.5}
        return _said(f"{what}: an image or edge map", [_axes(values)], [], traps)
    axes = f"{layers.shape[1]} range lines" if mask is None else _axes(mask)
    return _said(f"{what}: layers", [axes], [f"{len(layers)}"], {})


def _axes(image):
    return "{} range bins, {} range lines".format(*image.shape)
