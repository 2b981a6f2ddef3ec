"""What a file is, in words: its format, axes, layers, and the traps found in it."""

import numpy as np

from snowsim.constants import SPEED_OF_LIGHT_M_S
from snowsim.echogram import along_track_m, bin_size_s
from snowsim.io import read_echogram, read_layers
from snowsim.io.guard import ZARR_FILES, existing, refusal
from snowsim.io.layers import surface_among
from snowsim.io.png_pairs import PairSet
from snowsim.io.predictions import read_labels, read_map
from snowsim.io.scenes import SceneSet
from snowsim.io.sniff import in_words, names_in, sniff


def describe(path):
    """Lines with `format`, `axes`, `layers` and `traps` of a file, or of a folder of image pairs, by these names.

    The file is read as a whole: what its reader refuses is refused here, in the reader's own line.
    """
    path = existing(path, directory=True)
    if path.is_dir() and not any((path / name).is_file() for name in ZARR_FILES):
        pairs = PairSet(path)
        pairs.check()
        return _scenes("a folder of benchmark pairs", pairs)
    kind = "array" if path.suffix == ".npy" else sniff(path)
    if kind in ("array", "png", "scene"):
        return _image("an array" if kind == "array" else in_words(kind), path)
    if kind in ("nsidc", "cresis", "opr"):
        return _echogram(in_words(kind), read_echogram(path), names_in(path))
    if kind in ("cresis_layer", "cresis_layer_data", "opr_layers"):
        return _layers(in_words(kind), read_layers(path))
    if kind != "scenes":
        raise refusal(
            path, "format", "an echogram, layers, scenes, an image or an array", in_words(kind)
        )
    with SceneSet(path) as scenes:
        return _scenes(in_words(kind), scenes)


def _said(what, axes, layers, traps):
    """All of it; of the traps those that were found."""
    return {
        "format": [what],
        "axes": axes,
        "layers": layers,
        "traps": [trap for trap, found in traps.items() if found],
    }


def _echogram(what, echogram, stored):
    twtt, lines, power = (echogram[name].values for name in ("twtt", "slow_time", "Data"))
    bin_s, missing = bin_size_s(echogram), ~(power > 0)
    n_empty = int(missing.all(axis=0).sum())
    n_last = int((np.where(missing, 0, power).argmax(axis=0) == twtt.size - 1).sum())
    n_unknown = int((~(echogram["Surface"].values > 0)).sum())
    axes = [
        f"{twtt.size} range bins of {1e9 * bin_s:.4g} ns ({50 * bin_s * SPEED_OF_LIGHT_M_S:.3g} cm of air), "
        f"twtt {1e6 * twtt[0]:.6g} to {1e6 * twtt[-1]:.6g} us",
        f"{lines.size} range lines over {along_track_m(echogram)[-1]:.4g} m, {lines[0]:.19} to {lines[-1]:.19} UTC",
    ]
    traps = {
        "compensated for elevation (Elevation_Correction): undone when read": "Elevation_Correction"
        in stored,
        "power stored in dB: linear when read": stored & {"amplitude", "minData"},
        "time in GPS seconds: without leap seconds when read": "GPS_time" in stored,
        f"{missing.mean():.2%} of pixels hold no power (NaN or 0)": missing.any(),
        f"{n_empty} range lines hold no power at all": n_empty,
        f"{n_last} range lines are strongest in their last bin": n_last,
        f"Surface is unknown on {n_unknown} range lines": n_unknown,
        "no supplement beside it flags range lines": "amplitude" in stored
        and "quality_mask" not in echogram,
    }
    return _said(what, axes, [], traps)


def _layers(what, layers):
    index, picked = layers.get_index("layer"), np.isfinite(layers["twtt"].values)
    labels, empty = [str(label) for label in index], layers.attrs.get("empty_layers", "")
    traps = {
        f"without a pick, left out when read: {empty}": empty,
        "none is named surface: frames need one": index.dtype.kind in "OUS"
        and surface_among(labels) != 0,
        "names are not known: no organizer file beside it": any(
            label.startswith("id ") for label in labels
        ),
    }
    rows = [f"{label}: {row.mean():.1%} picked" for label, row in zip(labels, picked, strict=True)]
    return _said(what, [f"{picked.shape[1]} range lines"], rows, traps)


def _scenes(what, scenes):
    sizes = np.array([(s.n_range_bins, s.n_range_lines, len(s.layer_bins)) for s in scenes])
    bins, lines, layers = (
        f"{low} to {high}" for low, high in zip(sizes.min(axis=0), sizes.max(axis=0), strict=True)
    )
    n_mute = sum(
        s.image is not None and not np.isfinite([s.noise_floor_db, s.maximum_db]).all()
        for s in scenes
    )
    n_outside = sum(bool(s.notes.get("outside_training")) for s in scenes)
    traps = {f"{n_mute} images do not hold their decibels": n_mute}
    traps[f"{n_outside} scenes lie outside what their generator was trained on"] = n_outside
    return _said(
        what,
        [f"{len(sizes)} scenes of {bins} range bins, {lines} range lines"],
        [f"{layers} a scene"],
        traps,
    )


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
