"""Files made to harm: code objects, bombs, links out of the file, endless nesting."""

import struct
import zlib

import formats
import h5py
import numpy as np
import pytest
import scipy.io
from formats import refused
from numpy.testing import assert_array_equal

from snowsim.io import read_echogram, read_layers
from snowsim.io.containers import check_heaps, names_in_hdf5, read_netcdf
from snowsim.io.guard import MAXIMUM_BYTES
from snowsim.io.matlab import MATRIX, names_in_mat5, read_mat5, read_mat73

HEADER = b"MATLAB 5.0 MAT-file".ljust(124) + b"\x00\x01IM"


def tagged(kind, packed):
    return struct.pack("<II", kind, len(packed)) + packed


def element(kind, data):
    return tagged(kind, data) + bytes(-len(data) % 8)


def head(name, array_class, shape=(1, 1)):
    kind, size = struct.pack("<II", array_class, 0), struct.pack("<2i", *shape)
    return element(6, kind) + element(5, size) + element(1, name.encode())


def array(name, array_class, *contents, shape=(1, 1)):
    return element(MATRIX, head(name, array_class, shape) + b"".join(contents))


def nested(depth):
    inner = array("", 6, element(9, bytes(8)))
    for _ in range(depth):
        inner = array("", 1, inner)
    return array("Data", 1, inner)


def read_data(path):
    return read_mat5(path, ["Data"])


def without_data(content):
    return {name: value for name, value in content.items() if name != "Data"}


@pytest.mark.parametrize("array_class", [3, 16, 17], ids=["object", "function handle", "opaque"])
def test_code_objects_are_never_made_and_named_where_data_belong(path, content, array_class):
    formats.write_mat5(path, without_data(content), compress=False)
    inner = array("", 4, element(16, b"system('true')"), shape=(1, 14))
    harmful = array("Data", array_class, element(1, b"inline"), inner)
    if array_class == 17:  # the one class without a shape
        flags = element(6, struct.pack("<II", array_class, 0))
        harmful = element(MATRIX, flags + element(1, b"Data") + inner)
    path.write_bytes(path.read_bytes() + harmful)
    assert "Data" in names_in_mat5(path)
    assert read_mat5(path, ["Data"]) == {"Data": None}
    refused(read_echogram, path, "Data: expected real numbers, found a function handle or object")


def test_function_handles_among_parameters_do_no_harm(path, content):
    formats.write_mat73(path, content)
    with h5py.File(path, "r+") as file:
        handle = file.create_group("param_records/radar/lever_arm_fh")
        handle.attrs["MATLAB_class"] = np.bytes_("function_handle")
        handle.attrs["MATLAB_object_decode"] = np.int32(1)
    assert read_echogram(path)["Data"].shape == content["Data"].shape
    assert read_mat73(path, ["param_records"])["param_records"] == {"radar": {"lever_arm_fh": None}}


def test_mat5_values_are_those_scipy_reads_and_function_handles_among_real_ones_are_none(
    tmp_path, shared_data, rng
):
    written = tmp_path / "written.mat"
    content = {}
    for kind in ("i1", "u2", "i4", "u8", "f4", "f8"):
        content[f"x_{kind}"] = rng.integers(0, 100, (3, 4)).astype(kind)
    content["x_3d"] = rng.normal(size=(2, 3, 4))
    content["x_empty"] = np.zeros((0, 3))
    content["x_logical"] = np.array([[True, False]])
    scipy.io.savemat(written, content, do_compression=True)
    real = sorted(shared_data.glob("cresis_layers/20181030_01/*.mat"))
    real += sorted(shared_data.glob("mat/*.mat"))
    for path in (written, *real):
        loaded = scipy.io.loadmat(path, mat_dtype=True)
        theirs = {name: value for name, value in loaded.items() if not name.startswith("__")}
        ours = read_mat5(path, list(theirs))
        assert names_in_mat5(path) == set(theirs) == set(ours)
        for name, value in theirs.items():
            if value.dtype.kind in "biufc":
                assert_array_equal(ours[name], value)
            elif value.dtype.kind == "U":
                assert ours[name] == "".join(value.ravel())
    path = shared_data / "cresis_layers" / "20181030_01" / "Data_20181030_01_001.mat"
    assert read_mat5(path, ["param"])["param"]["radar"] == {"lever_arm_fh": None}


