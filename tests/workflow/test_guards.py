"""A run or job that cannot end well stops early, says why in one line and leaves nothing behind."""

import shutil
import subprocess
from contextlib import contextmanager

import pytest
from refusals import refusal
from runs import lines_with, run_snakemake

from lib.checks import check_disk, check_folders, warn_of_left_over
from lib.sources import check_tracker


def test_a_run_that_the_disk_has_no_room_for_is_refused(tmp_path):
    check_disk(1, tmp_path / "results")
    message = rf"^disk: this run writes about 10{{10}}20 MB, {tmp_path} has \d+ MB left$"
    with refusal(message):
        check_disk(1e12, tmp_path / "results")


def test_a_folder_is_checked_by_the_first_that_is_there(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    check_folders("results/a/b", "logs")
    monkeypatch.setattr("os.access", lambda folder, mode: folder != tmp_path)
    message = rf"^disk: logs/ cannot be written: {tmp_path} is read-only$"
    with refusal(message):
        check_folders("logs")


def test_a_tracker_that_the_package_does_not_have_is_named():
    check_tracker("universal")
    check_tracker("mine.onnx")
    with refusal("config: import.tracker: expected universal, or a file NAME.onnx, got univrsal"):
        check_tracker("univrsal")


def test_scenes_that_the_configuration_no_longer_has_are_named(tmp_path, caplog):
    for name in (
        "labels/0000.nc",
        "phy/labels/0000.nc",
        "phy/labels/0001.nc",
        "own/a/test/0001.nc",
    ):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    warn_of_left_over(tmp_path, {"labels": ["0000", "0001"], "test": ["0000", "0001"]})
    assert caplog.text == ""
    warn_of_left_over(tmp_path, {"labels": ["0000"], "test": ["0000"]})
    assert f"{tmp_path}/phy/labels/0001.nc, one of 2 files of scenes" in caplog.text


@contextmanager
def small_disk(folder, kilobytes):
    """A disk of a few kilobytes mounted on a folder."""
    folder.mkdir(parents=True)
    options = f"size={kilobytes}k"
    mounted = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", options, "tmpfs", folder], check=False, capture_output=True
    )
    if mounted.returncode != 0:
        pytest.skip(f"cannot mount a small disk: {mounted.stderr.decode().strip()}")
    try:
        yield
    finally:
        subprocess.run(["umount", folder], check=True)


@pytest.mark.crash
def test_a_disk_that_fills_up_ends_the_job_in_one_line_and_leaves_nothing(tmp_path):
    with small_disk(tmp_path / "results", 1300):
        # Without the check before the first job: another program may fill the disk during the run.
        done = run_snakemake(tmp_path, "--no-hooks", "--", "results/flight/0000.nc", fails=True)
        assert [path.name for path in (tmp_path / "results").rglob("*.nc")] == []
    (line,) = lines_with(done, "error: ")
    assert line.startswith(
        "error: reference_frames_0000: results/flight/0000.nc: cannot be written, the disk is full"
    )
    log = (tmp_path / "logs/reference_frames/0000.log").read_text().strip()
    assert log.splitlines()[-1].endswith(line.removeprefix("error: reference_frames_0000: "))


def test_a_truncated_frame_is_named_in_one_line_and_no_summary_is_left(tiny_run, tmp_path):
    shutil.copytree(tiny_run / "results/flight", tmp_path / "results/flight")
    path = tmp_path / "results/flight/0001.nc"  # the second of the first shard
    path.write_bytes(path.read_bytes()[:20_000])
    target = "results/statistics/0000.nc"
    arguments = ("--rerun-triggers", "mtime", "--quiet", "--", target)
    done = run_snakemake(tmp_path, *arguments, fails=True)
    assert not (tmp_path / target).exists()
    (line,) = lines_with(done, "error: ")
    assert "results/flight/0001.nc: expected" in line
