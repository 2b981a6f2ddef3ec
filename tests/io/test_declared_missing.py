"""What attributes declare as missing is missing, in numbers of the file and in scaled ones."""

import warnings

import formats
import numpy as np
import pytest
import xarray as xr
from formats import refused
from numpy.testing import assert_allclose, assert_array_equal

from snowsim.alignment import flagged_lines
from snowsim.echogram import to_db
from snowsim.io import read_echogram, read_layers
from snowsim.io.missing import with_one_fill

PACKED = {"scale_factor": 0.02, "add_offset": -60.0}
CODE = np.int16
ZARR = {"consolidated": False}
# By name: attributes, in numbers of the file by their type or as JSON has them, then in scaled
# numbers. All declare that codes above 6000, decibels above 60, are missing.
RANGES = {
    "range of codes": {"valid_range": np.array([-32000, 6000], CODE)},
    "largest code": {"valid_max": CODE(6000)},
    "range of decibels": {"valid_range": np.array([-700.0, 60.0])},
    "single decibels": {"valid_max": np.float32(60), "valid_min": np.float32(-700)},
    "one code": {"missing_value": CODE(6001)},
    "several codes": {"missing_value": np.array([7777, 6001], CODE)},
    "decibels": {"missing_value": 60.02},
    "a code as a float that no decibel equals": {"missing_value": 6001.0},
    "text": {"missing_value": "60.02"},
    "a fill and a range": {"_FillValue": CODE(-1), "valid_max": CODE(6000)},
}


def packed_amplitude(path, content, attrs, **how):
    """An IRSNO1B file of whole numbers, with 6001 on every third range line."""
    formats.write_nsidc(path, content)
    with xr.open_dataset(path, decode_cf=False) as file:
        plain = file.load()
    codes = np.rint((plain["amplitude"] + 60) / 0.02).astype(CODE)
    codes[{"time": slice(None, None, 3)}] = 6001
    plain["amplitude"] = codes.assign_attrs(PACKED | attrs)
    for variable in plain.variables.values():
        variable.encoding.clear()
    path.unlink()
    if how:
        plain.to_zarr(path, **how)
    else:
        plain.to_netcdf(path)


def write_zarr(path, content, attrs):
    plain = {key: np.asarray(value).tolist() for key, value in attrs.items()}
    packed_amplitude(path, content, plain, **ZARR)


@pytest.mark.parametrize("write", [packed_amplitude, write_zarr], ids=["netcdf", "zarr"])
@pytest.mark.parametrize("attrs", RANGES.values(), ids=RANGES)
def test_missing_power_is_declared_in_codes_or_in_decibels(path, content, write, attrs):
    write(path, content, attrs)
    found_db = to_db(read_echogram(path)["Data"].values)
    assert np.isnan(found_db[:, ::3]).all()
    kept = np.delete(np.arange(formats.N_LINES), np.s_[::3])
    # Half a step of the code, and float32 decibels.
    assert_allclose(found_db[:, kept], to_db(content["Data"])[:, kept], atol=0.01 + 1e-4)


def test_without_such_attributes_the_same_codes_are_power(path, content):
    packed_amplitude(path, content, {})
    assert_allclose(to_db(read_echogram(path)["Data"].values[:, ::3]), 60.02, atol=1e-4)


FILL = {"_FillValue": np.float64(-9999.9)}
DECLARED = {
    "missing": {"missing_value": -9999.9},
    "least": {"valid_min": -9000.0},
    "range": {"valid_range": [-9000.0, 1e6]},
    "fill of doubles": FILL,
}


@pytest.mark.parametrize("attrs", DECLARED.values(), ids=DECLARED)
@pytest.mark.parametrize("write", ["netcdf", "classic", "zarr"])
def test_positions_and_power_of_short_floats_are_missing_where_a_double_says_so(
    path, content, write, attrs
):
    if write == "netcdf" and attrs is FILL:
        attrs = {"_FillValue": np.float32(-9999.9)}  # there of the variable's type alone
    frame = formats.opr_dataset(content)
    for name in ("Elevation", "Latitude", "Data", "Surface"):
        frame[name] = frame[name].astype(np.float32)
        frame[name][{"slow_time": 7}] = -9999.9
        frame[name].attrs = dict(attrs)
    if write == "zarr":
        frame.to_zarr(path, **ZARR)
    else:
        frame.to_netcdf(path, format="NETCDF3_64BIT" if write == "classic" else "NETCDF4")
    found = read_echogram(path)
    for name in ("Elevation", "Latitude", "Data", "Surface"):
        missing = found[name].isnull().transpose("slow_time", ...).values
        assert missing[7].all()
        assert not np.delete(missing, 7, axis=0).any()
    assert not found["Longitude"].isnull().any()


@pytest.mark.parametrize(
    ("name", "attrs"),
    [
        ("time", {"valid_max": 1.92}),
        ("time", {"missing_value": 39 / 20}),
        ("fasttime", {"valid_min": 3.0001}),
    ],
)
def test_a_missing_time_is_refused(path, content, name, attrs):
    formats.write_nsidc(path, content)
    with xr.open_dataset(path, decode_cf=False) as file:
        plain = file.load()
    plain = plain.assign_coords(
        {name: plain[name].round(6).assign_attrs(plain[name].attrs | attrs)}
    )
    plain.to_netcdf(path)
    message = "time: expected a time on every range line, found none on 1 of 40 (the first is 39)"
    if name == "fasttime":
        message = "twtt must increase in even steps"
    refused(read_echogram, path, message.replace("(", r"\(").replace(")", r"\)"))