def test_complex_numbers_keep_both_parts_and_big_endian_files_are_read(tmp_path, rng):
    # scipy drops the imaginary part where types are asked to be MATLAB's.
    values = rng.normal(size=(2, 3)) + 1j * rng.normal(size=(2, 3))
    scipy.io.savemat(tmp_path / "f.mat", {"x": values})
    assert_array_equal(read_mat5(tmp_path / "f.mat", ["x"])["x"], values)
    data = struct.pack(">4d", 1, 2, 3, 4)
    parts = struct.pack(">II", 6, 8) + struct.pack(">II", 6, 0) + struct.pack(">II2i", 5, 8, 2, 2)
    parts += struct.pack(">HH4s", 1, 1, b"x") + struct.pack(">II", 9, 32) + data
    (tmp_path / "f.mat").write_bytes(
        HEADER[:124] + b"\x01\x00MI" + struct.pack(">II", 14, len(parts)) + parts
    )
    assert_array_equal(read_mat5(tmp_path / "f.mat", ["x"])["x"], [[1, 3], [2, 4]])


@pytest.mark.parametrize("name", ["Data", "anything"])
def test_compressed_bombs_are_not_inflated(path, name):
    # 3 GB of zeros in 3 MB, whether or not a reader would want the variable.
    n_bytes = 3 * 2**30
    described = head(name, 6, (n_bytes // 8 // 1024, 1024))
    start = struct.pack("<II", MATRIX, len(described) + 8 + n_bytes)
    start += described
    start += struct.pack("<II", 9, n_bytes)
    squeeze = zlib.compressobj(9)
    packed = squeeze.compress(start)
    for _ in range(4):
        packed += squeeze.compress(bytes(2**24))
    packed += squeeze.flush()
    path.write_bytes(HEADER + tagged(15, packed))
    refused(read_data, path, f"of at most {MAXIMUM_BYTES} bytes, found type 14 of")


def test_declared_sizes_are_checked_before_anything_is_read(path, content):
    formats.write_mat73(path, without_data(content))
    with h5py.File(path, "r+") as file:
        file.create_dataset(
            "Data", shape=(10**6, 10**6), dtype="f4", chunks=(1000, 1000), compression="gzip"
        )
    refused(
        read_echogram,
        path,
        f"Data: expected at most {MAXIMUM_BYTES} bytes, found 4000000000000 declared",
    )


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (
            tagged(
                15,
                zlib.compress(
                    array("Data", 6, element(9, struct.pack("<d", 1.0))) + bytes(2**27), 9
                ),
            ),
            "Data: expected a compressed variable of 72 bytes",
        ),
        (array("Data", 1, shape=(2**30, 2**30)), "Data: expected at most 0 members"),
        (nested(200), "at most 32 nested values"),
    ],
    ids=["small header over a large stream", "more members than bytes", "endless nesting"],
)
def test_variables_that_are_not_what_they_say_are_refused(path, content, message):
    path.write_bytes(HEADER + content)
    refused(read_data, path, message)


def test_references_in_circles_are_refused(path):
    with h5py.File(path, "w") as file:
        for name in ("layerData", "b"):
            file.create_dataset(name, (1000, 1), dtype=h5py.ref_dtype)
        file["layerData"][...] = file["b"].ref
        file["b"][...] = file["layerData"].ref
        file["GPS_time"] = np.zeros((3, 1))
    # Followed to the end it would take 1000^32 steps.
    refused(read_layers, path, "nested 32 deep, found more")


