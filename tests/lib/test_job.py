"""The log of a job has its warnings and ends with the error; bad input is one line."""

import warnings
from types import SimpleNamespace

import numpy as np
import pytest
from job import job


def some_job(folder, mem_mb=0):
    return SimpleNamespace(
        rule="some_rule", log=folder / "logs/some.log", resources={"mem_mb": mem_mb}
    )


def test_a_job_that_needs_more_memory_than_there_is_does_not_start(tmp_path, capsys):
    with pytest.raises(SystemExit), job(some_job(tmp_path, mem_mb=10**9)):
        pytest.fail("the job started")
    printed = capsys.readouterr().err
    refusal = "error: some_rule: memory: expected at least 1000000000 MB available, got "
    assert printed.startswith(refusal)


@pytest.mark.parametrize("error", [ValueError, OSError, ZeroDivisionError])
def test_a_log_ends_with_the_error(tmp_path, error):
    reason = "a.nc: expected this, got that"
    with pytest.raises((SystemExit, error)), job(some_job(tmp_path)):
        raise error(reason)
    log = (tmp_path / "logs/some.log").read_text().strip()
    assert "Traceback" in log
    assert log.splitlines()[-1].endswith(reason)


def test_warnings_of_a_job_are_lines_of_its_log_and_of_the_console(tmp_path, capsys):
    with warnings.catch_warnings():
        # As in a process of a job: pytest makes warnings errors.
        warnings.simplefilter("default")
        with job(some_job(tmp_path)):
            for layer in range(3):
                warnings.warn(f"layer {layer}:\ntoo few samples", UserWarning, stacklevel=1)
            np.log(np.zeros(1))
    expected = [
        *(f"layer {layer}: too few samples" for layer in range(3)),
        "RuntimeWarning: divide by zero encountered in log",
    ]
    *logged, done = (tmp_path / "logs/some.log").read_text().splitlines()
    assert [line.partition(" warning: ")[2] for line in logged] == expected
    printed = capsys.readouterr().err.splitlines()
    assert printed == [f"warning: some_rule: {line}" for line in expected]
