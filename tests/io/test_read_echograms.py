"""Echograms of every format, with its traps, from files written to the field tables (`formats`)."""

import os
from functools import partial

import formats
import h5py
import netCDF4
import numpy as np
import pandas as pd
import pytest
import xarray as xr
from formats import of_mat, refused
from numpy.testing import assert_allclose, assert_array_equal
from refusals import refusal

from snowsim.alignment import bin_size_s, flagged_lines
from snowsim.echogram import check_echogram, to_db
from snowsim.io import echogram as echogram_of
from snowsim.io import read_echogram, write_dataset
from snowsim.io.describe import describe
from snowsim.io.predictions import read_picks
from snowsim.io.times import gps_seconds, utc_times

# dB and back in float32: one part in 2^24 of up to 30 dB, times ln 10 / 10.
DB_ROUND_TRIP = 1e-5


def write_l1b_as_netcdf(path, content):
    arrays = {"Data": (("t", "x"), content["Data"]), "Time": ("t", content["Time"])}
    along = {name: ("x", values) for name, values in content.items() if name not in arrays}
    xr.Dataset(arrays | along).to_netcdf(path)


WRITERS = {
    "nsidc": formats.write_nsidc,
    "mat5": formats.write_mat5,
    "mat73": formats.write_mat73,
    "l1b as netcdf": write_l1b_as_netcdf,
    "opr": lambda path, content: write_dataset(path, formats.opr_dataset(content)),
    "opr as zarr": lambda path, c: formats.opr_dataset(c).to_zarr(path, consolidated=False),
}


def read_back(write, path, content, **options):
    write(path, content, **options)
    return read_echogram(path)


@pytest.mark.parametrize("write", WRITERS.values(), ids=WRITERS)
def test_every_format_gives_the_same_echogram_brightest_at_the_surface(path, content, write):
    # The name says nothing: the format follows from the content.
    echogram = read_back(write, path, content)
    check_echogram(echogram)
    assert echogram["Data"].dims == ("twtt", "slow_time")
    assert_allclose(echogram["Data"], content["Data"], rtol=DB_ROUND_TRIP)
    # Microseconds and back: two roundings of a double.
    assert_allclose(echogram["twtt"], content["Time"], rtol=4e-16)
    assert_allclose(echogram["Surface"], content["Surface"], rtol=4e-16)
    assert_allclose(echogram["Heading"], content["Heading"], rtol=4e-16)
    formats.check_times(echogram, content["GPS_time"])
    brightest = echogram["twtt"].values[echogram["Data"].values.argmax(axis=0)]
    # Within a hundredth of a bin.
    assert_allclose(brightest, echogram["Surface"], atol=formats.BIN_S / 100)


@pytest.mark.parametrize("n_bins", [formats.N_BINS, formats.N_LINES], ids=["oblong", "square"])
def test_transposed_amplitude_is_recognised_by_its_dimensions(path, rng, n_bins):
    content = formats.truth(rng, n_bins=n_bins)
    echogram = read_back(formats.write_nsidc, path, content)
    assert echogram.identical(read_back(formats.write_nsidc, path, content, transposed=True))
    assert_allclose(echogram["Data"], content["Data"], rtol=DB_ROUND_TRIP)
    # Parameters lie flattened in the file, their text padded.
    assert echogram.attrs["season_name"] == "2012_Greenland_P3"


def test_netcdf3_is_read_as_netcdf4_and_fast_time_survives_bins_below_a_nanosecond(path, content):
    echogram = read_back(formats.write_nsidc, path, content)
    assert echogram.equals(read_back(formats.write_nsidc, path, content, format="NETCDF3_64BIT"))
    assert path.read_bytes()[:4] == b"CDF\x02"
    # xarray would make timedelta64[ns] of it, in which a bin of 0.0866 ns is nothing.
    content["Time"] = 3e-6 + 0.0866e-9 * np.arange(formats.N_BINS)
    steps = np.diff(read_back(formats.write_nsidc, path, content)["twtt"].values)
    # Doubles near 3 us are 4e-22 s apart.
    assert_allclose(steps, 0.0866e-9, atol=2e-21)