@pytest.mark.parametrize("kind", ["external", "soft", "storage", "virtual"])
def test_variables_kept_elsewhere_are_refused(tmp_path, content, kind):
    path, other = tmp_path / "f.mat", tmp_path / "other.h5"
    formats.write_mat73(path, without_data(content))
    shape = content["Data"].T.shape
    with h5py.File(other, "w") as file:
        file["Data"] = content["Data"].T
    with h5py.File(path, "r+") as file:
        if kind == "external":
            file["Data"] = h5py.ExternalLink(str(other), "/Data")
        elif kind == "soft":
            file["Data"] = h5py.SoftLink("/elsewhere")
        elif kind == "storage":
            file.create_dataset("Data", shape, "f4", external=[(str(other), 0, h5py.h5f.UNLIMITED)])
        else:
            layout = h5py.VirtualLayout(shape, "f4")
            layout[...] = h5py.VirtualSource(str(other), "Data", shape)
            file.create_virtual_dataset("Data", layout)
    refused(read_echogram, path, "Data: expected a variable of this file")


@pytest.mark.parametrize("reached_by", ["link", "reference", "reference alone"])
def test_links_out_of_the_file_within_structs_are_refused(path, tmp_path, content, reached_by):
    formats.write_mat73(path, content)
    other = tmp_path / "other.h5"
    with h5py.File(other, "w") as file:
        file["x"] = 1.0
    with h5py.File(path, "r+") as file:
        struct = file.create_group("param_records" if reached_by == "link" else "hidden")
        struct["x"] = h5py.ExternalLink(str(other), "/x")
        if reached_by != "link":
            cell = file.create_dataset("param_records", (1, 1), dtype=h5py.ref_dtype)
            cell[0, 0] = struct.ref
    if reached_by == "reference alone":
        # What the reference leads to stays in the file, where no walk over links meets it.
        with h5py.File(path, "r+") as file:
            del file["hidden"]
    refused(read_echogram, path, "x: expected a variable of this file, found a link to /x")


def test_heaps_that_never_end_and_texts_longer_than_the_file_are_refused(path):
    with h5py.File(path, "w") as file:
        texts = file.create_dataset(
            "layer", data=["surface", "Koenig_2"], dtype=h5py.string_dtype()
        )
        texts_at = texts.id.get_offset()
    check_heaps(path)
    whole = path.read_bytes()
    length_at = whole.index(b"GCOL") + 24
    # A length that, rounded up to 8 and added to its header, comes to nothing in 64 bits: walked
    # for ever.
    path.write_bytes(whole[:length_at] + struct.pack("<q", -16) + whole[length_at + 8 :])
    refused(names_in_hdf5, path, "HDF5 heap at byte .*: expected objects that end by byte")
    path.write_bytes(whole[:texts_at] + struct.pack("<I", 2**31) + whole[texts_at + 4 :])
    refused(read_netcdf, path, "layer: expected texts within .* bytes, found")


@pytest.mark.parametrize("call", [read_echogram, read_layers])
@pytest.mark.parametrize(
    ("content", "message"),
    [
        (None, "path: expected a file, found nothing"),
        (b"", "content: expected MAT v5"),
        (b"\x89HDF\r\n\x1a\n", "HDF5: expected a readable file"),
        (HEADER, "variables: expected those of an echogram or of layers, found none"),
        (b"CDF\x01" + bytes(4), "variables: expected|NetCDF: expected"),
        (
            b"GIF89a",
            "content: expected MAT v5, MAT v7.3, NetCDF, PNG or Zarr, found first bytes b'GIF89a'",
        ),
    ],
    ids=["missing", "empty", "hdf5 head", "mat head", "netcdf head", "gif"],
)
def test_what_is_no_data_file_is_refused(path, call, content, message):
    if content is not None:
        path.write_bytes(content)
    refused(call, path, message)


def test_a_folder_is_no_file(tmp_path):
    refused(read_echogram, tmp_path, "path: expected a file or a Zarr store, found a directory")
