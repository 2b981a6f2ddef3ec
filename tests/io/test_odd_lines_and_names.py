"""Repeated times, the surface by other spellings, and layers that were joined or moved by hand."""

import warnings
from types import SimpleNamespace

import formats
import numpy as np
import pytest
import xarray as xr
from formats import refused
from numpy.testing import assert_array_equal
from refusals import refusal

from snowsim.alignment import flagged_lines
from snowsim.cli import main
from snowsim.echogram import check_layers
from snowsim.io import open_segment, read_echogram, read_layers, write_layer_files
from snowsim.io.frames import read_frame
from snowsim.io.layers import begins_with_surface
from snowsim.snowpack import Climate, accumulation, simulate

N_LINES = formats.N_LINES
KEPT = np.delete(np.arange(N_LINES), [11, 30, 31])
NOTE = "slow_time: 3 of 40 range lines are left out, .* time of the line before (the first is 11)"


@pytest.fixture
def repeated(content):
    """The same with the time of lines 11, 30 and 31 that of lines 10 and 29."""
    content["GPS_time"][11] = content["GPS_time"][10]
    content["GPS_time"][30:32] = content["GPS_time"][29]
    return content


def noted(read, path):
    with pytest.warns(UserWarning, match=NOTE.replace("(", r"\(").replace(")", r"\)")) as caught:
        found = read(path)
    assert len(caught) == 1
    return found


WRITERS = {
    "nsidc": formats.write_nsidc,
    "mat5": formats.write_mat5,
    "mat73": formats.write_mat73,
    "opr": lambda path, content: formats.opr_dataset(content).to_netcdf(path),
}


@pytest.mark.parametrize("write", WRITERS.values(), ids=WRITERS)
def test_of_a_repeated_time_the_first_line_is_kept_with_a_note(path, repeated, write):
    write(path, repeated)
    found = noted(read_echogram, path)
    assert_array_equal(found["Latitude"], repeated["Latitude"][KEPT])
    # dB and back in float32.
    np.testing.assert_allclose(found["Data"], repeated["Data"][:, KEPT], rtol=1e-5)


def test_compensation_and_flags_stay_with_their_lines(tmp_path, repeated):
    path = tmp_path / "IRSNO1B_20120330_04_017.nc"
    low = np.arange(N_LINES) % 4 == 3  # lines 11 and 31 among them
    formats.write_supplement(tmp_path / "IRSNO1B_20120330_04_017_supplement.nc", low_SNR=low)
    bins = np.arange(N_LINES) % 7
    formats.write_nsidc(path, formats.compensated(repeated, bins, n_kept=120, truncate_time=True))
    found = noted(read_echogram, path)
    assert_array_equal(flagged_lines(found)["low_SNR"], low[KEPT])
    assert found["Surface"].values == pytest.approx(repeated["Surface"][KEPT], rel=1e-12)


@pytest.mark.parametrize("form", ["new", "old", "opr"])
def test_of_layers_the_same_lines_are_kept(path, repeated, form):
    twtt = np.array([repeated["Surface"], repeated["Surface"] + 1e-8])
    times = repeated["GPS_time"]
    if form == "new":
        formats.write_mat5(path, formats.layer_content(twtt, [1, 2], times))
    elif form == "old":
        formats.write_mat5(path, formats.old_layer_content(twtt, times, ["surface", "deep"]))
    else:
        formats.opr_layers(twtt, times).to_netcdf(path)
    assert_array_equal(noted(read_layers, path)["twtt"], twtt[:, KEPT])


@pytest.mark.parametrize("command", ["info", "track"])
def test_commands_note_lines_that_are_left_out_once(tmp_path, capsys, command):
    path = tmp_path / "frame.nc"
    frame, _ = simulate(Climate(accumulation_m=0.3), "snow-2012", n_range_lines=64, rng=1)
    times = frame["slow_time"].values.copy()
    times[7] = times[6]
    frame.assign_coords(slow_time=times).to_netcdf(path)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        main([command, str(path), *(["-o", str(tmp_path / "out")] * (command == "track"))])
    note = "slow_time: 1 of 64 range lines are left out"
    assert capsys.readouterr().out.count(f"{note}") == 1
    if command == "track":
        (written,) = (tmp_path / "out").glob("*_layers.nc")
        layers = read_layers(written)
        assert note in layers.attrs["notes"]
        assert layers.sizes["slow_time"] == 63


def test_a_clock_that_stood_still_is_refused(path, content):
    content["GPS_time"] = np.repeat(content["GPS_time"][::2], 2)
    formats.write_mat5(path, content)
    refused(read_echogram, path, "slow_time must increase")


SPELLINGS = ("Surface", "SURFACE", "surface")


