"""Layer files, old and new: real ones, else written to the field tables (`formats`)."""

from contextlib import nullcontext

import formats
import numpy as np
import pytest
import scipy.io
from formats import of_mat, refused
from numpy.testing import assert_allclose, assert_array_equal
from refusals import refusal

from snowsim.alignment import order_from_surface
from snowsim.echogram import check_layers
from snowsim.io import open_segment, read_layers

N_LINES = 30
GPS_TIME = formats.GPS_START + 0.05 * np.arange(N_LINES)
SURFACE = np.full(N_LINES, 3.0e-6)
KOENIG_2 = SURFACE + 2e-8
KOENIG_3 = SURFACE + 5e-8


@pytest.fixture
def path(tmp_path):
    return tmp_path / formats.LAYERS_FILE


def write_with_organizer(path, twtt, names, *, write=formats.write_mat5, groups=None):
    """A layer file, and beside it the file that names its layers."""
    ids = [7 * (i + 1) for i in range(len(names))]
    write(path.with_name(formats.ORGANIZER_FILE), formats.organizer_content(ids, names, groups))
    write(path, formats.layer_content(twtt, ids, GPS_TIME))
    return path


@of_mat
def test_layers_are_named_by_the_organizer_and_ordered_from_the_surface(path, write):
    # The surface is neither the first row nor id 1.
    write_with_organizer(
        path, [KOENIG_3, SURFACE, KOENIG_2], ["Koenig_3", "surface", "Koenig_2"], write=write
    )
    layers = read_layers(path)
    check_layers(layers)
    assert_array_equal(layers["layer"], ["surface", "Koenig_2", "Koenig_3"])
    assert_allclose(layers["twtt"].sel(layer="Koenig_3"), KOENIG_3, rtol=0)
    formats.check_times(layers, GPS_TIME)
    assert_array_equal(
        read_layers(path, names=["Koenig_2", "surface"])["layer"], ["surface", "Koenig_2"]
    )
    message = "named Koenig_9, found them in Koenig_3, surface, Koenig_2"
    refused(lambda path: read_layers(path, names=["Koenig_9"]), path, message)
    with refusal("^missing must be one of refuse, skip, got 'skipp'$"):
        read_layers(path, missing="skipp")


@of_mat
def test_names_that_come_twice_carry_their_group(path, write):
    names = ["surface", "deep", "deep"]
    groups = [np.empty((0, 0)), "a", "b"]
    write_with_organizer(path, [SURFACE, KOENIG_2, KOENIG_3], names, groups=groups, write=write)
    assert_array_equal(read_layers(path)["layer"], ["surface", "a:deep", "b:deep"])


@pytest.mark.parametrize(
    ("jump_s", "gap_s", "is_left_out"),
    [
        (0, 0.9e-8, False),  # a smooth surface: 1.5 m of air
        (0, 1.1e-8, True),
        (1e-8, 4.5e-8, False),  # five times the largest jump of the surface
        (1e-8, 5.5e-8, True),
        (1e-7, 1.9e-7, False),  # at most 30 m of air
        (1e-7, 2.1e-7, True),
    ],
)
def test_a_surface_far_above_all_others_was_not_picked(tmp_path, jump_s, gap_s, is_left_out):
    surface = 2.4e-6 + np.where(np.arange(60) < 30, 0, jump_s)
    surface[12:16] = 2.4e-6 - gap_s
    layers = formats.opr_layers([surface, surface + 4e-7], formats.GPS_START + np.arange(60.0))
    layers.to_netcdf(tmp_path / "layers.nc")
    told = "4 range lines have their surface at .* taken for lines that nobody picked"
    with pytest.warns(UserWarning, match=told) if is_left_out else nullcontext():
        found = read_layers(tmp_path / "layers.nc")
    absent = np.isnan(found["twtt"].values).sum(axis=1)
    assert absent.tolist() == [4 * is_left_out, 0]


def test_a_damaged_organizer_is_named(path):
    write_with_organizer(path, [SURFACE, KOENIG_2], ["surface", "Koenig_2"])
    organizer = path.with_name(formats.ORGANIZER_FILE)
    organizer.write_bytes(organizer.read_bytes()[:200])
    with refusal(f"^{organizer}: ") as error:
        read_layers(path)
    assert str(path) not in str(error.value)


@of_mat
@pytest.mark.parametrize(("n_layers", "n_lines"), [(1, N_LINES), (2, 1)])
def test_a_single_layer_or_line_may_be_one_dimensional(path, write, n_layers, n_lines):
    twtt = np.array([SURFACE, KOENIG_2])[:n_layers, :n_lines]
    content = formats.layer_content(twtt, 1 + np.arange(n_layers), GPS_TIME[:n_lines])
    write(path, content | {name: content[name].ravel() for name in ("twtt", "quality", "type")})
    assert_array_equal(read_layers(path)["twtt"], twtt)


