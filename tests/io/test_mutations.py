"""Damaged files give one line, never a crash, a hang or another exception.

They are truncated, flipped, overwritten, or their variables dropped or retyped.
Files are read in a child process under a limit of time and of memory. HDF5 without checksums cannot
tell a flipped bit of its payload from data: there, at most the value that was hit may differ.
"""

import json
import resource
import shutil
import subprocess
import sys
from functools import partial
from itertools import cycle
from pathlib import Path

import formats
import h5py
import numpy as np
import pytest
import scipy.io

from snowsim.echogram import Scene
from snowsim.io import read_echogram, read_layers
from snowsim.io.export import export_pairs, layer_numbers
from snowsim.io.files import write_dataset
from snowsim.io.images import read_image
from snowsim.io.png_pairs import read_pair

# A file is called after its kind, which begins with what it holds.
READERS = {
    "echogram": lambda path: read_echogram(path)["Data"].values,
    "layers": lambda path: read_layers(path)["twtt"].values,
    "image": lambda path: read_image(path)[0],
    "pair": lambda path: read_pair(path).layer_bins,
}


def write_png(path, scene):
    export_pairs(path.parent / "pairs", [scene])
    (path.parent / "pairs" / "data_s.png").rename(path)


def sound_files(rng):
    """Writer and content of a sound file of every kind, small: random bits often hit structure."""
    content = formats.truth(rng, n_bins=40, n_lines=12)
    gps_time, surface = content["GPS_time"], content["Surface"]
    twtt = np.array([surface, surface + 1e-8, surface + 2e-8])
    image = rng.integers(0, 256, (300, 10), dtype=np.uint8)
    scene = Scene("s", 300, twtt[:, :10] * 1e7, image=image, maximum_db=3.0)
    echogram = content | {"param_records": {"season_name": "2012", "x": np.ones(3)}}
    layers = formats.layer_content(twtt, [1, 2, 3], gps_time)
    old_layers = formats.old_layer_content(twtt[:2], gps_time, ["surface", "Koenig_2"])
    pair = {"data": scene.image, "layer": layer_numbers(scene.layer_bins, 300)[0]}
    plain_mat5 = partial(formats.write_mat5, compress=False)
    return {
        "echogram-nsidc": (formats.write_nsidc, content),
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
    content = bytearray(content)
    for place in rng.integers(len(content), size=rng.integers(1, 9)):
        content[place] ^= 1 << rng.integers(8)
    return bytes(content)


def overwritten(content, rng):
    start, length = rng.integers(len(content)), rng.integers(1, 64)
    return (content[:start] + rng.bytes(int(length)) + content[start + length :])[: len(content)]


DAMAGES = {
    "cut": lambda content, rng: content[: rng.integers(1, len(content))],
    "flipped": flipped,
    "head": lambda content, rng: flipped(content[:4096], rng) + content[4096:],
    "overwritten": overwritten,
}
RETYPED = (
    "text",
    1 + 2j,
    np.zeros((0, 0)),
    np.ones((2, 3, 4)),
    np.int8(3),
    np.full((3, 5), np.inf),
)


def write_changed_variables(kind, sound, folder):
    """The sound file, each of its variables left out or retyped in turn."""
    if sound.read_bytes()[1:4] == b"PNG":
        return
    is_mat5 = sound.read_bytes()[:10] == b"MATLAB 5.0"
    if is_mat5:
        content = {k: v for k, v in scipy.io.loadmat(sound).items() if not k.startswith("__")}
        names = sorted(content)
    else:
        with h5py.File(sound) as file:
            names = sorted(name for name in file if isinstance(file[name], h5py.Dataset))
    for place, name in enumerate(names):
        for number, value in enumerate((None, *RETYPED)):
            path = folder / f"{kind}-var{number:02d}-{place:02d}"
            if is_mat5:
                changed = {k: v for k, v in content.items() if k != name}
                if value is not None:
                    changed[name] = value
                scipy.io.savemat(path, changed)
                continue
            shutil.copy(sound, path)
            with h5py.File(path, "r+") as file:
                del file[name]
                if value is not None:
                    file[name] = value


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


def damage(kind, folder, n_files, rng):
    """Write `n_files` damaged files of a kind, and the sound one."""
    (folder / "sound").mkdir(exist_ok=True)
    sound = folder / "sound" / kind
    write, content = sound_files(rng)[kind]
    write(sound, content)
    damaged = folder / "damaged"
    damaged.mkdir(exist_ok=True)
    shutil.copy(sound, damaged / f"{kind}-sound")
    for number, name in zip(range(n_files), cycle(DAMAGES), strict=False):
        content = DAMAGES[name](sound.read_bytes(), rng)
        (damaged / f"{kind}-{name}-{number:04d}").write_bytes(content)
    return sound, damaged


@pytest.mark.parametrize(
    ("kinds", "n_files"),
    [(KINDS, 12), *(pytest.param([kind], 400, marks=pytest.mark.slow, id=kind) for kind in KINDS)],
)
def test_damaged_files_give_one_line(tmp_path, rng, kinds, n_files):
    for kind in kinds:
        sound, damaged = damage(kind, tmp_path, n_files, rng)
        if n_files > 100:
            write_changed_variables(kind, sound, damaged)
    outcomes = outcomes_of(damaged)
    assert len(outcomes) > len(kinds) * n_files
    for name, outcome in outcomes.items():
        # A cut file is refused, or was cut behind all that is read.
        kind, is_cut, _ = name.partition("-cut")
        if is_cut and "error" not in outcome:
            expected = outcomes[f"{kind}-sound"]["values"]
            assert np.array_equal(outcome["values"], expected, equal_nan=True), name


@pytest.mark.parametrize("n_stores", [20, pytest.param(300, marks=pytest.mark.slow)])
def test_damaged_stores_give_one_line(tmp_path, rng, n_stores):
    sound = tmp_path / "echogram-zarr-sound"
    formats.opr_dataset(formats.truth(rng, n_bins=40, n_lines=12)).to_zarr(sound)
    files = [path.relative_to(sound) for path in sorted(sound.rglob("*")) if path.is_file()]
    for number, name in zip(range(n_stores), cycle([*DAMAGES, "gone"]), strict=False):
        store = tmp_path / f"echogram-zarr-{name}-{number:04d}"
        shutil.copytree(sound, store)
        file = store / files[rng.integers(len(files))]
        if name == "gone":
            file.unlink()
        else:
            file.write_bytes(DAMAGES[name](file.read_bytes(), rng))
    outcomes = outcomes_of(tmp_path)
    assert sum("error" in outcome for outcome in outcomes.values()) > n_stores / 10


def test_a_flipped_payload_bit_changes_at_most_its_own_value(tmp_path, rng):
    variables = {"echogram-nsidc": "amplitude"}
    for how in ("mat5", "mat73", "opr"):
        variables |= {f"echogram-{how}": "Data", f"layers-{how}": "twtt"}
    for kind, variable in variables.items():
        sound, damaged = damage(kind, tmp_path, 0, rng)
        whole = sound.read_bytes()
        if whole.startswith(b"MATLAB 5.0"):
            stored = scipy.io.loadmat(sound)[variable].tobytes(order="F")
        else:
            with h5py.File(sound) as file:
                stored = file[variable][()].tobytes()
        for number in range(40):
            content = bytearray(whole)
            content[whole.index(stored) + rng.integers(len(stored))] ^= 1 << rng.integers(8)
            (damaged / f"{kind}-bit-{number:02d}").write_bytes(content)
    outcomes = outcomes_of(damaged)
    for kind in variables:
        expected = np.array(outcomes[f"{kind}-sound"]["values"])
        n_read = n_changed = 0
        for name, outcome in outcomes.items():
            if name.startswith(f"{kind}-bit-") and "values" in outcome:
                values = np.array(outcome["values"])
                both_nan = np.isnan(values) & np.isnan(expected)
                n_different = ((values != expected) & ~both_nan).sum()
                assert n_different <= 1, name
                n_changed += n_different
                n_read += 1
        # Sign and exponent bits can make a value impossible; most bits are of the mantissa.
        assert n_read > 10, kind
        # The last bits of decibels can be lost on the way to power.
        assert n_changed > 0.5 * n_read, kind


if __name__ == "__main__":
    # The child process: reads every file of a folder, tells each outcome on a line of its own.
    resource.setrlimit(resource.RLIMIT_AS, (8 << 30, 8 << 30))
    for path in sorted(Path(sys.argv[1]).iterdir()):
        print(json.dumps({"file": path.name, "begun": True}), flush=True)  # noqa: T201
        try:
            outcome = {"values": READERS[path.name.partition("-")[0]](path).ravel().tolist()}
        except ValueError as error:
            outcome = {"error": str(error)}
        print(json.dumps({"file": path.name, **outcome}), flush=True)  # noqa: T201