def test_seconds_of_day_go_on_past_midnight(path, content):
    seconds = (86399.0 + 0.05 * np.arange(formats.N_LINES)) % 86400
    echogram = read_back(formats.write_nsidc, path, content, seconds=seconds)
    times = echogram["slow_time"].values
    assert times[0] == np.datetime64("2012-03-30T23:59:59")
    assert times[-1] > np.datetime64("2012-03-31T00:00:00")
    assert_allclose(np.diff(times) / np.timedelta64(1, "ms"), 50, atol=1e-3)


def test_gps_time_loses_the_leap_seconds_of_its_first_line():
    for date, offset in {"2012-06-30": 15, "2012-07-01": 16, "2018-01-01": 18}.items():
        noon = np.datetime64(f"{date}T12:00:00", "ns")
        assert utc_times([noon.astype(np.int64) / 1e9 + offset], gps=True)[0] == noon
    midnight = np.datetime64("2012-07-01", "s").astype(np.int64) + 15
    times = utc_times(midnight + np.arange(-3, 4) * 0.5, gps=True)
    assert_array_equal(np.diff(times), np.timedelta64(500, "ms"))


@of_mat
def test_time_may_be_a_row_and_much_may_be_missing_or_older(path, content, write):
    row = content | {"Time": content["Time"][None]}
    for name in ("Roll", "Pitch", "Heading", "Surface"):
        del row[name]
    row["UTC_time"] = row.pop("GPS_time") - 15
    parameters = {"season_name": "2012_Greenland_P3", "day_seg": "20120330_04"}
    echogram = read_back(write, path, row | {"param_csarp": parameters})
    assert_array_equal(echogram["twtt"], content["Time"])
    formats.check_times(echogram, content["GPS_time"])
    assert "Roll" not in echogram
    assert echogram["Surface"].isnull().all()
    assert parameters.items() <= echogram.attrs.items()


@of_mat
def test_scaled_integers_come_back_as_power_to_half_a_step(path, content, write):
    power_db = to_db(content["Data"].astype(float))
    lowest_db, step_db = power_db.min(), np.ptp(power_db) / 255
    coded = {
        "Data": np.rint((power_db - lowest_db) / step_db).astype(np.uint8),
        "minData": np.array([lowest_db]),
        "maxData": np.array([255 * step_db]),
    }
    found_db = to_db(read_back(write, path, content | coded)["Data"].values)
    # Half a step of the code, and float32 decibels.
    assert_allclose(found_db, power_db, atol=step_db / 2 + 1e-4)


@pytest.mark.parametrize(
    ("write", "truncate_time"),
    [
        (formats.write_mat5, False),
        (formats.write_mat5, True),
        (formats.write_mat73, False),
        (formats.write_mat73, True),
        (formats.write_nsidc, True),
    ],
)
def test_compensation_is_undone_or_kept_on_request(path, content, write, truncate_time):
    correction = np.arange(formats.N_LINES) % 7
    options = {"n_kept": 100, "first": 3, "truncate_time": truncate_time}
    stored = formats.compensated(content, correction, **options)
    echogram = read_back(write, path, stored)
    # Kept rows 3 to 102 of the compensated trace are bins 3 - EC to 102 - EC: no inserted zero, in
    # front of bin 0, passes for a measurement.
    bins = np.arange(3 - 6, 103)
    assert_allclose(echogram["twtt"], content["Time"][0] + formats.BIN_S * bins, rtol=1e-9)
    row = bins[:, None] + correction
    recorded = (bins[:, None] >= 0) & (row >= 3) & (row < 103)
    power = np.where(recorded, content["Data"][bins], np.nan)
    assert_allclose(echogram["Data"], power, rtol=DB_ROUND_TRIP)
    assert_allclose(echogram["Surface"], content["Surface"], rtol=1e-15)
    assert_allclose(echogram["Elevation"], content["Elevation"], rtol=1e-12)
    kept = read_echogram(path, compensated=True)
    assert_array_equal(kept["Elevation_Correction"], correction)
    assert_allclose(kept["Surface"], stored["Surface"], rtol=1e-15)