@pytest.mark.parametrize("name", SPELLINGS)
def test_a_surface_of_any_case_is_the_surface_of_every_reader(tmp_path, content, name):
    path = tmp_path / formats.LAYERS_FILE
    below = content["Surface"] + 40 * formats.BIN_S
    # The surface misses lines where the layer below has picks: only its name puts it first.
    surface = np.where(np.arange(N_LINES) < 20, content["Surface"], np.nan)
    deep = np.where(np.arange(N_LINES) < 20, np.nan, below)
    organizer = formats.organizer_content([1, 2], ["deep", name])
    formats.write_mat5(tmp_path / formats.ORGANIZER_FILE, organizer)
    formats.write_mat5(path, formats.layer_content([deep, surface], [1, 2], content["GPS_time"]))
    found = read_layers(path)
    assert found["layer"].values.tolist() == ["surface", "deep"]
    assert begins_with_surface(found)
    assert_array_equal(read_layers(path, names=[name, "deep"])["twtt"], found["twtt"])
    assert open_segment([path])["layer"].values.tolist() == ["surface", "deep"]


@pytest.mark.parametrize("name", SPELLINGS)
def test_a_frame_is_joined_by_a_surface_of_any_case(tmp_path, content, name):
    echogram, layers = tmp_path / "frame.nc", tmp_path / "layers.nc"
    formats.write_nsidc(echogram, content)
    twtt = [content["Surface"] + 40 * formats.BIN_S, content["Surface"]]
    formats.opr_layers(twtt, content["GPS_time"], ["deep", name]).to_netcdf(layers)
    row = SimpleNamespace(echogram=echogram, layers=layers)
    for names in (None, [name, "deep"], ["surface", "deep"]):
        _, joined = read_frame(row, layer_names=names)
        assert joined["twtt"].shape == (2, N_LINES)
        assert not joined["twtt"].isnull().any()


def test_two_surfaces_that_differ_in_case_stay_two(path, content):
    twtt = [content["Surface"] + 1e-8, content["Surface"]]
    formats.opr_layers(twtt, content["GPS_time"], ["Surface", "surface"]).to_netcdf(path)
    assert read_layers(path)["layer"].values.tolist() == ["surface", "Surface"]


def tracked(content, name="surface"):
    """Layers in memory as a person has them."""
    twtt = content["Surface"] + np.arange(4)[:, None] * 2e-9
    names = [name, "snow_1", "snow_2", "snow_3"]
    layers = formats.opr_layers(twtt, content["GPS_time"], names)
    positions = {
        each: ("slow_time", content[each]) for each in ("Latitude", "Longitude", "Elevation")
    }
    return layers.assign(positions)


@pytest.mark.parametrize("name", ["Surface", "standard:SURFACE"])
def test_a_surface_of_any_case_in_memory_is_dated_and_written_as_one(tmp_path, content, name):
    layers = tracked(content, name)
    dated, expected = (accumulation(each, 400, year=2011) for each in (layers, tracked(content)))
    assert dated.drop_vars("layer").equals(expected.drop_vars("layer"))
    layers["layer"] = [name.rpartition(":")[2], *layers["layer"].values[1:]]
    first, _ = write_layer_files(tmp_path, "20120330_04", {1: layers})
    assert read_layers(first)["layer"].values.tolist() == tracked(content)["layer"].values.tolist()


def test_layers_joined_with_a_position_each_are_refused_with_the_remedy(path, content):
    layers = tracked(content)
    parts = [layers.isel(layer=[number]) for number in range(4)]
    joined = xr.concat(parts, "layer", data_vars="all", coords="minimal", compat="override")
    joined.to_netcdf(path)
    refused(read_layers, path, "Latitude: expected along slow_time alone, found .*'minimal'")
    with refusal("Latitude: expected along slow_time alone"):
        accumulation(joined, 400)
    minimal = xr.concat(parts, "layer", data_vars="minimal", coords="minimal", compat="override")
    check_layers(minimal)


@pytest.mark.parametrize(("moved_s", "message"), [(3e-9, "1 outside"), (-3e-9, "1 outside")])
def test_a_pick_that_was_moved_out_of_its_limits_is_refused(path, content, moved_s, message):
    layers = tracked(content)
    layers["twtt_low"] = layers["twtt"] - 0.5e-9
    layers["twtt_high"] = layers["twtt"] + 0.5e-9
    check_layers(layers)
    layers["twtt"][{"layer": 3 if moved_s > 0 else 0, "slow_time": 17}] += moved_s
    layers.to_netcdf(path)
    layer = 3 if moved_s > 0 else 0
    line = refused(read_layers, path, "twtt: expected picks within twtt_low and twtt_high")
    assert f"found {message} (the first: layer {layer}, range line 17)" in line


def test_picks_whose_limits_are_missing_are_read(path, content):
    layers = tracked(content)
    layers["twtt_low"] = layers["twtt"] - 0.5e-9
    layers["twtt_high"] = layers["twtt"] + 0.5e-9
    for name in ("twtt_low", "twtt_high"):
        layers[name][2] = np.nan
    layers["twtt"][2] += 0.8e-9
    layers.to_netcdf(path)
    assert_array_equal(read_layers(path)["twtt"], layers["twtt"])
