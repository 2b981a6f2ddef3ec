"""A run that cannot end well stops early, in one line that says why."""

import subprocess
from contextlib import contextmanager

import pytest
from runs import lines_with, run_snakemake


@contextmanager
def small_disk(folder, kilobytes, read_only=False):
    """A disk of a few kilobytes mounted on a folder."""
    folder.mkdir(parents=True)
    options = f"size={kilobytes}k" + (",ro" if read_only else "")
    mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", options, "tmpfs", folder], check=False, capture_output=True)
    if mounted.returncode != 0:
        pytest.skip(f"cannot mount a small disk: {mounted.stderr.decode().strip()}")
    try:
        yield
    finally:
        subprocess.run(["umount", folder], check=True)


@pytest.mark.crash
def test_a_run_too_large_for_the_disk_does_not_start(tmp_path):
    with small_disk(tmp_path / "results", 3000):
        done = run_snakemake(tmp_path, "--", "results/flight/0000.nc", fails=True)
        assert list((tmp_path / "results").rglob("*.nc")) == []
    (line,) = lines_with(done, "disk: ")
    assert "this run writes about" in line
    assert "3 MB left" in line


@pytest.mark.crash
def test_a_disk_that_fills_up_ends_the_job_in_one_line_and_leaves_nothing(tmp_path):
    with small_disk(tmp_path / "results", 1300):
        # Without the check before the first job: another program may fill the disk during the run.
        done = run_snakemake(tmp_path, "--no-hooks", "--", "results/flight/0000.nc", fails=True)
        assert [path.name for path in (tmp_path / "results").rglob("*.nc")] == []
    (line,) = lines_with(done, "error: ")
    assert line.startswith("error: reference_frames_0000: results/flight/0000.nc: cannot be written, the disk is full")
    log = (tmp_path / "logs/reference_frames/0000.log").read_text().strip()
    assert log.splitlines()[-1].endswith(line.removeprefix("error: reference_frames_0000: "))


@pytest.mark.crash
def test_a_read_only_result_folder_is_named_in_one_line(tmp_path):
    with small_disk(tmp_path / "results", 3000, read_only=True):
        done = run_snakemake(tmp_path, "--", "results/flight/0000.nc", fails=True)
    (line,) = lines_with(done, "disk: ")
    assert line == f"disk: results/ cannot be written: {tmp_path}/results is read-only"


def test_every_rule_with_a_script_logs_measures_and_says_what_it_does(rules):
    for rule in rules:
        if rule.script:
            assert len(rule.declared.log) == 1, rule.name
            assert rule.declared.benchmark, rule.name
            assert rule.declared.conda_env, rule.name
            assert rule.declared.message, rule.name