@pytest.mark.parametrize("ending", ["supplement", "deconv_supplement"])
def test_supplement_flags_become_a_quality_mask(tmp_path, content, ending):
    path = tmp_path / "IRSNO1B_20120330_04_017_deconv.nc"
    assert "quality_mask" not in read_back(formats.write_nsidc, path, content)
    low = (np.arange(formats.N_LINES) == 7).astype(np.uint8)
    beside = tmp_path / f"IRSNO1B_20120330_04_017_{ending}.nc"
    formats.write_supplement(beside, deconvolution_artifact=1, low_SNR=low)
    found = flagged_lines(read_echogram(path))
    expected = {"deconvolution_artifact": 1, "low_SNR": low, "land_ice": 0}
    for name, lines in expected.items():
        assert_array_equal(found[name], np.broadcast_to(lines, formats.N_LINES))


def test_real_files_are_read_as_they_are_and_without_time_refused(shared_data):
    # ImpDAR's fixture: constant power, whole-number latitude, no surface picked.
    echogram = read_echogram(shared_data / "mat" / "zeros_mcords_mat.mat")
    assert echogram["Data"].shape == (951, 41)
    assert (echogram["Data"] == 1).all()
    assert (echogram["Latitude"] == 60).all()
    assert echogram["Surface"].isnull().all()
    matrix = shared_data / "mat" / "mat_reader_test.mat"
    refused(read_echogram, matrix, "Time: expected variables .*, found Data, Elevation")


def test_a_real_depth_sounder_frame_is_read(shared_data):
    echogram = read_echogram(shared_data / "mat" / "opr_l1b_v73" / "Data_20221210_01_001.mat")
    assert dict(echogram.sizes) == {"twtt": 3115, "slow_time": 54}
    assert_allclose(bin_size_s(echogram), 20e-9, rtol=1e-9)
    assert str(echogram["slow_time"].values[0]).startswith("2022-12-10T01:25:26")
    assert echogram.attrs["season_name"] == "2022_Antarctica_BaslerMKB"


BAD = [
    (
        lambda c: {"Time": c["Time"] + formats.BIN_S * (np.arange(formats.N_BINS) > 60)},
        "twtt must increase in even steps, 118 of 120 do not",
    ),
    (lambda c: {"Time": -c["Time"]}, "twtt must increase in even steps, 120 of 120 do not"),
    (lambda c: {"GPS_time": c["GPS_time"][::-1].copy()}, "slow_time must increase"),
    (lambda c: {"Latitude": c["Latitude"] + 100}, "Latitude: expected degrees"),
]


@pytest.mark.parametrize("name", ["amplitude", "time", "fasttime", "lat"])
def test_a_missing_variable_of_netcdf_is_named_though_a_dimension_has_its_name(path, content, name):
    formats.write_nsidc(path, content, drop=(name,))
    refused(read_echogram, path, f"{name}: expected variables .*, found")


def shorter(name):
    return lambda content: {name: content[name][:-1]}, "conflicting sizes for dimension"


IMPOSSIBLE = [
    *map(shorter, ("Data", "Latitude", "GPS_time", "Time")),
    (
        lambda _: {"Elevation_Correction": np.full(40, -1.0)},
        "Elevation_Correction: expected whole numbers of bins from 0 to",
    ),
    (
        lambda _: {"Elevation_Correction": np.full(40, 1e12)},
        "Elevation_Correction: expected whole numbers of bins from 0 to",
    ),
    (lambda _: {"Truncate_Bins": np.array([0.0, 1.0])}, "Truncate_Bins: expected consecutive"),
    (
        lambda _: {"minData": np.array([1.0])},
        "Data: expected integers scaled by minData and maxData",
    ),
    (lambda _: {"GPS_time": np.arange(1.0, 41.0)}, "slow_time: expected units 'since'"),
    (
        lambda _: {"Data": np.arange(4800.0).reshape(120, 40) % 256},
        "Data: expected linear power, found whole numbers of 8 bits",
    ),
]
CASES = [(write, *bad) for write in WRITERS.values() for bad in BAD]
CASES += [
    (write, *bad) for write in (formats.write_mat5, formats.write_mat73) for bad in IMPOSSIBLE
]


@pytest.mark.parametrize(("write", "change", "message"), CASES)
def test_bad_values_are_refused_in_one_line(path, content, write, change, message):
    write(path, content | change(content))
    refused(read_echogram, path, message)


