"""Damaged files, and files made to harm, give one line: never a crash, a hang, another exception.

Truncated ones, and ones with flipped bits, are read in a child process under a limit of time and of
memory. Files without checksums cannot tell a flipped bit of a sample from data: there, at most the
values that were hit may differ. MAT v5 without compression is only cut: a flipped bit in its
structure may end Python within scipy.
"""

import json
import resource
import shutil
import struct
import subprocess
import sys
import zlib
from functools import partial
from pathlib import Path

import formats
import h5py
import netCDF4
import numpy as np
import pytest
from formats import refused

from snowsim.echogram import MAXIMUM_BYTES
from snowsim.io import (
    SceneSet,
    read_echogram,
    read_image,
    read_layers,
    read_profile,
    write_dataset,
    write_image,
    write_scenes,
)
from snowsim.io.containers import read_values
from snowsim.io.predictions import read_map

MOST_FLIPS = 8
# A file is called after its kind, which begins with what it holds.
READERS = {
    "echogram": lambda path: read_echogram(path)["Data"].values,
    "layers": lambda path: read_layers(path)["twtt"].values,
    "image": lambda path: read_image(path)[0],
}


def sound_files(rng):
    """Writer and content of a sound file of every kind, small: random bits often hit structure."""
    content = formats.truth(rng, n_bins=40, n_lines=12)
    gps_time, surface = content["GPS_time"], content["Surface"]
    twtt = np.array([surface, surface + 1e-8, surface + 2e-8])
    image = rng.integers(0, 256, (300, 10), dtype=np.uint8)
    echogram = content | {"param_records": {"season_name": "2012", "x": np.ones(3)}}
    layers = formats.layer_content(twtt, [1, 2, 3], gps_time)
    old_layers = formats.old_layer_content(twtt[:2], gps_time, ["surface", "Koenig_2"])
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
        "image-png": (partial(write_image, numbers={"maximum_db": 3.0}), image),
    }


KINDS = tuple(sound_files(np.random.default_rng(0)))
CUT_ONLY = ("echogram-mat5", "layers-mat5", "layers-old-mat5")


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
    lines = map(json.loads, child.stdout.splitlines())
    outcomes = {line["file"]: line for line in lines}
    at = next((name for name, outcome in outcomes.items() if outcome.get("begun")), None)
    assert child.returncode == 0, f"{at}: {child.stderr[-2000:]}"
    assert outcomes.keys() == names
    for name, outcome in outcomes.items():
        error = outcome.get("error", f"{folder / name}: ")
        assert error.startswith(f"{folder / name}: ")
        assert "\n" not in error
        assert len(error) < 1000
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
            if kind not in CUT_ONLY:
                (tmp_path / f"{kind}.flipped.{number:04d}").write_bytes(flipped(whole, rng))
    outcomes = outcomes_of(tmp_path)
    for name, outcome in outcomes.items():
        kind, damage, *_ = name.split(".")
        if "error" not in outcome:
            expected = np.array(outcomes[f"{kind}.sound"]["values"])
            same = np.isclose(outcome["values"], expected, rtol=0, atol=0, equal_nan=True)
            # A cut file is refused, or was cut behind all that is read.
            assert (~same).sum() <= (MOST_FLIPS if damage == "flipped" else 0), name


@pytest.mark.parametrize("n_stores", [20, pytest.param(300, marks=pytest.mark.slow)])
def test_damaged_stores_give_one_line(tmp_path, rng, n_stores):
    sound = tmp_path / "echogram-sound"
    frame = formats.opr_dataset(formats.truth(rng, n_bins=40, n_lines=12))
    frame.to_zarr(sound, consolidated=False)
    for number in range(n_stores):
        store = shutil.copytree(sound, tmp_path / f"echogram-zarr-{number:04d}")
        files = [path for path in sorted(store.rglob("*")) if path.is_file()]
        file = files[rng.integers(len(files))]
        file.write_bytes(flipped(file.read_bytes(), rng)[: rng.integers(1, 1000)])
    outcomes = outcomes_of(tmp_path)
    assert sum("error" in outcome for outcome in outcomes.values()) > n_stores / 10


