"""Runs of `snowsim track` that are stopped again and again end as if they never had been."""

import os
import random
import signal
import subprocess
import sys

import formats
import psutil
import pytest
from planted_layers import content_of, planted, ridge_weights, write_weights
from runs import wait_until

N_SEGMENTS = 12
N_FRAMES = 2
N_STOPS = 8


@pytest.fixture
def command(tmp_path, rng):
    """Words of a command that tracks several segments."""
    echogram, _ = planted(rng, n_lines=300 * N_FRAMES)
    paths = []
    for segment in range(N_SEGMENTS):
        for frame in range(N_FRAMES):
            lines = slice(300 * frame, 300 * frame + 300)
            paths.append(tmp_path / f"Data_20120330_{segment + 1:02d}_{frame + 1:03d}.mat")
            formats.write_mat5(paths[-1], content_of(echogram, lines))
    tracker = write_weights(tmp_path, ridge_weights())
    program = "import sys; from snowsim.cli import main; main(sys.argv[1:])"
    return [sys.executable, "-c", program, "track", *paths, "--model", tracker]


def contents(folder):
    return {
        path.relative_to(folder): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file() and not path.name.startswith(".")
    }


def has_ended(process):
    """Whether a process has ended, also where nobody has asked yet how."""
    try:
        return process.status() == psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return True


@pytest.mark.crash
@pytest.mark.parametrize("processes", [1, 2])
def test_stops_at_any_time_leave_the_files_of_a_run_that_was_left_alone(
    command, tmp_path, processes
):
    whole = tmp_path / "whole"
    subprocess.run([*command, "-o", whole], check=True, stdout=subprocess.DEVNULL)
    expected = contents(whole)
    out = tmp_path / "out"
    words = [*command, "-o", out, "--resume", "-j", str(processes)]
    moments = random.Random(20120330)
    n_segments = []
    for number in range(N_STOPS):
        with subprocess.Popen(
            words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True
        ) as run:
            before = len(list(out.glob("*_layers.nc")))
            goes_on = wait_until(
                lambda n=before, run=run: (
                    run.poll() is not None or len(list(out.glob("*_layers.nc"))) > n
                ),
                seconds=120,
            )
            assert goes_on
            try:
                # The first stop comes at once, while most segments are left.
                run.wait(timeout=moments.uniform(0, 0.5) if number else 0)
            except subprocess.TimeoutExpired:
                children = psutil.Process(run.pid).children()
                stop = (signal.SIGKILL, signal.SIGINT)[number % 2]
                os.kill(run.pid, stop)
                _, errors = run.communicate()
                # The negative of the signal: it came when the command had ended and Python had not.
                assert run.returncode in (0, 130, -stop)
                if run.returncode == 130:
                    assert errors.decode().split("\n") == ["", "error: interrupted", ""]
                assert wait_until(lambda these=children: all(map(has_ended, these)), 30)
        n_segments.append(len(list(out.glob("*_layers.nc"))))
    subprocess.run(words, check=True, stdout=subprocess.DEVNULL)
    assert n_segments[0] < N_SEGMENTS
    assert contents(out) == expected