@pytest.mark.parametrize("scale", [1e-3, 1, 50, 1e6])
def test_linear_amplitude_for_decibels_is_told(path, content, scale):
    with np.errstate(over="ignore"):
        content["Data"] = 10 ** (scale * np.sqrt(content["Data"]).clip(max=8) / 10)
    formats.write_nsidc(path, content)
    refused(read_echogram, path, "Data: expected decibels, found .*: linear power|finite or NaN")


def test_arrays_in_memory_need_travel_times_alone_and_names_are_checked(content):
    power, twtt = content["Data"], content["Time"]
    echogram = echogram_of(power, twtt=twtt, Surface=content["Surface"])
    assert_array_equal(echogram["Data"], power)
    assert echogram.equals(echogram_of(power.T, twtt=twtt, Surface=content["Surface"]))
    assert echogram_of(np.ma.masked_less(power, 1), twtt=twtt)["Data"].min() >= 1
    assert echogram[["Latitude", "Longitude", "Elevation"]].to_array().isnull().all()
    for message, arguments in {
        "names: expected .*Latitude.*, found latitude, lon": {"latitude": 1, "lon": 2},
        "Elevation: expected real numbers, as many": {"Elevation": np.ones(3)},
        "slow_time: expected UTC times as datetime64": {"slow_time": np.arange(40.0)},
    }.items():
        with refusal(f"echogram: {message}"):
            echogram_of(power, twtt=twtt, **arguments)
    with refusal("not decibels"):
        echogram_of(to_db(power), twtt=twtt)


XOPR = {"granule": "20120330_04_001", "mimetype": "application/x-hdf5", "source_url": "https://x/y"}


@pytest.mark.parametrize("told", [XOPR, {"source_url": "https://x/y"}], ids=["all", "one"])
def test_gps_time_in_a_dataset_of_xopr_becomes_utc_and_gps_time_again(path, content, told):
    gps_time = content["GPS_time"]
    # As xopr makes it: GPS seconds taken for UTC; what it had them from stays.
    dataset = formats.opr_dataset(content).assign(GPS_time=("slow_time", gps_time))
    dataset["slow_time"] = pd.to_datetime(gps_time, unit="s")
    dataset.assign_attrs(told).to_netcdf(path)
    echogram = read_echogram(path)
    formats.check_times(echogram, gps_time)
    # Doubles of this age lie 2.4e-7 s apart.
    assert_allclose(gps_seconds(echogram["slow_time"].values), gps_time, rtol=0, atol=2.4e-7)
    # Saved again, it is not corrected twice.
    echogram.to_netcdf(path.with_name("again"))
    assert_array_equal(read_echogram(path.with_name("again"))["slow_time"], echogram["slow_time"])


def test_utc_in_datasets_of_ours_stays_though_they_have_a_granule_as_those_of_xopr(path, content):
    ours = formats.opr_dataset(content).assign_attrs(synthetic="yes", granule="20120330_04_001")
    ours.to_netcdf(path)
    formats.check_times(read_echogram(path), content["GPS_time"])


def test_packed_amplitude_is_unpacked(path, content):
    content["Data"][:4] = np.nan
    formats.write_nsidc(path, content)
    packing = {"dtype": "i2", "scale_factor": 2e-3, "add_offset": -40, "_FillValue": -32768}
    plain = xr.load_dataset(path, decode_times=False)
    plain.to_netcdf(path, encoding={"amplitude": packing})
    # Half a step of the code, and float32 decibels.
    found_db = to_db(read_echogram(path)["Data"].values)
    assert_allclose(found_db, to_db(content["Data"]), atol=1e-3 + 1e-4)


def test_a_fill_value_that_no_attribute_tells_hides_nothing(path, content):
    formats.write_nsidc(path, content, drop=("altitude",))
    with netCDF4.Dataset(path, "r+") as file:
        altitude = file.createVariable("altitude", "i2", ("time",), fill_value=False)
        altitude[:] = netCDF4.default_fillvals["i2"]
    assert (read_echogram(path)["Elevation"] == netCDF4.default_fillvals["i2"]).all()


