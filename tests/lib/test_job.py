"""The log of a job ends with the error; bad input is one line."""

from types import SimpleNamespace

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
