"""Bad files stop the job that meets them, in one line, and leave nothing behind."""

import shutil

import numpy as np
import pytest
import xarray as xr
from runs import lines_with, run_snakemake


@pytest.fixture
def broken_run(tiny_run, tmp_path):
    """A copy of the finished run's flight, for a test to break."""
    shutil.copytree(tiny_run / "results/flight", tmp_path / "results/flight")
    return tmp_path


def error_from_the_flight(folder, target):
    """The one line of error when a target is made from the flight as it lies there, however old or broken."""
    done = run_snakemake(folder, "--rerun-triggers", "mtime", "--quiet", "--", target, fails=True)
    assert not (folder / target).exists()
    (line,) = lines_with(done, "error: ")
    return line


def test_a_truncated_frame_is_named_and_no_summary_is_left(broken_run):
    path = broken_run / "results/flight/0001.nc"  # the second of the first lot
    path.write_bytes(path.read_bytes()[:20_000])
    line = error_from_the_flight(broken_run, "results/statistics/0000.nc")
    assert "results/flight/0001.nc: expected" in line


def test_a_flight_without_layers_is_refused_in_one_line(broken_run):
    for path in sorted((broken_run / "results/flight").glob("*_layers.nc")):
        layers = xr.load_dataset(path)
        layers["twtt"][:] = np.nan
        layers.to_netcdf(path)
    line = error_from_the_flight(broken_run, "results/statistics.nc")
    assert "a flight needs layers, none of its 3 frames" in line