@pytest.mark.parametrize(
    ("write", "name", "units", "message"),
    [
        (formats.write_nsidc, "time", "moons since 2012-03-30", "units of time .*, found 'moons s"),
        (formats.write_nsidc, "time", "s since 2012-03-30 EST", "units of time .*, found 'se"),
        (WRITERS["opr"], "twtt", "moons", "s, sec, .*, found moons"),
    ],
)
def test_units_of_time_that_nobody_knows_are_named(path, content, write, name, units, message):
    write(path, content)
    with netCDF4.Dataset(path, "r+") as file:
        file[name].units = units
    refused(read_echogram, path, f"{name}: expected {message}")


def test_abbreviated_units_of_time_are_read(path, content):
    formats.write_nsidc(path, content)
    times = read_echogram(path)["slow_time"]
    with netCDF4.Dataset(path, "r+") as file:
        file["time"].units = file["time"].units.replace("seconds", "s")
    assert_array_equal(read_echogram(path)["slow_time"], times)


@pytest.mark.parametrize("write", [formats.write_mat5, formats.write_mat73, formats.write_nsidc])
def test_a_time_axis_in_single_precision_is_even_to_its_last_digit(path, content, write):
    # Where rounding of seconds, then of microseconds, is 1.5 last digits off an even axis.
    time = 3.688e-6 + 0.0866e-9 * np.arange(formats.N_BINS)
    echogram = read_back(write, path, content | {"Time": time.astype(np.float32)})
    assert_allclose(bin_size_s(echogram), 0.0866e-9, rtol=1e-4)  # .26 % of a bin over 119 of them


def test_decibels_are_told_by_their_units_and_floats_without_are_linear_power(path, content):
    frame = formats.opr_dataset(content)
    power_db = to_db(frame["Data"]) + 120  # none is negative
    for units in ("dB", "decibels"):
        frame.assign(Data=power_db.assign_attrs(units=units)).to_netcdf(path)
        assert_allclose(to_db(read_echogram(path)["Data"]), power_db, rtol=1e-6)
    frame.assign(Data=power_db.drop_attrs()).to_netcdf(path)
    assert_array_equal(read_echogram(path)["Data"], power_db)


def write_picks(path, content):
    surface = content["Surface"]
    formats.opr_layers([surface, surface + 1e-8], content["GPS_time"]).to_netcdf(path)


@pytest.mark.parametrize(
    ("name", "write", "read"),
    [
        ("a.mat", formats.write_mat5, describe),
        ("a.nc", WRITERS["opr"], describe),
        ("a.nc", write_picks, partial(read_picks, bin_s=formats.BIN_S)),
    ],
)
def test_a_file_is_opened_once(tmp_path, content, monkeypatch, name, write, read):
    path = tmp_path / name
    write(path, content)
    names = []
    really = open

    def counted(name, *args, **how):
        names.append(str(name))
        return really(name, *args, **how)

    monkeypatch.setattr("io.open", counted)
    monkeypatch.setattr("builtins.open", counted)
    read(path)
    assert names.count(str(path)) == 1


def in_decibels(path, content, units, write=write_dataset):
    """Echogram of a file whose `Data` are decibels, none negative, and say so by these `units`."""
    dataset = formats.opr_dataset(content)
    power_db = to_db(dataset["Data"].values)
    dataset["Data"] = (dataset["Data"].dims, power_db - power_db.min() + 1, {"units": units})
    write(path, dataset)
    return read_echogram(path)


def test_decibels_are_known_by_their_units_however_padded_and_other_logarithms_refused(
    path, content
):
    expected = in_decibels(path, content, "dB")
    assert expected["Data"].max() > 100  # power, not decibels
    for units in ("dB ", "dBm", " Decibels"):
        assert in_decibels(path, content, units)["Data"].equals(expected["Data"])
    for units in ("dB re 1 W", "log10(W)"):
        with refusal(f"frame: Data: units: expected db, .* or power, found {units[:5].lower()}"):
            in_decibels(path, content, units)

    def write_zarr(path, dataset):
        dataset.to_zarr(path, consolidated=False)

    stored = in_decibels(path.with_name("store"), content, ["dB"], write_zarr)
    assert_allclose(stored["Data"], expected["Data"], rtol=DB_ROUND_TRIP)


