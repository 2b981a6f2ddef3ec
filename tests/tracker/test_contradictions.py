"""Name, times and positions that contradict one another: one note each, in `info` and `track`."""

import re

import formats
import numpy as np
import pytest
from numpy.testing import assert_allclose
from planted_layers import content_of

from snowsim.alignment import contradictions
from snowsim.cli import main
from snowsim.io import read_echogram, read_layers
from snowsim.tracking import track_files

RADIANS = np.pi / 180


def dataset(frame):
    return formats.opr_dataset(content_of(frame))


def in_radians(frame):
    names = ("Latitude", "Longitude")
    return frame.assign({name: frame[name] * RADIANS for name in names})


def on_one_spot(frame):
    return frame.assign(Latitude=71 + 0 * frame["Latitude"], Longitude=-44 + 0 * frame["Longitude"])


def far_apart(frame):
    return frame.assign(
        Latitude=60 + 0.02 * np.arange(frame.sizes["slow_time"]) + 0 * frame.Latitude
    )


def with_a_jump(frame):
    frame["Longitude"][100] += 7
    return frame


def too_fast(frame):
    first = frame["slow_time"].values[0]
    return frame.assign_coords(slow_time=first + (frame["slow_time"].values - first) // 50)


# By kind: name of the file, what is changed, and the note.
CONTRADICTIONS = {
    "ten years": (
        "Data_20220402_03_007",
        lambda frame: frame,
        "the name says 2022-04-02, but slow_time begins on 2012-03-30: is it counted from another",
    ),
    "radians": ("mine", in_radians, "found 1.2217, -0.69813: are they radians"),
    "one spot": ("mine", on_one_spot, "all range lines lie within 0 m: expected lines along"),
    "kilometres": (
        "mine",
        far_apart,
        "299 of 299 steps from range line to range line are longer than 1 km, up to 2.224 km",
    ),
    "a jump": ("mine", with_a_jump, "2 of 299 steps from range line to range line .* up to 266"),
    "speed": ("mine", too_fast, "5.2 m and 0.000874 s apart mean 5950 m/s: expected less than 350"),
}


@pytest.mark.parametrize(("name", "change", "note"), CONTRADICTIONS.values(), ids=CONTRADICTIONS)
def test_each_contradiction_is_one_note_of_info_and_of_track(
    tmp_path, weights, frame, capsys, name, change, note
):
    path = tmp_path / f"{name}.nc"
    change(dataset(frame[0])).to_netcdf(path)
    (found,) = contradictions(read_echogram(path), path)
    assert re.search(note, found)
    assert "; " not in found  # which joins the notes of a file
    main(["info", str(path)])
    assert capsys.readouterr().out.count(f"note    {found}\n") == 1
    lines = []
    track_files([path], tmp_path / "out", model=str(weights), say=lines.append)
    assert lines.count(f"{path}: {found}") == 1
    (written,) = (tmp_path / "out").glob("*_layers.nc")
    notes = read_layers(written).attrs["notes"]
    assert notes.split("; ").count(f"{name}: {found}") == 1


@pytest.mark.parametrize(
    "name", ["Data_20120330_04_001", "Data_20120329_09_044", "Data_20129930_04_001"]
)
def test_a_flight_past_midnight_and_a_name_without_a_date_contradict_nothing(frame, name):
    assert contradictions(dataset(frame[0]), f"{name}.mat") == []


def test_a_day_in_the_name_of_the_granule_counts_where_the_file_has_none(frame):
    renamed = dataset(frame[0]).assign_attrs(granule="20140330_04_001")
    assert "the name says 2014-03-30" in contradictions(renamed, "renamed.nc")[0]


def test_times_and_positions_that_were_made_up_or_are_missing_contradict_nothing(frame):
    echogram = dataset(frame[0])
    n_lines = echogram.sizes["slow_time"]
    invented = np.datetime64("2000-01-01", "ns") + np.arange(n_lines) * np.timedelta64(1, "ms")
    made_up = echogram.assign_coords(slow_time=invented)
    assert contradictions(made_up, "Data_20120330_04_001.png") == []
    assert contradictions(echogram.assign(Latitude=np.nan * echogram["Latitude"])) == []
    assert contradictions(echogram.isel(slow_time=[3])) == []


@pytest.mark.parametrize("units", ["radian", "Radians", "rad"])
@pytest.mark.parametrize("write", ["opr", "nsidc", "zarr"])
def test_positions_of_which_a_file_says_radians_become_degrees(tmp_path, frame, write, units):
    path = tmp_path / "frame"
    echogram = dataset(frame[0])
    expected = echogram[["Latitude", "Longitude"]]
    turned = in_radians(echogram)
    for name in expected:
        turned[name].attrs["units"] = units
    if write == "nsidc":
        named = {
            "Data": "amplitude",
            "Latitude": "lat",
            "Longitude": "lon",
            "Elevation": "altitude",
        }
        turned = turned.assign(Data=10 * np.log10(turned["Data"])).rename(named)
        turned = turned.rename(slow_time="time", twtt="fasttime")
        turned["fasttime"] = turned["fasttime"].assign_attrs(units="s")
    turned.to_zarr(path, consolidated=False) if write == "zarr" else turned.to_netcdf(path)
    found = read_echogram(path)
    for name in expected:
        assert_allclose(found[name], expected[name], rtol=4e-16)
    assert contradictions(found) == []


def test_layers_in_radians_become_degrees_too(tmp_path, frame):
    content = content_of(frame[0])
    layers = formats.opr_layers([content["Surface"]], content["GPS_time"])
    layers["Latitude"] = ("slow_time", content["Latitude"] * RADIANS, {"units": "rad"})
    layers.to_netcdf(tmp_path / "layers")
    found = read_layers(tmp_path / "layers")["Latitude"]
    assert_allclose(found, content["Latitude"], rtol=4e-16)
    assert found.attrs["units"] == "degrees"
