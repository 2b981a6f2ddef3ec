"""Description of a file: its format, sizes, radar, time and place."""

from pathlib import Path

import numpy as np
import xarray as xr

from snowsim.alignment import bin_size_s
from snowsim.io import read_echogram, read_layers
from snowsim.io.containers import ECHOGRAMS, LAYERS, format_of, in_words, open_container
from snowsim.io.files import content_of, is_zarr, one_line, picture_format
from snowsim.io.pairs import ANY_GREY, SPACING, PairSet, read_image
from snowsim.io.predictions import read_array
from snowsim.io.scenes import SceneSet
from snowsim.progress import with_progress

# Attributes that say which radar recorded or simulated the data.
RADAR = ("radar_name", "season_name", "day_seg", "centre_hz", "bandwidth_hz", "n_looks")


def describe(path):
    """Description of a file or folder, {"format": text, "sizes": text, ...}, and its dataset.

    The whole file is read, so that the errors are those of its reader. The dataset of scenes is
    None.
    """
    path = Path(path)
    if path.is_dir() and not is_zarr(path):
        return _described_scenes("a folder of benchmark pairs", PairSet(path))
    if path.suffix == ".npy":
        return _described("an array", _image(read_array(path)))
    content = content_of(path)
    picture = picture_format(content)
    if picture:
        return _described(f"a {picture} image", _image(read_image(path, ANY_GREY, content)[0]))
    stored = open_container(path, content)
    kind = format_of(stored, (*ECHOGRAMS, *LAYERS, "scenes", "statistics"))
    if kind == "scenes":
        with SceneSet(path) as scenes:
            return _described_scenes(in_words(kind), scenes)
    if kind in ECHOGRAMS:
        held = read_echogram(stored)
    else:
        held = read_layers(stored) if kind in LAYERS else stored.read()
    return _described(in_words(kind), held)


def _image(values):
    return xr.Dataset({"image": (("range_bin", "range_line"), values)})


def _described_scenes(what, scenes):
    sizes = []
    spacings = {name: set() for name in SPACING}
    for scene in with_progress(scenes, unit="scene"):
        sizes.append((scene.n_range_bins, scene.n_range_lines, len(scene.layer_bins)))
        for name in spacings.keys() & scene.notes.keys():
            spacings[name].add(scene.notes[name])
    least, most = np.min(sizes, axis=0), np.max(sizes, axis=0)
    names = ("range bins", "range lines", "layers")
    spans = []
    for name, low, high in zip(names, least, most, strict=True):
        spans.append(f"{low} {name}" if low == high else f"{low} to {high} {name}")
    spans += [f"range bins of {value:.4g} s" for value in sorted(spacings["bin_size_s"])]
    spans += [f"range lines {value:g} m apart" for value in sorted(spacings["line_spacing_m"])]
    return {"format": what, "sizes": f"{len(sizes)} scenes of {', '.join(spans)}"}, None


def _described(what, held):
    sizes = [f"{name} {size}" for name, size in held.sizes.items()]
    if "Data" in held:
        sizes.append(f"range bins of {bin_size_s(held):.4g} s")
    lines = {"format": what, "sizes": ", ".join(sizes)}
    if "layer" in held.coords:
        lines["layers"] = one_line(", ".join(held["layer"].values.astype(str)))
    radar = [f"{name} {held.attrs[name]}" for name in RADAR if name in held.attrs]
    if radar:
        lines["radar"] = one_line(", ".join(radar))
    if "slow_time" in held:
        first, last = held["slow_time"].values[[0, -1]].astype("datetime64[s]")
        lines["time"] = f"{first} to {last} UTC"
    if {"Latitude", "Longitude"} <= held.keys():
        places = held[["Latitude", "Longitude"]].to_array().values
        places = places[:, np.isfinite(places).all(axis=0)]
        if places.size:
            ends = [f"{place[0]:.5f}, {place[1]:.5f}" for place in (places[:, 0], places[:, -1])]
            lines["place"] = f"{' to '.join(ends)} (degrees north, east)"
    return lines, held
