"""Layer files written: read back to the same numbers, laid out as the real ones are."""

import formats
import numpy as np
import pytest
import scipy.io
from formats import refused
from numpy.testing import assert_allclose, assert_array_equal
from refusals import refusal

import snowsim.io.layers
from snowsim.io import read_layers, write_layer_files, write_layers
from snowsim.io.times import gps_seconds, utc_times

SEGMENT = "20120330_04"
N_LINES = 30
GPS_TIME = formats.GPS_START + 0.0537 * np.arange(N_LINES)


@pytest.fixture
def layers():
    """Surface, a layer with gaps, one without a pick and one more."""
    surface = 3.0e-6 + 1e-9 * np.sin(np.arange(N_LINES))
    twtt = surface + np.array([0, 2e-8, np.nan, 5.1e-8])[:, None]
    twtt[1, 5:9] = np.nan
    made = formats.opr_layers(twtt, GPS_TIME)
    for name, start in (("Latitude", 70), ("Longitude", -40), ("Elevation", 2500)):
        made[name] = ("slow_time", start + 1e-5 * np.arange(N_LINES))
    flags = {name: 2 * made[name] for name in ("quality", "type")}
    return made.assign(flags | {"twtt_low": made["twtt"] - 1e-9})


def test_layer_files_read_back_to_the_same_travel_times(tmp_path, layers):
    frame, _ = write_layer_files(tmp_path, SEGMENT, {1: layers})
    back = read_layers(frame)
    kept = layers.isel(layer=[0, 1, 3])
    picked = np.isfinite(kept["twtt"].values)
    for name, values in {
        "layer": ["surface", "snow_1", "snow_3"],
        "group": ["standard", "snowsim", "snowsim"],
        "twtt": kept["twtt"],
        "slow_time": layers["slow_time"],
        "Elevation": layers["Elevation"],
        "quality": np.where(picked, 2, 1),
        "type": np.full(picked.shape, 2),
    }.items():
        assert_array_equal(back[name], values)


@pytest.mark.parametrize(
    "start",
    [9.2e8, 1_341_100_816.5, 1_333_065_615.123456, 1_483_228_818.25, 1.9e9],
    ids=["1999", "after a leap second", "2012", "at a leap second", "2030"],
)
def test_gps_time_is_the_echograms_to_the_bit(start, rng):
    theirs = np.sort(start + rng.uniform(0, 100, 2000))
    slow_time = utc_times(theirs, gps=True)
    assert_array_equal(gps_seconds(slow_time), theirs)


def test_layer_files_are_laid_out_as_real_ones(tmp_path, layers, shared_data):
    ours = write_layer_files(tmp_path, SEGMENT, {1: layers})
    folder = shared_data / "cresis_layers" / "20181030_01"
    real = (folder / "Data_20181030_01_001.mat", folder / "layer_20181030_01.mat")
    for pair in zip(ours, real, strict=True):
        # Name and class of every variable, how many axes, and whether it is a row.
        laid_out = [
            {name: (kind, len(size), size[0] == 1) for name, size, kind in scipy.io.whosmat(path)}
            for path in pair
        ]
        assert laid_out[0] == laid_out[1]


def test_headers_hold_no_date_by_which_bytes_of_the_same_layers_would_differ(tmp_path, layers):
    for path in write_layer_files(tmp_path, SEGMENT, {1: layers}):
        text = path.read_bytes()[:116].decode()
        assert text.strip() == "MATLAB 5.0 MAT-file, layers by snowsim"


def test_layer_files_are_not_overwritten_unless_forced(tmp_path, layers):
    frame, organizer = write_layer_files(tmp_path, SEGMENT, {1: layers})
    moved = layers.assign(twtt=layers["twtt"] + 1e-7)
    for path in (frame, organizer):
        refused(lambda _: write_layer_files(tmp_path, SEGMENT, {1: moved}), path, "none, or --for")
        path.unlink()
        assert not frame.exists()
    write_layer_files(tmp_path, SEGMENT, {1: moved}, force=True)
    assert_array_equal(read_layers(frame)["twtt"][0], moved["twtt"][0])


def test_of_two_processes_that_write_frames_of_one_segment_the_later_is_refused(
    tmp_path, layers, monkeypatch
):
    made = snowsim.io.layers._contents

    def other_writes_meanwhile(*arguments):
        monkeypatch.setattr("snowsim.io.layers._contents", made)
        write_layer_files(tmp_path, SEGMENT, {2: layers})
        return made(*arguments)

    monkeypatch.setattr("snowsim.io.layers._contents", other_writes_meanwhile)
    with refusal("layer files: expected those of the frames tracked alone"):
        write_layer_files(tmp_path, SEGMENT, {1: layers})
    written = {path.name for path in tmp_path.rglob("*.mat")}
    assert written == {f"Data_{SEGMENT}_002.mat", f"layer_{SEGMENT}.mat"}


def test_an_organizer_does_not_rename_layers_of_other_frames(tmp_path, layers):
    frame, _ = write_layer_files(tmp_path, SEGMENT, {1: layers})
    refused(
        lambda _: write_layer_files(tmp_path, SEGMENT, {2: layers}, force=True),
        frame.parent,
        "found Data_20120330_04_001.mat",
    )


def test_a_layer_keeps_its_number_in_every_frame_of_a_segment(tmp_path, layers):
    second = layers.copy(deep=True)
    second["twtt"][1:3] = [second["twtt"][0] * np.nan, second["twtt"][0] + 3e-8]
    one, two, _ = write_layer_files(tmp_path, SEGMENT, {1: layers, 2: second})
    for path, names in ((one, ["snow_1", "snow_3"]), (two, ["snow_2", "snow_3"])):
        assert_array_equal(read_layers(path)["layer"], ["surface", *names])
        # xopr refuses to join frames whose ids differ.
        assert_array_equal(scipy.io.loadmat(path)["id"], [[1, 2, 3, 4]])
    names = ["surface", "snow_1", "snow_2", "snow_3"]
    named = second.assign_coords(layer=names).isel(layer=[0, 2, 3])
    before = two.read_bytes()
    write_layer_files(tmp_path, SEGMENT, {1: layers, 2: named}, force=True)
    assert two.read_bytes() == before


def test_layers_that_a_layer_file_would_not_keep_are_refused(tmp_path, layers):
    names = ["surface", *(f"Koenig_{number}" for number in range(1, layers.sizes["layer"]))]
    for bad, message in (
        (layers.drop_vars("Elevation"), "layers: expected with positions .* found .*Elevation"),
        (layers.isel(layer=[1, 0]), "twtt: layers must increase strictly"),
        (layers.assign_coords(layer=names), "expected surface, snow_1, .* found 'Koenig_1'"),
    ):
        with refusal(message):
            write_layer_files(tmp_path, SEGMENT, {1: bad})
    assert not list(tmp_path.rglob("*.mat"))


def test_layers_as_netcdf_keep_their_bounds_and_are_not_overwritten_unless_forced(path, layers):
    write_layers(path, layers)
    # Half a step of 2**-40 s.
    assert_allclose(read_layers(path)["twtt_low"], layers["twtt_low"], rtol=0, atol=0.46e-12)
    refused(lambda _: write_layers(path, layers), path, "none, or --force")
    write_layers(path, layers, force=True)