@pytest.mark.parametrize("attrs", [{"missing_value": 50}, {"valid_range": [51, 2000]}])
def test_a_missing_time_of_open_polar_radar_is_refused(path, content, attrs):
    frame = formats.opr_dataset(content)
    milliseconds = 50 * np.arange(1, formats.N_LINES + 1)
    units = {"units": "milliseconds since 2012-03-30"}
    frame["slow_time"] = ("slow_time", milliseconds, units | attrs)
    frame.to_netcdf(path)
    refused(read_echogram, path, "slow_time: expected a time on every range line, found none on 1 ")


@pytest.mark.parametrize("write", ["netcdf", "zarr"])
def test_picks_and_their_flags_are_missing_where_declared(path, content, write):
    surface = content["Surface"]
    layers = formats.opr_layers([surface, surface + 1e-8], content["GPS_time"])
    layers["twtt"][{"layer": 1, "slow_time": 4}] = -1.0
    layers["twtt"][{"layer": 1, "slow_time": 5}] = 99.0
    layers["twtt"].attrs |= {"valid_min": 0.0, "missing_value": 99.0}
    layers["quality"][{"layer": 1, "slow_time": [4, 5]}] = 255
    layers["quality"].attrs["missing_value"] = np.uint8(255) if write == "netcdf" else 255
    layers.to_netcdf(path) if write == "netcdf" else layers.to_zarr(path, **ZARR)
    found = read_layers(path)
    assert np.flatnonzero(found["twtt"].isnull()[1]).tolist() == [4, 5]
    assert not found["twtt"].isnull()[0].any()
    assert found["quality"][1, 3:7].values.tolist() == [1, 0, 0, 1]


def test_bytes_that_are_unsigned_have_unsigned_limits(path, content):
    formats.write_nsidc(path, content, drop=("roll",))
    with xr.open_dataset(path, decode_cf=False) as file:
        plain = file.load()
    degrees = np.arange(formats.N_LINES) + 200
    attrs = {"_Unsigned": "true", "valid_max": np.uint8(230).view(np.int8)}
    plain["roll"] = ("time", degrees.astype(np.uint8).view(np.int8), attrs)
    plain.to_netcdf(path)
    found = np.degrees(read_echogram(path)["Roll"].values)
    assert_allclose(found, np.where(degrees > 230, np.nan, degrees), rtol=1e-12)


@pytest.mark.parametrize(
    ("limits", "message"),
    [
        ({"valid_range": [60.0, -60.0]}, "valid_range: expected two numbers, the lesser first"),
        ({"valid_range": "-60 60"}, "valid_range: expected two numbers, .*, found -60 60"),
        ({"valid_min": [1.0, 2.0]}, "valid_min: expected one number, found"),
    ],
)
def test_a_range_that_is_none_is_refused(path, content, limits, message):
    frame = formats.opr_dataset(content)
    frame["Roll"].attrs = limits
    frame.to_netcdf(path)
    refused(read_echogram, path, f"Roll: {message}")


def test_a_range_of_another_unit_that_leaves_nothing_is_told(path, content):
    frame = formats.opr_dataset(content)
    frame["Elevation"].attrs = {"valid_range": [0.0, 9.0], "units": "m"}
    frame.to_netcdf(path)
    with pytest.warns(UserWarning, match=r"Elevation: no value lies within its valid_range"):
        assert read_echogram(path)["Elevation"].isnull().all()


def test_limits_in_which_all_values_lie_change_nothing(path, content):
    frame = formats.opr_dataset(content)
    frame.to_netcdf(path)
    plain = read_echogram(path)
    for variable in frame.data_vars.values():
        held = variable.values.astype(np.float32)
        # In single precision, as others write them: the extremes themselves are inside.
        variable.attrs["valid_range"] = [held.min(), held.max()]
    frame = frame.astype(np.float32)
    frame.to_netcdf(path)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = read_echogram(path)
    for name in frame.data_vars:
        assert_array_equal(found[name], plain[name].astype(np.float32), name)


def test_a_missing_flag_of_a_supplement_is_not_set(tmp_path, content):
    path = tmp_path / "IRSNO1B_20120330_04_017.nc"
    formats.write_nsidc(path, content)
    low = np.arange(formats.N_LINES) % 3  # 2 is missing
    flags = xr.Dataset({"low_SNR": ("line", low.astype("u1"), {"valid_range": [0, 1]})})
    flags.to_netcdf(tmp_path / "IRSNO1B_20120330_04_017_supplement.nc")
    assert_array_equal(flagged_lines(read_echogram(path))["low_SNR"], low == 1)


@pytest.mark.parametrize("scale", [-2.0, -0.01, 0.01, 0.5])
@pytest.mark.parametrize("offset", [0.0, -40.0])
@pytest.mark.parametrize("dtype", ["i1", "u1", ">i2", "i4", "i8"])
def test_a_range_and_a_missing_value_mean_the_same_in_codes_and_scaled(rng, dtype, scale, offset):
    codes = rng.integers(0, 100, 50).astype(dtype)
    ends, missing = np.sort(rng.choice(codes, 2)), codes[7]
    expected = (codes < ends[0]) | (codes > ends[1]) | (codes == missing)
    scaled_ends = np.sort(offset + scale * ends.astype(float))
    scaled = {"valid_range": scaled_ends, "missing_value": offset + scale * float(missing)}
    for declared in ({"valid_range": ends, "missing_value": missing}, scaled):
        attrs = declared | {"scale_factor": scale, "add_offset": offset}
        stored = with_one_fill("file", "x", xr.Variable("x", codes.copy(), attrs))
        decoded = xr.decode_cf(xr.Dataset({"x": stored}))["x"].values
        assert_array_equal(np.isnan(decoded), expected)
