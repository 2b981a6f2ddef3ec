"""Two results folders are equal where every value is, under the names it has now."""

import numpy as np
import pandas as pd
import pytest
import reproducible
import xarray as xr

SVG = '<svg><metadata><date>{date}</date></metadata><path d="M 1 {y}"/><text>bins</text></svg>'


def write_zones(path, mean, name="mean"):
    pd.DataFrame({"zone": ["low", None], name: [mean, np.nan]}).to_csv(path, index=False)


@pytest.fixture
def folders(tmp_path):
    for name in ("old", "new"):
        folder = tmp_path / name
        (folder / "tables").mkdir(parents=True)
        write_zones(folder / "tables/zones.csv", 1.0)
        (folder / "lines.svg").write_text(SVG.format(date=name, y=2))
        xr.Dataset({"power": ("layer", [0.5, np.nan])}).to_netcdf(folder / "statistics.nc")
    return tmp_path / "old", tmp_path / "new"


def test_dates_and_missing_values_are_no_difference(folders):
    assert reproducible.compare(*folders) == []


def test_every_value_that_moved_is_named_with_its_size(folders):
    old, new = folders
    write_zones(new / "tables/zones.csv", 1.25)
    (new / "lines.svg").write_text(SVG.format(date="new", y=3))
    (new / "statistics.nc").unlink()
    (new / "extra.csv").write_text("a\n1\n")
    assert reproducible.compare(old, new) == [
        f"extra.csv: only in {new}",
        "lines.svg: drawn: differs by up to inf",
        "statistics.nc: missing",
        "tables/zones.csv: mean: differs by up to 0.25",
    ]


def test_moved_files_columns_and_small_differences_are_followed(folders, monkeypatch):
    old, new = folders
    (new / "tables/zones.csv").unlink()
    write_zones(new / "tables/by_zone.csv", 1 + 1e-13, name="average")
    assert len(reproducible.compare(old, new)) == 2
    monkeypatch.setitem(reproducible.MOVED_FILES, "tables/zones.csv", "tables/by_zone.csv")
    monkeypatch.setitem(reproducible.MOVED_COLUMNS, "tables/by_zone.csv", {"mean": "average"})
    monkeypatch.setitem(reproducible.ALLOWED, "tables/by_zone.csv: average", 5e-13)
    assert reproducible.compare(old, new) == []
