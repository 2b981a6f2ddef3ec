"""Damaged files give one line, never a crash, a hang or another exception.

They are truncated, or bits of them are flipped. Files are read in a child process under a limit of
time and of memory. Files without checksums cannot tell a flipped bit of a sample from data: there,
at most the values that were hit may differ.
"""

import json
import resource
import shutil
import subprocess
import sys
from functools import partial
from pathlib import Path

import formats
import numpy as np
import pytest

from snowsim.echogram import Scene
from snowsim.io import read_echogram, read_layers
from snowsim.io.files import write_dataset
from snowsim.io.pairs import layer_numbers, read_image, read_pair, write_image

MOST_FLIPS = 8
# A file is called after its kind, which begins with what it holds.
READERS = {
    "echogram": lambda path: read_echogram(path)["Data"].values,
    "layers": lambda path: read_layers(path)["twtt"].values,
    "image": lambda path: read_image(path)[0],
    "pair": lambda path: read_pair(path).mask(),
}


def write_png(path, scene):
    write_image(path, scene.image, {"maximum_db": scene.maximum_db})


def sound_files(rng):
    """Writer and content of a sound file of every kind, small: random bits often hit structure."""
    content = formats.truth(rng, n_bins=40, n_lines=12)
    gps_time, surface = content["GPS_time"], content["Surface"]
    twtt = np.array([surface, surface + 1e-8, surface + 2e-8])
    image = rng.integers(0, 256, (300, 10), dtype=np.uint8)
    layer_bins = np.array([[50.0], [80.0], [120.0]]) + np.zeros(10)
    scene = Scene("s", 300, layer_bins, image=image, maximum_db=3.0)
    echogram = content | {"param_records": {"season_name": "2012", "x": np.ones(3)}}
    layers = formats.layer_content(twtt, [1, 2, 3], gps_time)
    old_layers = formats.old_layer_content(twtt[:2], gps_time, ["surface", "Koenig_2"])
    pair = {"data": scene.image, "layer": layer_numbers(scene.layer_bins, 300)[0]}
    plain_mat5 = partial(formats.write_mat5, compress=False)
    netcdf3 = partial(formats.write_nsidc, format="NETCDF3_CLASSIC")
    return {
        "echogram-nsidc": (formats.write_nsidc, content),
        "echogram-netcdf3": (netcdf3, content),
        "echogram-mat5": (plain_mat5, echogram),
        "echogram-mat5-compressed": (formats.write_mat5, echogram),
        "echogram-mat73": (formats.write_mat73, echogram),
        "echogram-opr": (write_dataset, formats.opr_dataset(content)),
        "layers-mat5": (plain_mat5, layers),
        "layers-mat73": (formats.write_mat73, layers),
        "layers-old-mat5": (plain_mat5, old_layers),
        "layers-old-mat73": (formats.write_mat73, old_layers),
        "layers-opr": (write_dataset, formats.opr_layers(twtt, gps_time, ["surface", "a", "b"])),
        "image-png": (write_png, scene),
        "pair-mat73": (formats.write_mat73, pair),
    }


KINDS = tuple(sound_files(np.random.default_rng(0)))


def flipped(content, rng):
    """With some bits flipped, every other time in its first 4096 bytes alone."""
    content = bytearray(content)
    most = rng.choice([4096, len(content)])
    for place in rng.integers(min(most, len(content)), size=rng.integers(1, MOST_FLIPS + 1)):
        content[place] ^= 1 << rng.integers(8)
    return bytes(content)


def outcomes_of(folder):
    """What became of all files or stores of a folder, in a child process; errors are one line."""
    names = {path.name for path in folder.iterdir()}
    command, seconds = [sys.executable, __file__, str(folder)], 60 + 2 * len(names)
    child = subprocess.run(command, capture_output=True, text=True, timeout=seconds, check=False)
    outcomes = {}
    for line in child.stdout.splitlines():
        outcome = json.loads(line)
        outcomes[outcome.pop("file")] = outcome
    at = next((name for name, outcome in outcomes.items() if outcome.get("begun")), None)
    assert child.returncode == 0, f"{at}: {child.stderr[-2000:]}"
    assert outcomes.keys() == names
    for name, outcome in outcomes.items():
        if "error" in outcome:
            assert outcome["error"].startswith(f"{folder / name}: "), outcome["error"]
            assert "\n" not in outcome["error"]
            assert len(outcome["error"]) < 1000
    return outcomes


@pytest.mark.parametrize(
    ("kinds", "n_files"),
    [(KINDS, 6), *(pytest.param([kind], 200, marks=pytest.mark.slow, id=kind) for kind in KINDS)],
)
def test_damaged_files_give_one_line_or_values_but_for_those_hit(tmp_path, rng, kinds, n_files):
    for kind in kinds:
        write, content = sound_files(rng)[kind]
        sound = tmp_path / f"{kind}.sound"
        write(sound, content)
        whole = sound.read_bytes()
        for number in range(n_files):
            cut = whole[: rng.integers(1, len(whole))]
            (tmp_path / f"{kind}.cut.{number:04d}").write_bytes(cut)
            (tmp_path / f"{kind}.flipped.{number:04d}").write_bytes(flipped(whole, rng))
    outcomes = outcomes_of(tmp_path)
    for name, outcome in outcomes.items():
        kind, damage, *_ = name.split(".")
        if "error" not in outcome:
            expected = np.array(outcomes[f"{kind}.sound"]["values"])
            same = np.isclose(outcome["values"], expected, rtol=0, atol=0, equal_nan=True)
            # A cut file is refused, or was cut behind all that is read. A pixel of a label is one
            # less of a layer and one more of another.
            assert (~same).sum() <= (2 * MOST_FLIPS if damage == "flipped" else 0), name


@pytest.mark.parametrize("n_stores", [20, pytest.param(300, marks=pytest.mark.slow)])
def test_damaged_stores_give_one_line(tmp_path, rng, n_stores):
    sound = tmp_path / "echogram-sound"
    formats.opr_dataset(formats.truth(rng, n_bins=40, n_lines=12)).to_zarr(sound)
    for number in range(n_stores):
        store = shutil.copytree(sound, tmp_path / f"echogram-zarr-{number:04d}")
        files = [path for path in sorted(store.rglob("*")) if path.is_file()]
        file = files[rng.integers(len(files))]
        file.write_bytes(flipped(file.read_bytes(), rng)[: rng.integers(1, 1000)])
    outcomes = outcomes_of(tmp_path)
    assert sum("error" in outcome for outcome in outcomes.values()) > n_stores / 10


if __name__ == "__main__":
    # The child process: reads every file of a folder, tells each outcome on a line of its own.
    resource.setrlimit(resource.RLIMIT_AS, (8 << 30, 8 << 30))
    for path in sorted(Path(sys.argv[1]).iterdir()):
        print(json.dumps({"file": path.name, "begun": True}), flush=True)  # noqa: T201
        try:
            outcome = {"values": READERS[path.name.partition("-")[0]](path).tolist()}
        except ValueError as error:
            outcome = {"error": str(error)}
        print(json.dumps({"file": path.name, **outcome}), flush=True)  # noqa: T201
