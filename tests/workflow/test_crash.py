"""A run that is killed again and again ends as if it never had been."""

import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import reproducible
from runs import command, environment, run_snakemake, source_tree, wait_until

N_KILLS = 20


def processes_in(folder):
    """Process ids that work in a folder."""
    found = []
    for entry in Path("/proc").glob("[0-9]*"):
        try:
            if Path(os.readlink(entry / "cwd")).is_relative_to(folder):
                found.append(int(entry.name))
        except OSError:
            continue  # it ended meanwhile
    return found


def live_and_die(folder, n_jobs, seconds, targets):
    """Start the run, kill its processes some seconds after some jobs; False if it ended before."""
    folder.mkdir(exist_ok=True)
    path = folder / "output.txt"

    def n_finished():
        return path.read_text().count("Finished jobid")

    with path.open("w") as output:
        process = subprocess.Popen(
            command(folder, "--", *targets),
            start_new_session=True,
            stdout=output,
            stderr=subprocess.STDOUT,
            cwd=source_tree(),
            env=environment(),
        )
        while process.poll() is None and n_finished() < n_jobs:
            time.sleep(0.05)
        try:
            process.wait(timeout=seconds)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
            return True
    assert process.returncode == 0, path.read_text()[-3000:]
    return False


@pytest.mark.crash
@pytest.mark.skipif(
    not Path("/proc/self/cwd").exists(), reason="needs /proc to see whether processes are left"
)
def test_twenty_kills_leave_the_results_of_a_run_that_was_left_alone(
    tiny_run, reproducible_targets, tmp_path
):
    expected = reproducible.digests(tiny_run / "results")
    moments = random.Random(20120429)
    n_killed = 0
    n_finished = 0
    # Lives are counted in jobs, not seconds, so that a slow machine gets on as well; should the run
    # end before it was killed often enough, it starts anew.
    while n_killed < N_KILLS or n_finished == 0:
        folder = tmp_path / f"run_{n_finished}"
        n_jobs = moments.randrange(7) if n_killed < N_KILLS else sys.maxsize
        if live_and_die(folder, n_jobs, moments.uniform(0, 5), reproducible_targets):
            n_killed += 1
            # The system takes some time to bury the dead.
            assert wait_until(lambda: not processes_in(tmp_path), seconds=30)
            run_snakemake(folder, "--unlock")
            continue
        n_finished += 1
        assert reproducible.digests(folder / "results") == expected
        assert [str(path) for path in folder.rglob("*.part*")] == []
        for kind in ("incomplete", "locks"):
            assert [str(path) for path in (folder / ".snakemake" / kind).glob("*")] == []
