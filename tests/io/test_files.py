import errno

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from formats import refused
from pandas.testing import assert_frame_equal

from snowsim.io.files import read_dataset, read_table, write_dataset, write_table, written_whole


def test_a_file_appears_only_when_it_is_whole(tmp_path):
    path = tmp_path / "deep" / "a.txt"
    with written_whole(path) as aside:
        aside.write_text("half")
        assert not path.exists()
    assert path.read_text() == "half"
    assert list(path.parent.iterdir()) == [path]


def test_a_writer_that_fails_leaves_the_old_file(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("old")

    def fail():
        with written_whole(path) as aside:
            aside.write_text("new")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fail()
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_what_a_killed_process_wrote_aside_of_the_same_file_is_removed(tmp_path):
    left, others = [".a.12.part.nc", ".a.345.part.nc"], [".ab.12.part.nc", ".a.12.part.csv"]
    for name in left + others:
        (tmp_path / name).touch()
    with written_whole(tmp_path / "a.nc") as aside:
        aside.write_text("whole")
    assert {path.name for path in tmp_path.iterdir()} == {"a.nc", *others}


def test_a_full_disk_is_named_by_its_own_error(tmp_path):
    with pytest.raises(OSError, match=r"a\.nc: cannot be written, the disk is full"), written_whole(tmp_path / "a.nc"):
        raise OSError(errno.ENOSPC, "No space left on device")


@pytest.mark.parametrize("ending", [".csv", ".parquet"])
def test_a_table_comes_back_and_repeats_to_the_byte(tmp_path, rng, ending):
    table = pd.DataFrame({"scene": ["a", "b"], "n": [1, 2], "value": rng.random(2).round(9)})
    paths = [tmp_path / f"{name}{ending}" for name in "xy"]
    for path in paths:
        write_table(path, table)
    assert_frame_equal(read_table(paths[0]), table, check_dtype=False)
    assert paths[0].read_bytes() == paths[1].read_bytes()


def test_a_dataset_comes_back_bit_by_bit(tmp_path, rng):
    dataset = xr.Dataset({"x": ("line", np.append(rng.random(4), np.nan).astype("f4"))}, attrs={"n_looks": 5})
    write_dataset(tmp_path / "a.nc", dataset)
    xr.testing.assert_identical(read_dataset(tmp_path / "a.nc"), dataset)


def test_a_truncated_dataset_is_refused_by_name(path, rng):
    write_dataset(path, xr.Dataset({"x": ("line", rng.random(10_000))}))
    path.write_bytes(path.read_bytes()[:5_000])
    refused(read_dataset, path, "expected a NetCDF-4 file")
