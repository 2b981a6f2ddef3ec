"""A run or job that cannot end well stops early, says why in one line and leaves nothing behind."""

import shutil
import subprocess
from contextlib import contextmanager

import numpy as np
import pytest
import xarray as xr
from refusals import refusal
from runs import lines_with, run_snakemake

from lib.checks import check_disk, check_folders


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


@pytest.fixture
def broken_run(tiny_run, tmp_path):
    """A copy of the finished run's flight, for a test to break."""
    shutil.copytree(tiny_run / "results/flight", tmp_path / "results/flight")
    return tmp_path


def error_from_the_flight(folder, target):
    """The one line of error when a target is made from the flight as it lies there."""
    done = run_snakemake(folder, "--rerun-triggers", "mtime", "--quiet", "--", target, fails=True)
    assert not (folder / target).exists()
    (line,) = lines_with(done, "error: ")
    return line


def test_a_truncated_frame_is_named_and_no_summary_is_left(broken_run):
    path = broken_run / "results/flight/0001.nc"  # the second of the first shard
    path.write_bytes(path.read_bytes()[:20_000])
    line = error_from_the_flight(broken_run, "results/statistics/0000.nc")
    assert "results/flight/0001.nc: expected" in line


def test_a_flight_without_layers_is_refused_in_one_line(broken_run):
    for path in sorted((broken_run / "results/flight").glob("*_layers.nc")):
        layers = xr.load_dataset(path)
        layers["twtt"][:] = np.nan
        layers.to_netcdf(path)
    line = error_from_the_flight(broken_run, "results/statistics.nc")
    assert "with the surface picked in 4 frames must be" in line