@of_mat
def test_layers_without_picks_are_left_out_and_listed_and_a_file_of_such_is_refused(path, write):
    write_with_organizer(
        path, [SURFACE, SURFACE * np.nan, KOENIG_2], ["surface", "empty", "Koenig_2"], write=write
    )
    layers = read_layers(path)
    assert_array_equal(layers["layer"], ["surface", "Koenig_2"])
    assert layers.attrs["empty_layers"] == "empty"
    write_with_organizer(path, [SURFACE * np.nan] * 2, ["surface", "bottom"], write=write)
    refused(read_layers, path, "with picks, named surface, bottom, found them in none")


@of_mat
@pytest.mark.parametrize("names", [("surface", "Koenig_2"), ("", "")])
def test_old_files_hold_picks_in_the_second_value(path, write, names):
    write(path, formats.old_layer_content([SURFACE, KOENIG_2], GPS_TIME, names))
    layers = read_layers(path)
    # Entries without names are the surface and the bottom.
    assert_array_equal(layers["layer"], names if names[0] else ("surface", "bottom"))
    assert_array_equal(layers["twtt"], [SURFACE, KOENIG_2])
    assert_array_equal(layers["type"][:, :2], [[1, 2], [1, 2]])


@pytest.mark.parametrize("form", ["new", "old", "opr"])
def test_zero_is_no_travel_time_in_layers_of_any_format(path, form):
    surface, below = SURFACE.copy(), KOENIG_2.copy()
    surface[5:9] = below[20:] = 0
    names = ["surface", "Koenig_2"]
    if form == "new":
        write_with_organizer(path, [surface, below], names)
    elif form == "old":
        scipy.io.savemat(path, formats.old_layer_content([surface, below], GPS_TIME, names))
    else:
        formats.opr_layers([surface, below], GPS_TIME, names).to_netcdf(path)
    twtt = read_layers(path)["twtt"].values
    assert_array_equal(twtt, np.where(np.array([surface, below]) == 0, np.nan, [SURFACE, KOENIG_2]))


@pytest.mark.parametrize("gap_s", [3e-7, 1.5e-8])
def test_a_surface_at_the_first_bin_where_nobody_picked_is_left_out_with_a_warning(path, gap_s):
    surface = SURFACE.copy()
    surface[5:9] = SURFACE.min() - gap_s
    below = np.where(np.arange(N_LINES) < 20, KOENIG_2, np.nan)
    formats.opr_layers([surface, below], GPS_TIME, ["surface", "Koenig_2"]).to_netcdf(path)
    with pytest.warns(UserWarning, match=f"4 range lines have their surface at .* s, {gap_s}"):
        layers = read_layers(path)
    assert_array_equal(layers["twtt"][0], np.where(surface == SURFACE, SURFACE, np.nan))
    assert_array_equal(layers["twtt"][1], below)
    assert layers["twtt"].attrs["units"] == "s"


def test_layers_of_open_polar_radar_are_ordered_and_a_single_one_may_lack_its_axis(path):
    dataset = formats.opr_layers([KOENIG_2, SURFACE], GPS_TIME, ["Koenig_2", "surface"])
    dataset.to_netcdf(path)
    assert_array_equal(read_layers(path)["twtt"], [SURFACE, KOENIG_2])
    dataset.isel(layer=0).to_netcdf(path)
    assert read_layers(path)["twtt"].dims == ("layer", "slow_time")


def test_order_follows_what_lies_above_what_and_not_the_mean_and_depth_where_no_line_is_shared():
    first, second = SURFACE + 9e-8, SURFACE + 2e-8
    first[15:] = np.nan
    second[:15] = np.nan
    assert_array_equal(
        order_from_surface([first, second, SURFACE], ["deep", "shallow", "surface"]), [2, 1, 0]
    )
    # Snow is thin where only `low` is picked: by its mean it would come first, yet a third layer
    # lies between.
    surface = np.zeros(4)
    high = np.array([5.0, 5.0, np.nan, np.nan])
    between = np.array([np.nan, 6.0, 2.0, np.nan])
    low = np.array([np.nan, np.nan, 3.0, 3.0])
    assert_array_equal(
        order_from_surface([low, high, surface, between], ["l", "h", "surface", "b"]), [2, 1, 3, 0]
    )


def segment_files(folder, names):
    """Layer files of two segments, deepest layer first."""
    for number in (4, 5):
        times = GPS_TIME + 60 * number
        layers = formats.opr_layers([KOENIG_3, KOENIG_2, SURFACE], times, [*names, "surface"])
        layers.to_netcdf(folder / f"Data_20120330_0{number}_001_layers.nc")
    return folder.glob("*.nc")


def test_layers_of_a_segment_may_be_named_by_years_but_tracked_ones_are_of_one_segment(tmp_path):
    joined = open_segment(segment_files(tmp_path, ["2010", "2011"]))
    assert joined["layer"].values.tolist() == ["surface", "2011", "2010"]
    with refusal("segments: expected one segment, .* found 20120330_04 and 20120330_05$"):
        open_segment(segment_files(tmp_path, ["snow_1", "snow_2"]))


