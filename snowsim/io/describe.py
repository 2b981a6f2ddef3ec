"""What a file is, in words: its format, axes, layers, and the traps found in it."""

import json

import numpy as np

from snowsim.constants import SPEED_OF_LIGHT_M_S
from snowsim.echogram import Scene, along_track_m, bin_size_s
from snowsim.io import read_echogram, read_layers
from snowsim.io.containers import read_netcdf
from snowsim.io.files import read_dataset
from snowsim.io.guard import (
    check_present,
    container_of,
    existing,
    is_zarr,
    library_errors,
    refusal,
)
from snowsim.io.images import read_image
from snowsim.io.layers import surface_among
from snowsim.io.png_pairs import LABEL_PREFIXES, PairSet, read_pair, tells_db
from snowsim.io.predictions import read_labels, read_map
from snowsim.io.scenes import SceneSet
from snowsim.io.sniff import ECHOGRAMS, in_words, names_in, sniff


def describe(path):
    """Lines with `format`, `axes`, `layers` and `traps`, by these names, of a file or its folder.

    The file is read as a whole: what its reader refuses is refused here, in the reader's own line.
    """
    path = existing(path, directory=True)
    if path.is_dir() and not is_zarr(path):
        exported = sorted(path.glob("scene_*.nc"))
        if exported:
            return _scenes("a folder of exported scenes", map(_exported_scene, exported))
        pairs = PairSet(path)
        pairs.check()
        return _scenes("a folder of benchmark pairs", pairs)
    if path.name.startswith("data_") and container_of(path) == "png":
        return _pair(path)
    if path.suffix == ".npy":
        return _image("an array", path)
    kind = sniff(path)
    what = in_words(kind)
    if kind in ("png", "scene"):
        return _image(what, path)
    if kind == "statistics":
        with library_errors(path, "statistics", "those of a flight, as a run writes them"):
            return _statistics(what, read_dataset(path))
    if kind in ECHOGRAMS:
        return _echogram(what, read_echogram(path), names_in(path))
    if kind in ("cresis_layer", "cresis_layer_data", "opr_layers"):
        return _layers(what, read_layers(path))
    if kind == "scenes":
        with SceneSet(path) as scenes:
            return _scenes(what, scenes)
    raise refusal(path, "format", "an echogram, layers, scenes, an image or an array", what)


def _said(what, axes, layers, traps):
    """All of it; of the traps those that were found."""
    found = [trap for trap, is_there in traps.items() if is_there]
    return {"format": [what], "axes": axes, "layers": layers, "traps": found}


def _echogram(what, echogram, stored):
    twtt = echogram["twtt"].values
    lines = echogram["slow_time"].values
    power = echogram["Data"].values
    bin_s = bin_size_s(echogram)
    bin_cm = 50 * bin_s * SPEED_OF_LIGHT_M_S
    length_m = along_track_m(echogram)[-1]
    down = f"{twtt.size} range bins of {1e9 * bin_s:.4g} ns ({bin_cm:.3g} cm of air), "
    down += f"twtt {1e6 * twtt[0]:.6g} to {1e6 * twtt[-1]:.6g} us"
    along = f"{lines.size} range lines over {length_m:.4g} m, {lines[0]:.19} to {lines[-1]:.19} UTC"

    missing = ~(power > 0)
    n_empty = missing.all(axis=0).sum()
    strongest = np.where(missing, 0, power).argmax(axis=0)
    n_last = (strongest == twtt.size - 1).sum()
    n_unknown = (~(echogram["Surface"].values > 0)).sum()
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
    return _said(what, [down, along], [], traps)


def _layers(what, layers):
    index = layers.get_index("layer")
    labels = [str(label) for label in index]
    picked = np.isfinite(layers["twtt"].values)
    empty = layers.attrs.get("empty_layers", "")
    no_surface = index.dtype.kind in "OUS" and surface_among(labels) != 0
    nameless = any(label.startswith("id ") for label in labels)
    traps = {
        f"without a pick, left out when read: {empty}": empty,
        "none is named surface: frames need one": no_surface,
        "names are not known: no organizer file beside it": nameless,
    }
    rows = [f"{label}: {row.mean():.1%} picked" for label, row in zip(labels, picked, strict=True)]
    return _said(what, [f"{picked.shape[1]} range lines"], rows, traps)


def _scenes(what, scenes):
    sizes = []
    n_mute = 0
    n_outside = 0
    n_cut = 0
    n_unlabelled = 0
    for scene in scenes:
        sizes.append((scene.n_range_bins, scene.n_range_lines, len(scene.layer_bins)))
        n_mute += scene.image is not None and not tells_db(scene)
        n_outside += bool(scene.notes.get("outside_training"))
        n_cut += scene.notes.get("n_pixels_cut", 0)
        n_unlabelled += scene.notes.get("n_pixels_unlabelled", 0)
    bins, lines, layers = (f"{min(size)} to {max(size)}" for size in zip(*sizes, strict=True))
    axes = f"{len(sizes)} scenes of {bins} range bins, {lines} range lines"
    traps = {
        f"{n_mute} images do not hold their decibels": n_mute,
        f"{n_outside} scenes lie outside what their generator was trained on": n_outside,
        f"{n_cut} labelled pixels lie below the images": n_cut,
        f"{n_unlabelled} pixels of drawn layers are too faint for a label": n_unlabelled,
    }
    return _said(what, [axes], [f"{layers} a scene"], traps)


def _exported_scene(path):
    """Scene of a file that `snowsim.io.export.export_netcdf` wrote."""
    stored = read_netcdf(path)
    check_present(path, ("layer_bins",), stored.variables)
    with library_errors(path, "scene", "one that was exported"):
        attributes = stored.attrs
        return Scene(
            attributes["name"],
            int(attributes["n_range_bins"]),
            stored["layer_bins"].values,
            image=stored["image"].values if "image" in stored else None,
            noise_floor_db=float(attributes["noise_floor_db"]),
            maximum_db=float(attributes["maximum_db"]),
            notes=json.loads(attributes["notes"]),
        )


def _pair(path):
    """Image of a scene, with what its labels beside it tell."""
    image, numbers = read_image(path)
    scene = Scene(path.stem, len(image), np.empty((0, image.shape[1])), image=image, **numbers)
    beside = [path.with_name(path.name.replace("data_", prefix, 1)) for prefix in LABEL_PREFIXES]
    is_labelled = any(label.is_file() for label in beside)
    if is_labelled:
        scene = read_pair(path)
    traps = {
        "no labels layer_* or layer_binary_* beside it": not is_labelled,
        "does not hold its decibels": not tells_db(scene),
    }
    layers = [f"{len(scene.layer_bins)}, in labels beside it"] if is_labelled else []
    return _said("a PNG image: an echogram of the benchmark", [_axes(image)], layers, traps)


def _statistics(what, statistics):
    """Of a flight: what they were estimated from."""
    about = statistics.attrs
    bins = f"range bins of {1e9 * about['bin_size_s']:.4g} ns"
    lines = f"{about['n_range_lines']} range lines, {about['line_spacing_m']:.4g} m apart"
    frames = f"{about['n_frames']} frames, {about['n_looks']:.3g} looks"
    synthetic = about.get("synthetic")
    missing = about.get("radiometry_missing")
    traps = {synthetic: synthetic, f"radiometry is missing: {missing}": missing}
    return _said(what, [bins, lines, frames], [f"{statistics.sizes['layer']}"], traps)


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
