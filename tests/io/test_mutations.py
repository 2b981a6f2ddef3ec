"""Damaged files give one line, never a crash, a hang or another exception: truncated, flipped, dropped, retyped.

Files are read in a child process under a limit of time and of memory. HDF5 without checksums cannot tell a flipped bit
of its payload from data: there, at most the value that was hit may differ.
"""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import formats
import h5py
import numpy as np
import pytest
import scipy.io
from PIL import Image

from snowsim.echogram import Scene
from snowsim.io.export import export_pairs, layer_numbers
from snowsim.io.files import write_dataset

SECONDS_PER_FILE = 2
KINDS = (
    "echogram-nsidc",
    "echogram-mat5",
    "echogram-mat5-compressed",
    "echogram-mat73",
    "echogram-opr",
    "layers-mat5",
    "layers-mat73",
    "layers-old-mat5",
    "layers-old-mat73",
    "layers-opr",
    "image-png",
    "pair-mat73",
)


def write_sound(kind, path, rng):
    """One sound file of a kind, small, so that a random bit often hits structure."""
    content = formats.truth(rng, n_bins=40, n_lines=12)
    twtt = np.array([content["Surface"], content["Surface"] + 1e-8, content["Surface"] + 2e-8])
    layers = formats.layer_content(twtt, [1, 2, 3], content["GPS_time"])
    old = formats.old_layer_content(twtt[:2], content["GPS_time"], ["surface", "Koenig_2"])
    scene = Scene("s", 300, twtt[:, :10] * 1e7, image=rng.integers(0, 256, (300, 10), dtype=np.uint8), maximum_db=3.0)
    if kind == "echogram-nsidc":
        formats.write_nsidc(path, content)
    elif kind == "echogram-opr":
        write_dataset(path, formats.opr_dataset(content))
    elif kind == "layers-opr":
        names = ["surface", "a", "b"]
        write_dataset(path, formats.opr_layers(twtt, formats.slow_time(content), names))
    elif kind == "image-png":
        export_pairs(path.parent / "pairs", [scene])
        (path.parent / "pairs" / "data_s.png").rename(path)
    elif kind == "pair-mat73":
        formats.write_mat73(path, {"data": scene.image, "layer": layer_numbers(scene.layer_bins, 300)[0]})
    else:
        values = {"echogram": content | {"param_records": {"season_name": "2012", "x": np.ones(3)}}, "layers": layers}
        values = old if "old" in kind else values[kind.partition("-")[0]]
        if kind.endswith("mat73"):
            formats.write_mat73(path, as_lists(values))
        else:
            formats.write_mat5(path, values, compress=kind.endswith("compressed"))


def as_lists(value):
    """Cells as lists, all the way down."""
    if isinstance(value, dict):
        return {key: as_lists(item) for key, item in value.items()}
    if isinstance(value, np.ndarray) and value.dtype.kind == "O":
        return [as_lists(item) for item in value.ravel()]
    return value


def cut(content, rng):
    return content[: rng.integers(1, len(content))]


def flipped(content, rng, low=0, high=None):
    content = bytearray(content)
    for place in rng.integers(low, high or len(content), size=rng.integers(1, 9)):
        content[place] ^= 1 << rng.integers(8)
    return bytes(content)


def flipped_head(content, rng):
    return flipped(content, rng, high=min(len(content), 4096))


def overwritten(content, rng):
    start, length = rng.integers(len(content)), rng.integers(1, 64)
    return (content[:start] + rng.bytes(int(length)) + content[start + length :])[: len(content)]


DAMAGES = {"cut": cut, "flipped": flipped, "head": flipped_head, "overwritten": overwritten}
RETYPED = ("text", 1 + 2j, np.zeros((0, 0)), np.ones((2, 3, 4)), np.int8(3), np.full((3, 5), np.inf))


def write_changed_variables(kind, sound, folder):
    """Files in which one variable is dropped or something else stands in its place."""
    if kind == "image-png":
        with Image.open(sound) as image:
            for mode in ("1", "RGB", "RGBA", "P", "I;16", "LA"):
                image.convert("I").convert(mode).save(folder / f"image-mode-{mode.replace(';', '')}", format="PNG")
        return
    is_mat5 = sound.read_bytes()[:10] == b"MATLAB 5.0"
    if is_mat5:
        content = {k: v for k, v in scipy.io.loadmat(sound).items() if not k.startswith("__")}
        names = sorted(content)
    else:
        with h5py.File(sound) as file:
            names = sorted(name for name in file if isinstance(file[name], h5py.Dataset))
    for name in names:
        for number, value in enumerate((None, *RETYPED)):
            path = folder / f"{kind}-var{number:02d}-{names.index(name):02d}"
            if is_mat5:
                changed = {k: v for k, v in content.items() if k != name} | ({} if value is None else {name: value})
                scipy.io.savemat(path, changed)
                continue
            path.write_bytes(sound.read_bytes())
            with h5py.File(path, "r+") as file:
                del file[name]
                if value is not None:
                    file[name] = value


def read_all(folder, n_files):
    """Outcome of every file, from a child process."""
    child = subprocess.run(
        [sys.executable, str(Path(__file__).with_name("read_all.py")), str(folder)],
        capture_output=True,
        text=True,
        timeout=60 + SECONDS_PER_FILE * n_files,
        check=False,
    )
    outcomes = {}
    for line in child.stdout.splitlines():
        outcome = json.loads(line)
        outcomes[outcome.pop("file")] = outcome
    at = next((name for name, outcome in outcomes.items() if outcome.get("begun")), None)
    assert child.returncode == 0, f"{at}: {child.stderr[-2000:]}"
    return outcomes


