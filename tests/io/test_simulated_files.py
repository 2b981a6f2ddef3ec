"""Simulated frames as CReSIS files, opened by readers that are not ours."""

import click
import numpy as np
import pytest
import scipy.io
from formats import refused
from numpy.testing import assert_array_equal
from refusals import refusal

import snowsim
from snowsim import cli
from snowsim.io import read_echogram, read_layers
from snowsim.io.files import read_dataset

FRAME = "Data_20120330_04_001.mat"
LEAP_SECONDS = 15  # GPS - UTC in March 2012


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
    made = snowsim.simulate(climate, "snow-2-8", n_range_lines=40, rng=0, date="2012-03-30")
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
    for name, place in (("twtt", "interface"), ("peak_twtt", "peak")):
        assert_array_equal(found[name], layers[name])
        assert found[name].attrs["place"] == layers[name].attrs["place"] == place
    assert_array_equal(found["slow_time"], read["slow_time"])
    assert found["layer"].values.tolist() == ["surface", *(f"snow_{i}" for i in range(1, 21))]


@pytest.mark.parametrize("name", ["Data_20140411_02_008.mat", "IRSNO1B_20140411_02_008_deconv.nc"])
def test_frames_of_one_simulation_go_on_in_snow_time_and_place(tmp_path, name):
    written(tmp_path, name, frames=3)
    paths = [tmp_path / name.replace("008", number) for number in ("008", "009", "010")]
    frames = [read_echogram(path) for path in paths]
    whole, layers = snowsim.simulate(
        snowsim.Climate(accumulation_m=0.3), "snow-2-8", n_range_lines=120, rng=0, date="2014-04-11"
    )
    found = np.concatenate([frame["slow_time"].values for frame in frames])
    # L1B files hold seconds as doubles, which lie 2.4e-7 s apart; the other format is exact.
    assert abs(found - whole["slow_time"].values).max() <= np.timedelta64(
        240 if name.endswith(".mat") else 0, "ns"
    )
    joined = np.concatenate([frame["Latitude"].values for frame in frames])
    assert_array_equal(joined, whole["Latitude"].values)
    assert_array_equal(np.hstack([frame["Data"].values for frame in frames]), whole["Data"].values)
    beside = [path.parent / "CSARP_layer" / path.name for path in paths]
    if name.endswith(".nc"):
        beside = [path.with_name(f"{path.stem}_layers.nc") for path in paths]
        for found in map(read_dataset, (paths[2], beside[2])):
            assert found.granule == "20140411_02_010"
    segment = snowsim.io.open_segment(beside)
    assert_array_equal(segment["twtt"].values, layers["twtt"].values)


def test_other_names_get_the_numbers_of_frames_and_the_date_asked_for(tmp_path):
    written(tmp_path, "mine.nc", frames=2, date="2019-05-06")
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "mine_001.nc", "mine_001_layers.nc", "mine_002.nc", "mine_002_layers.nc",
    ]  # fmt: skip
    second = read_dataset(tmp_path / "mine_002_layers.nc")
    assert second.granule == "20190506_01_002"
    assert second["slow_time"].values[0] == np.datetime64("2019-05-06T00:00:01.6")


def test_the_first_horizon_is_of_the_last_autumn_before_the_date():
    climate = snowsim.Climate(accumulation_m=0.5, variability=0.0)
    for date, share in (("2013-03-30", 211 / 366), ("2013-10-20", 51 / 366)):
        _, layers = snowsim.simulate(climate, "snow-2-8", n_range_lines=64, rng=4, date=date)
        water_m = layers["water_m"].values
        # Along the track a year's snow drifts by some .1 of it.
        np.testing.assert_allclose(water_m[1].mean(), 0.5 * share, rtol=0.1)
        named = layers.assign_coords(layer=["surface", *(f"a_{i}" for i in range(1, 21))])
        found = snowsim.accumulation(named, year=None, annual=False)
        assert found.attrs["uppermost"] == ("a_1=2012" if date < "2013-09" else "a_1=2013")
    default, _ = snowsim.simulate(climate, "snow-2-8", n_range_lines=64, rng=4)
    other, _ = snowsim.simulate(climate, "snow-2-8", n_range_lines=64, rng=4, date="2012-08-31")
    assert_array_equal(default["Data"], other["Data"])


def test_a_date_that_is_none_or_is_not_that_of_the_name_is_refused(tmp_path):
    for date in ("2012", "30.3.2012", "2012-02-30", None):
        with refusal("date must be a day such as 2012-03-30, got "):
            simulated(date=date)
    with refusal("in 1980-01-06 to 2100-01-01"):
        simulated(date="1979-05-01")
    with refusal("got '20121345'"):
        written(tmp_path, "Data_20121345_04_001.mat")
    for name, settings, told in (
        (FRAME, {"date": "2013-03-30"}, "the date of the name is not that of --date 2013-03-30"),
        ("Data_20120330_04_998.mat", {"frames": 3}, "a segment has at most 999 frames"),
    ):
        with pytest.raises(click.UsageError, match=told):
            written(tmp_path, name, **settings)
    assert not list(tmp_path.iterdir())


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
    whole, _ = simulated()
    first, second = (
        whole.isel(slow_time=lines).assign_attrs(granule=f"20000831_01_00{number}")
        for number, lines in ((1, slice(4)), (2, slice(4, None)))
    )
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
