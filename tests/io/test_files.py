"""Files the workflow writes appear whole, come back, repeat to the byte, and say what ails them."""

import errno
import os
import platform
import subprocess
import sys

import numpy as np
import pandas as pd
import pytest
from formats import refused
from numpy.testing import assert_allclose, assert_array_equal
from pandas.testing import assert_frame_equal
from safetensors.numpy import save_file

from snowsim import __version__
from snowsim.io import (
    SceneSet,
    fingerprint,
    read_model,
    read_table,
    write_model,
    write_scenes,
    write_table,
    written_whole,
)
from snowsim.io.files import locked


def test_a_writer_that_fails_leaves_the_old_file(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("old")

    def fail():
        with written_whole(path) as aside:
            aside.write_text("new")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fail()
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def name_aside(stem, process, ending):
    return f".{stem}.{platform.node()}.{process}.part.{ending}"


def test_what_dead_processes_wrote_aside_of_the_same_file_is_removed(tmp_path):
    # A process that ended and still has its number, and a number that no process has.
    dead = subprocess.Popen([sys.executable, "-c", ""])
    os.waitid(os.P_PID, dead.pid, os.WEXITED | os.WNOWAIT)
    left = [name_aside("a", dead.pid, "nc"), name_aside("a", 10**12, "nc")]
    others = [name_aside("ab", dead.pid, "nc"), name_aside("a", dead.pid, "csv")]
    others.append(f".a.another-computer.{dead.pid}.part.nc")
    for name in left + others:
        (tmp_path / name).touch()
    with written_whole(tmp_path / "a.nc") as aside:
        aside.write_text("whole")
    dead.wait()
    assert {path.name for path in tmp_path.iterdir()} == {"a.nc", *others}


def test_what_a_living_process_writes_aside_of_the_same_file_stays(tmp_path):
    code = (
        "import sys; from snowsim.io import written_whole\n"
        "with written_whole(sys.argv[1]) as aside:\n"
        "    aside.write_text('other'); print('begun', flush=True); input()"
    )
    arguments = [sys.executable, "-c", code, str(tmp_path / "a.nc")]
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
    with subprocess.Popen(arguments, **pipes) as other:
        assert other.stdout.readline() == "begun\n"
        with written_whole(tmp_path / "a.nc") as aside:
            aside.write_text("own")
        assert (tmp_path / "a.nc").read_text() == "own"
        other.communicate("\n")
    assert other.returncode == 0
    assert (tmp_path / "a.nc").read_text() == "other"


def test_a_locked_folder_keeps_other_processes_waiting(tmp_path):
    code = (
        "import sys; from pathlib import Path; from snowsim.io.files import locked\n"
        "print('begun', flush=True)\n"
        "with locked(sys.argv[1]):\n"
        "    print(Path(sys.argv[1], 'written').exists(), flush=True)"
    )
    arguments = [sys.executable, "-c", code, str(tmp_path)]
    with locked(tmp_path):
        other = subprocess.Popen(arguments, stdout=subprocess.PIPE, text=True)
        assert other.stdout.readline() == "begun\n"
        with pytest.raises(subprocess.TimeoutExpired):
            other.wait(0.5)
        (tmp_path / "written").touch()
    assert other.communicate()[0] == "True\n"


def test_a_full_disk_is_named_by_its_own_error(tmp_path):
    with (
        pytest.raises(OSError, match=r"a\.nc: cannot be written, the disk is full"),
        written_whole(tmp_path / "a.nc"),
    ):
        raise OSError(errno.ENOSPC, "No space left on device")


@pytest.mark.parametrize(("name", "digits"), [("a.csv", 9), ("a.csv.gz", 17)])
def test_a_table_comes_back(tmp_path, rng, name, digits):
    table = pd.DataFrame({"scene": ["a", "b"], "n": [1, 2], "value": rng.random(2).round(digits)})
    write_table(tmp_path / name, table)
    assert_frame_equal(read_table(tmp_path / name), table, check_dtype=False, check_exact=True)


def test_a_packed_table_has_the_same_bytes_wherever_and_whenever_it_is_written(
    tmp_path, monkeypatch
):
    table = pd.DataFrame({"scene": ["a", "b"]})
    write_table(tmp_path / "a.csv.gz", table)
    monkeypatch.setattr("time.time", lambda: 1e9)
    write_table(tmp_path / "b.csv.gz", table)
    assert (tmp_path / "a.csv.gz").read_bytes() == (tmp_path / "b.csv.gz").read_bytes()


def test_scenes_of_several_files_come_back_as_they_were(tmp_path, scenes):
    paths = [tmp_path / "a.nc", tmp_path / "b.nc"]
    write_scenes(paths[0], scenes[:2], {"synthetic": "yes"})
    write_scenes(paths[1], scenes[2:])
    with SceneSet(paths) as read:
        assert read.attributes["synthetic"] == "yes"
        for before, after in zip(scenes, read, strict=True):
            for name in ("name", "n_range_bins", "zone", "notes", "noise_floor_db", "maximum_db"):
                assert getattr(after, name) == getattr(before, name)
            assert_array_equal(before.image, after.image)
            # float32 keeps 24 bits: 3e-5 bins at bin 500
            assert_allclose(after.layer_bins, before.layer_bins, atol=5e-5)
            assert_allclose(after.complete_layer_bins, before.complete_layer_bins, atol=5e-5)


def test_no_scene_and_scenes_that_hold_different_things_are_refused(tmp_path, path, scenes):
    refused(lambda path: write_scenes(path, []), path, "at least one scene")
    assert list(tmp_path.iterdir()) == []
    scenes[1].image = None
    message = f"scene {scenes[1].name}: expected .*image.* as in"
    refused(lambda path: write_scenes(path, scenes), path, message)


ARRAYS = {
    "network": {
        "a.weight": np.arange(6, dtype=np.float32).reshape(2, 3),
        "a.bias": np.zeros(2, np.float32),
    },
    "adam": {0: {"step": np.float32(7), "exp_avg": np.ones((2, 3), np.float32)}},
}
METADATA = {"kind": "tracker", "settings": {"width": 8, "scales": (1.0, 0.5)}, "seed": 3, "step": 7}


@pytest.fixture
def model(tmp_path):
    write_model(tmp_path / "model.safetensors", ARRAYS, METADATA)
    return tmp_path / "model.safetensors"


def test_arrays_and_metadata_come_back(model):
    # What is expected is compared as JSON keeps it: tuples as lists.
    arrays, metadata = read_model(model, expected=METADATA)
    assert_array_equal(arrays["network"]["a.weight"], ARRAYS["network"]["a.weight"])
    assert arrays["adam"]["0"]["step"].shape == ()
    assert arrays["adam"]["0"]["step"] == 7
    assert metadata["version"] == __version__
    assert metadata["settings"] == {"width": 8, "scales": [1.0, 0.5]}


def test_the_same_model_gives_the_same_bytes_and_arrays_come_back_in_any_order(model, tmp_path):
    write_model(tmp_path / "again.safetensors", ARRAYS, dict(reversed(METADATA.items())))
    assert model.read_bytes() == (tmp_path / "again.safetensors").read_bytes()
    transposed = np.arange(6.0).reshape(2, 3).T
    write_model(model, {"a": transposed}, {})
    assert_array_equal(read_model(model)[0]["a"], transposed)


OTHER = {
    "settings: width: expected 16, found 8": {"settings": {"width": 16, "scales": [1.0, 0.5]}},
    "data: expected 'ab12', found None": {"data": "ab12"},
}


@pytest.mark.parametrize(("words", "expected"), OTHER.items())
def test_a_model_of_another_configuration_is_refused(model, expected, words):
    refused(lambda model: read_model(model, expected=expected), model, words)


@pytest.mark.parametrize("n_bytes", [0, 200, -1])
def test_a_truncated_model_and_another_safetensors_file_are_refused(model, n_bytes):
    model.write_bytes(model.read_bytes()[:n_bytes])
    refused(read_model, model, "expected a whole safetensors file")
    save_file({"a": np.zeros(2)}, model)
    refused(read_model, model, "expected one of format")


def test_the_fingerprint_depends_on_content_and_order_and_not_on_names(tmp_path):
    a, b, c = (tmp_path / name for name in "abc")
    for path, text in ((a, "1"), (b, "2"), (c, "1")):
        path.write_text(text)
    assert fingerprint([a, b]) == fingerprint([c, b]) != fingerprint([b, a])


def test_a_link_stays_and_the_file_that_it_leads_to_is_replaced(tmp_path):
    (tmp_path / "scratch").mkdir()
    link = tmp_path / "a.csv"
    link.symlink_to("scratch/b.csv")
    for text in ("first", "second"):  # the file is made, and then replaced
        with written_whole(link) as aside:
            aside.write_text(text)
        assert link.is_symlink()
        assert (tmp_path / "scratch/b.csv").read_text() == text
    assert len(list(tmp_path.rglob("*"))) == 3
