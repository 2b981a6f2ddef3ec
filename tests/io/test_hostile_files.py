"""Files made to harm: code objects, bombs, endless references and heaps; and what is no data."""

import struct
import zlib

import formats
import h5py
import netCDF4
import numpy as np
import pytest
from formats import of_mat, refused

from snowsim.io import read_echogram, read_layers
from snowsim.io.containers import read_matlab
from snowsim.io.files import MAXIMUM_BYTES
from snowsim.io.scenes import SceneSet, write_scenes


def test_function_handles_among_parameters_do_no_harm_and_are_no_data(path, content, shared_data):
    formats.write_mat73(path, content)
    with h5py.File(path, "r+") as file:
        handle = file.create_group("param_records/radar/lever_arm_fh")
        handle.attrs["MATLAB_class"] = np.bytes_("function_handle")
    assert read_echogram(path)["Data"].shape == content["Data"].shape
    with h5py.File(path, "r+") as file:
        del file["Data"]
        file.create_group("Data/function_handle")
    refused(read_echogram, path, "Data|MAT file")
    real = shared_data / "cresis_layers" / "20181030_01" / "Data_20181030_01_001.mat"
    assert read_matlab(real, ["param"])["param"]["day_seg"] == "20181030_01"


def test_complex_power_is_refused_and_not_stripped_of_its_imaginary_part(path, content):
    formats.write_mat5(path, content | {"Data": content["Data"] * 1j})
    refused(read_echogram, path, "discards the imaginary part")


def write_bomb(path, content):
    """Data of a MAT v5 file that say they inflate to 3 GB."""
    n_bytes = 3 * 2**30
    shape = struct.pack("<II2i", 5, 8, n_bytes // 8 // 1024, 1024)
    head = struct.pack("<IIII", 6, 8, 6, 0) + shape + struct.pack("<HH4s", 1, 4, b"Data")
    packed = zlib.compress(struct.pack("<II", 14, n_bytes) + head + bytes(2**24))
    formats.write_mat5(path, content)
    path.write_bytes(path.read_bytes() + struct.pack("<II", 15, len(packed)) + packed)


def write_huge_mat73(path, content):
    formats.write_mat73(path, content)
    with h5py.File(path, "r+") as file:
        file.create_dataset("Data", shape=(10**6, 10**6), dtype="f4", chunks=(1000, 1000))


def write_huge_netcdf(path, content):
    formats.write_nsidc(path, content | {"Data": np.ones((120, 40))})
    with netCDF4.Dataset(path, "r+") as file:
        file.createDimension("huge", 10**9)
        file.createVariable("huge", "f8", ("huge",), zlib=True)


@pytest.mark.parametrize("write", [write_bomb, write_huge_mat73, write_huge_netcdf])
def test_declared_sizes_are_checked_before_anything_is_read(path, content, write):
    del content["Data"]
    write(path, content)
    refused(read_echogram, path, f"expected at most {MAXIMUM_BYTES} bytes, found")


def test_references_in_circles_are_refused(path):
    with h5py.File(path, "w", userblock_size=512) as file:
        for name in ("layerData", "b"):
            file.create_dataset(name, (1000, 1), dtype=h5py.ref_dtype)
        file["layerData"][...] = file["b"].ref
        file["b"][...] = file["layerData"].ref
        file["GPS_time"] = np.zeros((3, 1))
    # Followed to the end it would never end.
    refused(read_layers, path, "RecursionError|expected at most")


@pytest.mark.parametrize("read", [read_echogram, SceneSet])
def test_heaps_that_never_end_are_refused(path, content, scenes, read):
    formats.write_nsidc(path, content)
    if read is SceneSet:
        write_scenes(path, scenes)
    whole = path.read_bytes()
    length_at = whole.index(b"GCOL") + 24
    # A length that, rounded up to 8 and added to its header, comes to nothing in 64 bits: walked
    # for ever.
    path.write_bytes(whole[:length_at] + struct.pack("<q", -16) + whole[length_at + 8 :])
    refused(read, path, "HDF5: expected heaps that hold their objects")


@of_mat
@pytest.mark.parametrize(
    "value", ["text", {"a": np.ones(3)}, formats.cell("ab"), np.ones((2, 3, 4))], ids=str
)
def test_a_wrong_type_is_named(path, content, write, value):
    write(path, content | {"Elevation": value})
    refused(read_echogram, path, "Elevation: expected real numbers")


@pytest.mark.parametrize("call", [read_echogram, read_layers])
@pytest.mark.parametrize(
    ("content", "message"),
    [
        (None, "expected .*, found .*No such file"),
        (b"", "content: expected MAT v5"),
        (b"\x89HDF\r\n\x1a\n", "content: expected MAT v5"),
        (b"MATLAB 5.0".ljust(124) + b"\x00\x01IM", "variables: expected those of an echogram"),
        (b"CDF\x01" + bytes(4), "expected"),
        (b"GIF89a", "content: expected MAT v5, MAT v7.3, NetCDF or Zarr, found"),
    ],
    ids=["missing", "empty", "hdf5 head", "mat head", "netcdf head", "gif"],
)
def test_what_is_no_data_file_is_refused(path, call, content, message):
    if content is not None:
        path.write_bytes(content)
    refused(call, path, message)
    refused(call, path.parent, "content: expected MAT v5, MAT v7.3, NetCDF or Zarr, found")


def test_scenes_of_a_file_that_lost_a_part_are_refused(path, scenes):
    write_scenes(path, scenes)
    with netCDF4.Dataset(path, "r+") as file:
        file.set_auto_mask(False)
        # As it reads where a flipped bit hides a part of the file.
        file["layer_bins"][2, 7] = netCDF4.default_fillvals["f4"]
    with SceneSet(path) as read:
        refused(lambda _: read[0], path, "layer_bins: expected numbers, found values that were nev")
        assert read[1].n_range_lines == 256
