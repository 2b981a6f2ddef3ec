"""A finished run of the tiny configuration, made once for all tests."""

import pytest
from runs import run_snakemake


@pytest.fixture(scope="session")
def tiny_run(tmp_path_factory):
    """Folder of a finished run of the tiny configuration on two cores."""
    folder = tmp_path_factory.mktemp("tiny_run")
    done = run_snakemake(folder)
    assert done.returncode == 0, done.stderr[-4000:]
    return folder
