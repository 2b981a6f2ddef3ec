"""Simulated frames as CReSIS files, opened by readers that are not ours."""

import numpy as np
import pytest
import scipy.io
import xarray as xr
from formats import refused
from numpy.testing import assert_array_equal
from refusals import refusal

import snowsim
from snowsim import cli
from snowsim.io import read_echogram, read_layers

FRAME = "Data_20120330_04_001.mat"
NEXT = "Data_20120330_04_002.mat"
LEAP_SECONDS = 13  # GPS - UTC in 2000, where simulated flights begin


def simulated(**settings):
    snow = snowsim.Snowpack(depth_m=[0, 1.0], density_kg_m3=[340, 400])
    return snowsim.simulate(snow, "snow-2012", n_range_lines=8, rng=1, **settings)


def written(folder, name=FRAME, **settings):
    """Echogram and layers as a command wrote them as `name`, and as `simulate` gives them."""
    options = [f"--{option}={value}" for option, value in settings.items()]
    path = folder / name
    cli.commands.main(
        ["simulate", str(path), "--range-lines", "40", *options], standalone_mode=False
    )
    climate = snowsim.Climate(accumulation_m=0.3)
    made = snowsim.simulate(climate, "snow-2-8", n_range_lines=40, rng=0)
    return path, folder / "CSARP_layer" / name, *made


def test_a_simulated_l1b_file_holds_every_value_under_its_name_and_is_read_back(tmp_path):
    path, path_to_layers, echogram, layers = written(tmp_path)
    stored = scipy.io.loadmat(path, simplify_cells=True)
    for name in ("Latitude", "Longitude", "Elevation", "Surface", "Roll", "Pitch", "Heading"):
        assert_array_equal(stored[name], echogram[name])
    since = echogram["slow_time"].values - np.datetime64("1970-01-01", "ns")
    # Doubles of this age lie 1.2e-7 s apart.
    gps_s = since / np.timedelta64(1, "s") + LEAP_SECONDS
    np.testing.assert_allclose(stored["GPS_time"], gps_s, rtol=0, atol=2.4e-7)
    assert stored["param_records"]["day_seg"] == "20120330_04"
    read = read_echogram(path)
    assert_array_equal(read["Data"].values, echogram["Data"].values)
    assert_array_equal(read["twtt"], echogram["twtt"])
    found = read_layers(path_to_layers)
    assert_array_equal(found["twtt"], layers["twtt"])
    assert_array_equal(found["slow_time"], read["slow_time"])
    assert found["layer"].values.tolist() == ["surface", *(f"snow_{i}" for i in range(1, 21))]


def test_a_frame_after_another_goes_on_in_time_and_place(tmp_path):
    first, *_ = written(tmp_path)
    second, *_ = written(tmp_path, NEXT, after=first, seed=1)
    both = [scipy.io.loadmat(path, simplify_cells=True) for path in (first, second)]
    for name, step in (("GPS_time", 5.2 / 130), ("Latitude", 5.2 / 111_195)):
        joined = np.concatenate([stored[name] for stored in both])
        # Rounded to 2.4e-7 s and 1.4e-14 degrees.
        np.testing.assert_allclose(np.diff(joined), step, rtol=1e-5)


def test_a_number_of_a_frame_goes_on_and_a_name_tells_it(tmp_path):
    first, _ = simulated()
    second, layers = simulated(after=first)
    assert first.granule == "20000831_01_001"
    assert second.granule == layers.granule == "20000831_01_002"
    written(tmp_path, "Data_20120330_04_007.nc")
    for name in ("Data_20120330_04_007.nc", "Data_20120330_04_007_layers.nc"):
        with xr.open_dataset(tmp_path / name) as stored:
            assert stored.granule == "20120330_04_007"
    written(tmp_path, "next.nc", after=written(tmp_path)[0])
    with xr.open_dataset(tmp_path / "next.nc") as stored:
        assert stored.granule == "20120330_04_002"


def test_a_frame_without_a_place_has_none_after_it():
    frame, _ = simulated()
    frame["Latitude"][-1] = np.nan
    with refusal("after: Latitude and Longitude of its end"):
        simulated(after=frame)


def test_an_organizer_of_other_layers_is_not_written_over(tmp_path):
    organizer = tmp_path / "CSARP_layer" / "layer_20120330_04.mat"
    organizer.parent.mkdir()
    content = {"lyr_id": [1.0, 2.0], "lyr_name": np.array(["surface", "bottom"], object)}
    scipy.io.savemat(organizer, content)
    before = organizer.read_bytes()
    refused(lambda _: written(tmp_path), organizer, "to snow_20, found surface, bottom")
    assert organizer.read_bytes() == before
    assert not (tmp_path / FRAME).exists()


@pytest.mark.clients
def test_xopr_opens_and_joins_simulated_files(tmp_path):
    connection = pytest.importorskip("xopr.opr_access").OPRConnection()
    path, path_to_layers, echogram, layers = written(tmp_path)
    frame = connection.load_frame_url(str(path))
    assert_array_equal(frame["Data"].values, echogram["Data"].values)
    picks = connection.load_layers_file(str(path_to_layers))
    assert_array_equal(picks["twtt"].values, layers["twtt"].values)
    assert_array_equal(picks["slow_time"].values, frame["slow_time"].values)
    first, _ = simulated()
    second, _ = simulated(after=first)
    joined = pytest.importorskip("xopr.opr_tools").merge_frames([second, first])
    both = np.hstack([first["Data"].values, second["Data"].values])
    assert_array_equal(joined["Data"].values, both)


@pytest.mark.clients
def test_impdar_opens_simulated_files(tmp_path):
    load = pytest.importorskip("impdar.lib.load")
    path, _, echogram, _ = written(tmp_path)
    (radar,) = load.load("mcords_mat", [str(path)])
    assert_array_equal(radar.data, 10 * np.log10(echogram["Data"].values))
    assert_array_equal(radar.travel_time, 1e6 * echogram["twtt"].values)
    assert_array_equal(radar.long, echogram["Longitude"].values)