def check_outcomes(folder, outcomes):
    for name, outcome in outcomes.items():
        if "error" in outcome:
            assert outcome["error"].startswith(f"{folder / name}: "), outcome["error"]
            assert "\n" not in outcome["error"]
            assert len(outcome["error"]) < 1000


def damage(kind, folder, n_files, rng):
    """Write `n_files` damaged files of a kind, and the sound one."""
    (folder / "sound").mkdir(exist_ok=True)
    sound = folder / "sound" / kind
    write_sound(kind, sound, rng)
    damaged = folder / "damaged"
    damaged.mkdir(exist_ok=True)
    (damaged / f"{kind}-sound").write_bytes(sound.read_bytes())
    for number in range(n_files):
        name = list(DAMAGES)[number % len(DAMAGES)]
        (damaged / f"{kind}-{name}-{number:04d}").write_bytes(DAMAGES[name](sound.read_bytes(), rng))
    return sound, damaged


def check_cuts(kind, outcomes):
    """A cut file is refused, or was cut behind all that is read."""
    sound = outcomes[f"{kind}-sound"]["values"]
    for name, outcome in outcomes.items():
        if name.startswith(f"{kind}-cut"):
            assert "error" in outcome or np.array_equal(outcome["values"], sound, equal_nan=True), name


def test_a_few_damaged_files_of_every_format_give_one_line(tmp_path, rng):
    for kind in KINDS:
        _, damaged = damage(kind, tmp_path, 12, rng)
    outcomes = read_all(damaged, 13 * len(KINDS))
    assert len(outcomes) == 13 * len(KINDS)
    check_outcomes(damaged, outcomes)
    for kind in KINDS:
        check_cuts(kind, outcomes)


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_damaged_files_give_one_line(tmp_path, rng, kind):
    sound, damaged = damage(kind, tmp_path, 400, rng)
    write_changed_variables(kind, sound, damaged)
    n_files = len(list(damaged.iterdir()))
    assert n_files > 400
    outcomes = read_all(damaged, n_files)
    assert len(outcomes) == n_files
    check_outcomes(damaged, outcomes)
    check_cuts(kind, outcomes)


def damage_stores(folder, n_stores, rng):
    """Zarr stores of one echogram, each with one of its files damaged or gone; and the sound one."""
    sound = folder / "echogram-zarr-sound"
    formats.opr_dataset(formats.truth(rng, n_bins=40, n_lines=12)).to_zarr(sound)
    files = [path.relative_to(sound) for path in sorted(sound.rglob("*")) if path.is_file()]
    for number in range(n_stores):
        store = folder / f"echogram-zarr-{number:04d}"
        shutil.copytree(sound, store)
        file = store / files[rng.integers(len(files))]
        damages = [*DAMAGES.values(), None]
        damage_file = damages[number % len(damages)]
        if damage_file is None:
            file.unlink()
        else:
            file.write_bytes(damage_file(file.read_bytes(), rng))
    return n_stores + 1


def check_stores(folder, n_stores, rng):
    n_stores = damage_stores(folder, n_stores, rng)
    outcomes = read_all(folder, n_stores)
    assert len(outcomes) == n_stores
    check_outcomes(folder, outcomes)
    assert sum("error" in outcome for outcome in outcomes.values()) > n_stores / 10


def test_a_few_damaged_stores_give_one_line(tmp_path, rng):
    check_stores(tmp_path, 20, rng)


@pytest.mark.slow
def test_damaged_stores_give_one_line(tmp_path, rng):
    check_stores(tmp_path, 300, rng)


@pytest.mark.parametrize(
    ("kind", "variable"),
    [
        ("echogram-nsidc", "amplitude"),
        ("echogram-mat5", "Data"),
        ("echogram-mat73", "Data"),
        ("echogram-opr", "Data"),
        ("layers-mat5", "twtt"),
        ("layers-mat73", "twtt"),
        ("layers-opr", "twtt"),
    ],
)
def test_a_flipped_payload_bit_changes_at_most_its_own_value(tmp_path, rng, kind, variable):
    sound, damaged = damage(kind, tmp_path, 0, rng)
    start, length = payload(sound, variable)
    for number in range(40):
        content = bytearray(sound.read_bytes())
        content[start + rng.integers(length)] ^= 1 << rng.integers(8)
        (damaged / f"{kind}-bit-{number:02d}").write_bytes(content)
    outcomes = read_all(damaged, 41)
    check_outcomes(damaged, outcomes)
    expected = np.array(outcomes.pop(f"{kind}-sound")["values"])
    n_read = n_changed = 0
    for outcome in outcomes.values():
        if "values" in outcome:
            values = np.array(outcome["values"])
            n_different = ((values != expected) & ~(np.isnan(values) & np.isnan(expected))).sum()
            assert n_different <= 1
            n_changed += n_different
            n_read += 1
    # Sign and exponent bits can make a value impossible; most bits are of the mantissa.
    assert n_read > 10
    assert n_changed > 0.5 * n_read  # the last bits of decibels can be lost on the way to power


def payload(path, variable):
    """Where the numbers of a variable lie in a file, and how many bytes they take."""
    if path.read_bytes()[:10] == b"MATLAB 5.0":
        values = scipy.io.loadmat(path)[variable]
        stored = values.astype(values.dtype, order="F").tobytes(order="F")
        start = path.read_bytes().index(stored)
        return start, len(stored)
    with h5py.File(path) as file:
        node = file[variable]
        return node.id.get_offset(), node.id.get_storage_size()