@pytest.mark.parametrize("form", ["NETCDF4", "NETCDF3_CLASSIC"])
def test_what_was_never_written_of_a_file_is_missing(path, content, form):
    whole = formats.opr_dataset(content)
    names = ("Data", "Elevation", "Surface")
    with netCDF4.Dataset(path, "w", format=form) as file:
        for name, size in whole.sizes.items():
            file.createDimension(name, size)
        for name, variable in whole.variables.items():
            is_time = name == "slow_time"
            written = file.createVariable(name, "f8" if is_time else variable.dtype, variable.dims)
            values = variable.values.astype(np.int64) / 1e9 if is_time else variable.values
            if is_time:
                written.units = "seconds since 1970-01-01"
            lines = slice(-10 if name in names else None)  # the last ten lines stay unwritten
            written[..., lines] = values[..., lines]
    echogram = read_echogram(path)
    for name in names:
        assert echogram[name][..., -10:].isnull().all()
        assert_array_equal(echogram[name][..., :-10], whole[name][..., :-10])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"units": "seconds since 05-08-2000"},
            "expected units of time since YYYY-MM-DD .*05-08-2000'",
        ),
        ({"units": "seconds since 2000-08-05 00:00 2:00"}, "expected units of time .* offset as"),
        ({"calendar": "noleap"}, "calendar: expected standard, .*, found 'noleap'"),
    ],
)
def test_dates_that_can_be_read_in_two_ways_are_refused(path, content, change, message):
    dataset = formats.opr_dataset(content)
    dataset["slow_time"] = ("slow_time", np.arange(formats.N_LINES) / 20)
    dataset["slow_time"].attrs = {"units": "seconds since 2000-08-05 00:00 +02:00"}
    write_dataset(path, dataset)
    assert read_echogram(path)["slow_time"].values[0] == np.datetime64("2000-08-04T22:00")
    dataset["slow_time"].attrs |= change
    write_dataset(path, dataset)
    refused(read_echogram, path, f"slow_time: {message}")


def test_times_that_are_no_utc_are_refused_by_their_type(content):
    times = pd.date_range("2012-03-30", periods=formats.N_LINES, freq="50ms", tz="America/Nuuk")
    for slow_time in (times, np.arange(formats.N_LINES)):
        with refusal("slow_time: expected UTC times as datetime64, without a time zone, found 40"):
            echogram_of(content["Data"], twtt=content["Time"], slow_time=slow_time)


def test_files_are_read_whatever_bytes_their_names_have(tmp_path, content):
    path = tmp_path / os.fsdecode(b"fr\xffme")
    write_dataset(tmp_path / "frame", formats.opr_dataset(content))
    (tmp_path / "frame").rename(path)
    assert read_echogram(path).sizes["slow_time"] == formats.N_LINES
    with refusal("name: expected one that is valid UTF-8"):
        write_dataset(path, formats.opr_dataset(content))


def test_values_that_lie_in_other_files_are_refused(path, content):
    # HDF5 reads zeros for a file that it does not find.
    formats.write_mat73(path, content)
    with h5py.File(path, "r+") as file:
        shape = file["Data"].shape
        del file["Data"]
        layout = h5py.VirtualLayout(shape, dtype=np.float32)
        layout[...] = h5py.VirtualSource("elsewhere.mat", "Data", shape)
        file.create_virtual_dataset("Data", layout)
    refused(read_echogram, path, "/Data: expected its own values .*, found those of elsewhere.mat")


def test_power_in_whole_numbers_is_power(path, content):
    dataset = formats.opr_dataset(content)
    dataset["Data"] = (dataset["Data"] * 1e6).round().astype(np.int32)
    write_dataset(path, dataset)
    assert_array_equal(read_echogram(path)["Data"], dataset["Data"])


def test_heights_in_other_units_and_amplitudes_are_refused_and_angles_read_by_their_units(
    path, content
):
    frame = formats.opr_dataset(content)
    for name, unit, expected in (("Elevation", "km", "metres"), ("Data", "V", "power, or db")):
        changed = frame.assign({name: frame[name].assign_attrs(units=unit)})
        changed.to_netcdf(path)
        refused(read_echogram, path, f"{name}.*: expected {expected}.*, found {unit.lower()}")
    formats.write_nsidc(path, content)
    expected = read_echogram(path)["Roll"]
    with netCDF4.Dataset(path, "a") as file:
        file["roll"][:] = np.radians(file["roll"][:])
        file["roll"].units = "radians"
    assert_allclose(read_echogram(path)["Roll"], expected, rtol=1e-12)
