"""A run that cannot end well stops early, in one line that says why."""

import os
import subprocess
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace

import pytest
from job import available_memory_mb, job
from runs import run_snakemake


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


def lines_with(done, text):
    return [line for line in (done.stdout + done.stderr).splitlines() if line.startswith(text)]


@pytest.mark.crash
def test_a_run_too_large_for_the_disk_does_not_start(tmp_path):
    with small_disk(tmp_path / "results", 3000):
        done = run_snakemake(tmp_path, "--", "results/flight/0000.nc")
        assert list((tmp_path / "results").rglob("*.nc")) == []
    assert done.returncode != 0
    (line,) = lines_with(done, "disk: ")
    assert "this run writes about" in line
    assert "3 MB left" in line


@pytest.mark.crash
def test_a_disk_that_fills_up_ends_the_job_in_one_line_and_leaves_nothing(tmp_path):
    with small_disk(tmp_path / "results", 1300):
        # Without the check before the first job: another program may fill the disk during the run.
        done = run_snakemake(tmp_path, "--no-hooks", "--", "results/flight/0000.nc")
        assert [path.name for path in (tmp_path / "results").rglob("*.nc")] == []
    assert done.returncode != 0
    (line,) = lines_with(done, "error: ")
    assert line.startswith("error: reference_frames_0000: results/flight/0000.nc: cannot be written, the disk is full")
    log = (tmp_path / "logs/reference_frames/0000.log").read_text().strip()
    assert log.splitlines()[-1].endswith(line.removeprefix("error: reference_frames_0000: "))


@pytest.mark.crash
def test_a_read_only_result_folder_is_named_in_one_line(tmp_path):
    with small_disk(tmp_path / "results", 3000, read_only=True):
        done = run_snakemake(tmp_path, "--", "results/flight/0000.nc")
    assert done.returncode != 0
    (line,) = lines_with(done, "disk: ")
    assert line == f"disk: results/ cannot be written: {tmp_path}/results is read-only"


def fake_job(folder, mem_mb=0):
    return SimpleNamespace(
        rule="some_rule", log=folder / "logs/some.log", output=[folder / "a.nc"], resources={"mem_mb": mem_mb}
    )


def test_a_job_that_needs_more_memory_than_there_is_does_not_start(tmp_path, capsys):
    if available_memory_mb() is None:
        pytest.skip("this system does not say how much memory is available")
    with pytest.raises(SystemExit), job(fake_job(tmp_path, mem_mb=10**9)):
        pytest.fail("the job started")
    assert capsys.readouterr().err.startswith(
        "error: some_rule: memory: expected at least 1000000000 MB available, got "
    )


def test_available_memory_lies_between_nothing_and_what_the_machine_has():
    if available_memory_mb() is None:
        pytest.skip("this system does not say how much memory is available")
    installed_mb = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**20
    assert 0 < available_memory_mb() < installed_mb


@pytest.mark.parametrize("error", [ValueError, OSError, ZeroDivisionError])
def test_a_log_ends_with_the_error(tmp_path, error):
    reason = "a.nc: expected this, got that"
    with pytest.raises((SystemExit, error)), job(fake_job(tmp_path)):
        raise error(reason)
    log = (tmp_path / "logs/some.log").read_text().strip()
    assert "Traceback" in log
    assert log.splitlines()[-1].endswith(reason)


def test_every_rule_with_a_script_logs_measures_and_asks_for_memory(rules):
    for rule in rules:
        if rule.script:
            assert len(rule.declared.log) == 1, rule.name
            assert rule.declared.benchmark, rule.name
            assert rule.declared.conda_env, rule.name
            assert rule.declared.message, rule.name
            assert "mem_mb" in dict(rule.declared.resources.items()), rule.name


def test_every_script_runs_inside_its_job():
    for script in (Path(__file__).resolve().parents[2] / "workflow/scripts").glob("*.py"):
        if script.name != "job.py":  # what scripts share
            body = script.read_text().split('if __name__ == "__main__":\n')[1]
            assert body.startswith("    with job(snakemake)"), script.name