def test_names_of_layers_that_are_padded_bytes_are_text(tmp_path):
    path = tmp_path / "layers.nc"
    layers = formats.opr_layers([SURFACE, KOENIG_2], GPS_TIME)
    layers.assign_coords(layer=np.array([b"surface ", b"Koenig_2"])).to_netcdf(path)
    assert read_layers(path)["layer"].values.tolist() == ["surface", "Koenig_2"]


def test_frames_of_a_segment_with_other_numbers_of_unnamed_layers_are_refused(tmp_path):
    paths = [tmp_path / name for name in ("a.nc", "b.nc")]
    formats.opr_layers([SURFACE, KOENIG_2], GPS_TIME).to_netcdf(paths[0])
    formats.opr_layers([SURFACE], GPS_TIME + 60).to_netcdf(paths[1])
    with refusal("segment: layer: expected names, or as many .*, found 1 to 2 without names"):
        open_segment(paths)


CROSSING = KOENIG_2[::-1] + np.linspace(-1e-8, 1e-8, N_LINES)
REFUSED = {
    "crossing": ({"twtt": [SURFACE, KOENIG_2, CROSSING]}, "must increase strictly with depth"),
    "infinite": ({"twtt": [SURFACE, KOENIG_2 * np.inf]}, "must be finite or NaN"),
    "shape": ({"id": np.arange(4.0)}, "conflicting sizes for dimension 'layer'"),
    "no time": ({"gps_time": GPS_TIME * np.nan}, "slow_time: expected a time on every"),
    "time falls": ({"gps_time": GPS_TIME[::-1]}, "slow_time must increase"),
    "flags": ({"quality": np.full((2, N_LINES), 999.0)}, "quality: expected flags within 0 to 255"),
    "text": ({"quality": "text"}, "cannot reshape"),
    "no id": ({"id": np.empty((0, 0))}, "found no layer"),
}


@of_mat
@pytest.mark.parametrize(("change", "message"), REFUSED.values(), ids=REFUSED)
def test_impossible_layers_are_refused(path, write, change, message):
    twtt = change.get("twtt", [SURFACE, KOENIG_2])
    write_with_organizer(path, twtt, ["surface", "b", "c"][: len(twtt)], write=write)
    content = formats.layer_content(twtt, 7 * (1 + np.arange(len(twtt))), GPS_TIME)
    write(path, content | change | {"twtt": content["twtt"]})
    refused(read_layers, path, message)


def test_real_layer_files_give_their_named_layers_in_order_though_their_ids_are_not(shared_data):
    folder = shared_data / "cresis_layers" / "20181030_01"
    layers = read_layers(folder / "Data_20181030_01_001.mat")
    assert_array_equal(layers["layer"], ["surface", "bottom"])
    assert_array_equal(layers["group"], ["standard", "standard"])
    assert layers.attrs["empty_layers"] == "test, test1"
    assert layers["twtt"].isnull().sum("slow_time").values.tolist() == [0, 2]
    layers = read_layers(folder / "Data_20181030_01_002.mat")
    assert_array_equal(layers["layer"], ["surface", "test", "test1", "bottom"])


@pytest.mark.parametrize(
    ("file", "message"),
    [
        ("cresis_layers/20181103_01/Data_20181103_01_001.mat", "found no layer"),
        ("cresis_layers/20181103_01/Data_20181103_01_016.mat", "found no layer"),
        ("cresis_layers/20181030_01/layer_20181030_01.mat", "found a CReSIS layer organizer"),
        ("layer_line_png/LAYERS-Data_20120507_03_006.png", "content: expected MAT v5, MAT"),
    ],
)
def test_real_degenerate_files_organizers_and_images_are_no_layers(shared_data, file, message):
    refused(read_layers, shared_data / file, message)


@pytest.mark.parametrize("compress", [True, False])
def test_a_mat5_file_that_is_cut_off_is_refused_wherever_it_ends(path, compress):
    twtt = 1e-6 + 1e-8 * np.arange(3)[:, None] + np.zeros(50)
    content = formats.layer_content(twtt, [1, 2, 3], formats.GPS_START + np.arange(50))
    formats.write_mat5(path, content, compress=compress)
    whole = path.read_bytes()
    read_layers(path)
    for n_bytes in range(136, len(whole), len(whole) // 20):
        path.write_bytes(whole[:n_bytes])
        with pytest.raises(ValueError, match="expected a whole MAT v5 file"):
            read_layers(path)
    path.write_bytes(whole[:-5])
    refused(
        read_layers,
        path,
        f"content: expected a whole MAT v5 file, found one cut off at {len(whole) - 5} bytes",
    )


@pytest.mark.parametrize("unit", ["us", "furlongs"])
def test_units_of_all_travel_times_count(path, unit):
    twtt = 1e-6 + 1e-8 * np.arange(3)[:, None] + np.zeros(50)
    layers = formats.opr_layers(twtt, formats.GPS_START + np.arange(50))
    shown = layers["twtt"] * 1e6
    layers["peak_twtt"] = shown.assign_attrs(units=unit)
    layers.to_netcdf(path)
    if unit == "us":
        assert_allclose(read_layers(path)["peak_twtt"], twtt, rtol=1e-12)
    else:
        refused(read_layers, path, "peak_twtt: expected s, .*, found furlongs")