def with_change(write, **changed):
    """Writer of a file with some variables changed."""
    return lambda path, content: write(path, content | changed)


def without_data(content):
    return {name: values for name, values in content.items() if name != "Data"}


def write_bomb(path, content):
    """Data of a MAT v5 file that say they inflate to 3 GB."""
    n_bytes = 3 * 2**30
    shape = struct.pack("<II2i", 5, 8, n_bytes // 8 // 1024, 1024)
    head = struct.pack("<IIII", 6, 8, 6, 0) + shape + struct.pack("<HH4s", 1, 4, b"Data")
    packed = zlib.compress(struct.pack("<II", 14, n_bytes) + head + bytes(2**24))
    formats.write_mat5(path, without_data(content))
    path.write_bytes(path.read_bytes() + struct.pack("<II", 15, len(packed)) + packed)


def write_huge_mat73(path, content):
    formats.write_mat73(path, without_data(content))
    with h5py.File(path, "r+") as file:
        file.create_dataset("Data", shape=(10**6, 10**6), dtype="f4", chunks=(1000, 1000))


def write_code(path, content):
    """A function handle for power."""
    formats.write_mat73(path, without_data(content))
    with h5py.File(path, "r+") as file:
        file.create_group("Data/function_handle")


def write_circle(path, content):
    """References that followed to the end would never end."""
    with h5py.File(path, "w", userblock_size=512) as file:
        for name in ("layerData", "b"):
            file.create_dataset(name, (1000, 1), dtype=h5py.ref_dtype)
        file["layerData"][...] = file["b"].ref
        file["b"][...] = file["layerData"].ref
        file["GPS_time"] = np.zeros((3, 1))


def write_huge_netcdf(path, content):
    formats.write_nsidc(path, content | {"Data": np.ones((120, 40))})
    with netCDF4.Dataset(path, "r+") as file:
        file.createDimension("huge", 10**9)
        file.createVariable("huge", "f8", ("huge",), zlib=True)


def write_endless_heap(path, content):
    """A length that, rounded up to 8 and added to its header, comes to nothing in 64 bits."""
    formats.write_nsidc(path, content)
    make_heap_endless(path)


def make_heap_endless(path):
    whole = path.read_bytes()
    length_at = whole.index(b"GCOL") + 24
    path.write_bytes(whole[:length_at] + struct.pack("<q", -16) + whole[length_at + 8 :])


TOO_LARGE = f"expected at most {MAXIMUM_BYTES} bytes, found"
NO_NUMBERS = "Elevation: expected real numbers"
NO_DATA = "content: expected MAT v5, MAT v7.3, NetCDF or Zarr, found"
# What is downloaded in place of data.
NO_DATA_BUT = {
    b"\n<!DOCTYPE HTML PUBLIC>\n<title>Earthdata Login</title>": "a web page: is a login needed",
    b"<html lang='en'>" + bytes(600): "a web page",
    b"version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12\n": "a git-LFS pointer",
    b"\xff\xd8\xff\xe0" + bytes(600): "a JPEG image",
    b"\x89PNG\r\n\x1a\n" + bytes(600): "a PNG image",
    b"%PDF-1.4" + bytes(600): "a PDF document",
    b"\x1f\x8b\x08" + bytes(600): "a packed file",
    b"CDF\x05" + bytes(600): r"NetCDF classic of 64-bit data, CDF-5 \(nccopy -k nc4",
}
# What no numbers are, in place of elevations.
NOT_ELEVATIONS = ["text", {"a": np.ones(3)}, formats.cell("ab"), np.ones((2, 3, 4))]
# By format: files made to harm, the reader that meets them, and what it says.
HARMFUL = {
    "mat5": [
        (write_bomb, read_echogram, TOO_LARGE),
        (with_change(formats.write_mat5, Data=np.ones((120, 40)) * 1j), read_echogram, "imaginary"),
        *(
            (with_change(formats.write_mat5, Elevation=e), read_echogram, NO_NUMBERS)
            for e in NOT_ELEVATIONS
        ),
    ],
    "mat73": [
        (write_huge_mat73, read_echogram, TOO_LARGE),
        (write_code, read_echogram, "Data|MAT file"),
        (write_circle, read_layers, "RecursionError|expected at most"),
        *(
            (with_change(formats.write_mat73, Elevation=e), read_echogram, NO_NUMBERS)
            for e in NOT_ELEVATIONS
        ),
    ],
    "netcdf": [
        (write_huge_netcdf, read_echogram, TOO_LARGE),
        (write_endless_heap, read_echogram, "HDF5: expected heaps that hold their objects"),
    ],
    "none": [
        (lambda path, _: None, read_echogram, "expected .*, found .*No such file"),
        (lambda path, _: path.mkdir(), read_layers, f"{NO_DATA} a folder: name the files in it"),
        *(
            (lambda path, _, content=content: path.write_bytes(content), read_layers, NO_DATA)
            for content in (b"", b"\x89HDF\r\n\x1a\n", b"CDF\x01" + bytes(4), b"GIF89a")
        ),
        *(
            (
                lambda path, _, content=content: path.write_bytes(content),
                read_echogram,
                f"content: expected .*, found {words}",
            )
            for content, words in NO_DATA_BUT.items()
        ),
        (
            lambda path, _: path.write_bytes(b"MATLAB 5.0".ljust(124) + b"\x00\x01IM"),
            read_layers,
            "variables: expected those of an echogram",
        ),
    ],
}


@pytest.mark.parametrize(
    ("write", "read", "message"),
    [
        pytest.param(*harm, id=f"{form}-{number}")
        for form, harms in HARMFUL.items()
        for number, harm in enumerate(harms)
    ],
)
def test_files_made_to_harm_and_what_is_no_data_are_refused(path, content, write, read, message):
    write(path, content)
    refused(read, path, message)


@pytest.mark.parametrize(
    ("name", "read"),
    [("map.npy", read_map), ("map.png", read_map), ("core.csv", read_profile)],
)
def test_what_comes_in_place_of_data_is_named_by_every_reader(tmp_path, name, read):
    (tmp_path / name).write_bytes(next(iter(NO_DATA_BUT)))
    refused(read, tmp_path / name, "content: expected data, found a web page")


def test_function_handles_among_parameters_are_no_data(path, content, shared_data):
    formats.write_mat73(path, content)
    with h5py.File(path, "r+") as file:
        handle = file.create_group("param_records/radar/lever_arm_fh")
        handle.attrs["MATLAB_class"] = np.bytes_("function_handle")
    assert read_echogram(path)["Data"].shape == content["Data"].shape
    real = shared_data / "cresis_layers" / "20181030_01" / "Data_20181030_01_001.mat"
    assert read_values(real, ["param"])["param"]["day_seg"] == "20181030_01"


def test_scenes_of_a_file_that_lost_a_part_are_refused(path, scenes):
    write_scenes(path, scenes)
    with netCDF4.Dataset(path, "r+") as file:
        file.set_auto_mask(False)
        # As it reads where a flipped bit hides a part of the file.
        file["layer_bins"][2, 7] = netCDF4.default_fillvals["f4"]
    with SceneSet(path) as read:
        refused(lambda _: read[0], path, "layer_bins: expected numbers, found values that were nev")
        assert read[1].n_range_lines == 256
    make_heap_endless(path)
    refused(SceneSet, path, "HDF5: expected heaps that hold their objects")


def test_a_file_that_outlives_python_does_not_crash_at_its_end(tmp_path):
    path = tmp_path / "a.mat"
    formats.write_mat73(path, {"Data": np.zeros((3, 4))})
    held = f"open_container({str(path)!r})"
    code = f"""
import threading, time
from snowsim.io.containers import open_container
threading.Thread(target=lambda held: time.sleep(60), args=({held},), daemon=True).start()
"""
    command = [sys.executable, "-c", code]
    assert subprocess.run(command, timeout=60, check=False).returncode == 0


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
