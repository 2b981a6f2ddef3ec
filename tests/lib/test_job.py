"""The log of a job ends with the error; bad input is one line."""

import os
from types import SimpleNamespace

import pytest
from job import job

from lib.progress import available_memory_mb


def some_job(folder, mem_mb=0):
    return SimpleNamespace(
        rule="some_rule", log=folder / "logs/some.log", resources={"mem_mb": mem_mb}
    )


@pytest.mark.skipif(
    available_memory_mb() is None, reason="this system does not say how much memory is available"
)
def test_a_job_that_needs_more_memory_than_there_is_does_not_start(tmp_path, capsys):
    installed_mb = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**20
    assert 0 < available_memory_mb() < installed_mb
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
