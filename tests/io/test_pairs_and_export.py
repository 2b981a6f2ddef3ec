"""The published benchmark's layout, read and written; images that are no such thing are refused."""

import json
import shutil
import struct
import zlib

import formats
import numpy as np
import pandas as pd
import pytest
import xarray as xr
from formats import failures, refused
from numpy.testing import assert_array_equal
from PIL import Image
from PIL.PngImagePlugin import PngInfo

from snowsim.echogram import Scene, layer_mask
from snowsim.io.export import export_netcdf, export_pairs, layer_numbers
from snowsim.io.images import read_image, read_mask
from snowsim.io.png_pairs import PairSet, layers_of_mask, read_pair


@pytest.fixture
def exported(tmp_path, scenes):
    assert export_pairs(tmp_path / "set", iter(scenes)) == {"n_scenes": 3, "n_merged_pixels": 0}
    return tmp_path / "set"


def test_pairs_come_back_exactly_but_for_whole_bins(exported, scenes):
    for found, scene in zip(PairSet(exported), scenes, strict=True):
        assert found.name == scene.name
        assert_array_equal(found.image, scene.image)
        outside = scene.layer_bins > scene.n_range_bins - 0.5
        assert_array_equal(found.layer_bins, np.where(outside, np.nan, np.rint(scene.layer_bins)))
        assert_array_equal(found.mask(), scene.mask())
        assert (found.noise_floor_db, found.maximum_db, found.zone) == (
            -61.2345678901234,
            scene.maximum_db,
            scene.zone,
        )


def test_a_second_export_of_what_was_read_gives_the_same_bytes(tmp_path, exported):
    export_pairs(tmp_path / "again", PairSet(exported))
    files = sorted(path.name for path in exported.iterdir())
    assert len(files) == 10
    for name in files:
        assert (exported / name).read_bytes() == (tmp_path / "again" / name).read_bytes()


def test_the_published_loader_finds_every_pair(exported, scenes):
    # What BinaLab/MultiScale's SnowData does with a list: read names, put layer_binary_ for data_,
    # take grey > 0.
    names = pd.read_csv(exported / "all.lst", names=["data"])["data"]
    for name, scene in zip(names, scenes, strict=True):
        image_path = str(exported / name)
        label = Image.open(image_path.replace("data_", "layer_binary_"))
        assert label.mode == "1"
        assert_array_equal(np.asarray(Image.open(image_path).convert("L")), scene.image)
        assert_array_equal(np.asarray(label.convert("L")) > 0, scene.mask())


def test_a_list_chooses_and_orders_the_scenes_and_a_mask_alone_is_enough(exported, scenes):
    (exported / "some.lst").write_text(
        "data_20120330_04_003.png\ndata_20120330_04_001.png layer.png\n\n"
    )
    assert PairSet(exported / "some.lst").names == ["20120330_04_003", "20120330_04_001"]
    (exported / "bad.lst").write_text("data_9.png\ndata_20120330_04_001.png\ndata_8.png\n")
    refused(
        PairSet,
        exported / "bad.lst",
        "that are there, .* found 3, 2 missing: data_8.png, data_9.png",
    )
    (exported / f"layer_{scenes[0].name}.png").unlink()
    assert_array_equal(PairSet(exported)[0].mask(), scenes[0].mask())


def test_two_layers_at_one_pixel_are_counted_and_complete_layers_can_be_the_labels(
    tmp_path, scenes
):
    export_pairs(tmp_path / "set", scenes[:1], layers="complete")
    assert np.isfinite(
        PairSet(tmp_path / "set")[0].layer_bins[2, 40:90]
    ).all()  # where the other layers have a gap
    numbers, n_merged = layer_numbers([[10.2], [10.4], [12.0]], 20)
    assert numbers[[10, 12], 0].tolist() == [2, 3]
    assert n_merged == 1


def test_netcdf_holds_every_scene_exactly(tmp_path, scenes):
    scenes[1].image = scenes[1].complete_layer_bins = None
    assert export_netcdf(tmp_path / "set", scenes) == {"n_scenes": 3}
    files = (tmp_path / "set" / "all.lst").read_text().split()
    for file, scene in zip(files, scenes, strict=True):
        found = xr.load_dataset(tmp_path / "set" / file)
        for name in ("image", "layer_bins", "complete_layer_bins"):
            assert (name in found) == (getattr(scene, name) is not None)
            if name in found:
                assert_array_equal(found[name], getattr(scene, name))
        assert_array_equal(found["mask"], scene.mask())
        for name in ("name", "n_range_bins", "noise_floor_db", "maximum_db", "zone"):
            assert found.attrs[name] == getattr(scene, name)
        assert json.loads(found.attrs["notes"]) == scene.notes


@pytest.fixture
def whole_bins(rng):
    return np.cumsum(rng.integers(2, 9, size=(12, 50)), axis=0).astype(float)


def test_a_mask_alone_gives_every_layer_and_thick_lines_count_at_their_middle(whole_bins):
    assert_array_equal(layers_of_mask(layer_mask(whole_bins, 120)), whole_bins)
    mask = np.zeros((10, 1), dtype=bool)
    mask[[2, 3, 4, 7, 8], 0] = True
    assert_array_equal(layers_of_mask(mask), [[3.0], [7.5]])


def test_below_a_gap_a_mask_keeps_positions_but_not_numbers(whole_bins):
    bins = whole_bins[:4]
    bins[1, 10:20] = np.nan
    found = layers_of_mask(layer_mask(bins, 60))
    assert_array_equal(layer_mask(found, 60), layer_mask(bins, 60))
    assert_array_equal(found[1, 10:20], bins[2, 10:20])
    assert np.isnan(found[3, 10:20]).all()


def write_mat_pair(folder, image, scene):
    """Image and layer numbers of a scene in one MAT file."""
    numbers, _ = layer_numbers(scene.layer_bins, scene.n_range_bins)
    formats.write_mat73(folder / "data_x.mat", {"data": image, "layer": numbers})
    return folder / "data_x.mat"


def test_mat_pairs_hold_data_and_layer_and_nothing_is_guessed_of_what_could_be_power_or_decibels(
    tmp_path, scenes
):
    scene = scenes[0]
    for image in (scene.image, scene.image.astype(float)):
        found = read_pair(write_mat_pair(tmp_path, image, scene))
        assert_array_equal(found.image, scene.image)
        assert_array_equal(found.mask(), scene.mask())
    found = read_pair(
        write_mat_pair(tmp_path, scene.image.astype(float) - 200.5, scene)
    )  # decibels
    assert found.maximum_db == scene.image.max() - 200.5
    data = scenes[0].image + 0.5
    path = write_mat_pair(tmp_path, data, scenes[0])
    refused(read_pair, path, "data: expected an image of numbers, found .*data_scale")
    assert PairSet(tmp_path, data_scale="power")[0].maximum_db == pytest.approx(
        10 * np.log10(data.max())
    )
    assert PairSet(tmp_path, data_scale="db")[0].maximum_db == pytest.approx(data.max())


def test_mat_labels_may_be_in_a_file_of_their_own(tmp_path, scenes):
    numbers, _ = layer_numbers(scenes[0].layer_bins, scenes[0].n_range_bins)
    formats.write_mat73(tmp_path / "data_x.mat", {"data": scenes[0].image})
    formats.write_mat73(tmp_path / "layer_x.mat", {"layer": numbers.astype(float)})
    assert_array_equal(PairSet(tmp_path)[0].mask(), scenes[0].mask())


IMAGE = np.arange(300 * 256, dtype=np.uint32).reshape(300, 256).astype(np.uint8)
MASK = layer_mask(np.full((1, 256), 50.0), 300)


@pytest.mark.parametrize(
    ("labels", "message"),
    [
        ({}, "labels: expected a file layer_"),
        (
            {"layer_binary": MASK[:86]},
            r"size: expected that of the image, \(300, 256\), found \(86, 256\)",
        ),
        (
            {"layer_binary": ~MASK},
            "mask: expected layers on a dark ground, found 100 % of pixels on: inverted",
        ),
        (
            {"layer_binary": IMAGE},
            "mask: expected 1 bit, or two grey levels of which one is 0, found 256 levels",
        ),
        ({"layer_binary": np.zeros_like(MASK)}, "labels: expected at least one layer, found none"),
        (
            {"layer_binary": MASK, "layer": np.roll(MASK, 1, 0).astype(np.uint8)},
            "mask: expected what layer_x.png has",
        ),
        (
            {"layer": (MASK | np.roll(MASK, 5, 0)).astype(np.uint8)},
            "layer numbers: .* 256 times apart",
        ),
        (
            {"layer": np.repeat(np.arange(1, 11, dtype=np.uint8), 30)[:, None].repeat(256, 1)},
            "layer numbers: .* of at most 15, found .* 30 pixels a column",
        ),
        (
            {"layer": 60 * MASK.astype(np.uint8)},
            "layer numbers: expected 1, 2, 3 and so on from the surface down, .* found 1 of",
        ),
        (
            {"layer": MASK + 2 * np.roll(MASK, -5, 0).astype(np.uint8)},
            "layers must increase strictly with depth",
        ),
    ],
    ids=[
        "none",
        "short",
        "inverted",
        "grey",
        "black",
        "differ",
        "apart",
        "regions",
        "scaled",
        "crossing",
    ],
)
def test_wrong_labels_are_refused(tmp_path, labels, message):
    for name, values in {"data": IMAGE, **labels}.items():
        Image.fromarray(values).save(tmp_path / f"{name}_x.png")
    refused(lambda folder: read_pair(folder / "data_x.png"), tmp_path, message)


def test_scenes_that_fail_and_those_of_another_width_are_named_together(exported, scenes):
    narrow = Scene("narrow", 300, scenes[0].layer_bins[:, :200], image=scenes[0].image[:, :200])
    export_pairs(exported, [narrow], list_name="narrow.lst")
    mask = exported / f"layer_binary_{scenes[0].name}.png"
    mask.write_bytes(mask.read_bytes()[:60])
    lines = failures(PairSet(exported).check, 2, 4)
    assert any(
        "narrow: width: expected 256 range lines as in most, found 200" in line for line in lines
    )
    (exported / f"data_{scenes[1].name}.png").write_bytes(b"nothing")
    failures(PairSet(exported).check, 3, 4)


def test_checked_scenes_tell_their_sizes_and_files(exported, scenes):
    pairs = PairSet(exported)
    assert [row["n_range_bins"] for row in pairs.check()] == [300, 320, 301]
    assert all(
        row["tells_db"] and row["n_range_lines"] == 256 and row["n_layers"] == 6
        for row in pairs.check()
    )
    written = {
        f"{part}_{scene.name}.png"
        for part in ("data", "layer", "layer_binary")
        for scene in scenes[1:]
    }
    assert {path.name for path in pairs.files(slice(1, 3))} == written
    assert len(pairs.files(0)) == 3


@pytest.mark.parametrize("size", [(10_000, 7_000), (10_000, 9_500), (60_000, 60_000)])
def test_decompression_bombs_are_refused_by_their_size(path, size):
    # Below Pillow's own warning, between its warning and its error, beyond both; a file of a few
    # kilobytes.
    header = struct.pack(">IIBBBBB", *size, 8, 0, 0, 0, 0)
    path.write_bytes(b"\x89PNG\r\n\x1a\n")
    with path.open("ab") as file:
        for kind, data in (
            (b"IHDR", header),
            (b"IDAT", zlib.compress(bytes(10**6))),
            (b"IEND", b""),
        ):
            file.write(
                struct.pack(">I", len(data))
                + kind
                + data
                + struct.pack(">I", zlib.crc32(kind + data))
            )
    refused(read_image, path, "PNG: expected (1 to|at most) 67108864 pixels")


def test_text_that_inflates_is_refused(path):
    info = PngInfo()
    info.add_text("maximum_db", "0" * 10**7, zip=True)
    Image.fromarray(IMAGE).save(path, format="PNG", pnginfo=info)
    refused(read_image, path, "PNG: expected a whole grey image")


@pytest.mark.parametrize("name", ["../x", "a b", "data_x", "binary_x", "x,y", ""])
def test_names_that_loaders_would_trip_over_are_refused(tmp_path, scenes, name):
    scenes[0].name = name
    with pytest.raises(ValueError, match="expected a plain file name"):
        export_pairs(tmp_path / "set", scenes)


def test_double_names_and_missing_images_are_refused(tmp_path, scenes):
    with pytest.raises(ValueError, match="a plain file name, unlike all others"):
        export_pairs(tmp_path / "set", [scenes[0], scenes[0]])
    scenes[0].image = None
    with pytest.raises(ValueError, match="expected an image; the folder"):
        export_pairs(tmp_path / "other", scenes)
    with pytest.raises(ValueError, match="must not contain data_"):
        export_pairs(tmp_path / "my_data_set", scenes)


def test_real_echogram_images_are_read_as_they_are(shared_data):
    for path in sorted((shared_data / "accumulation_radar_png").glob("*ORIGINAL.png")):
        image, _ = read_image(path)
        assert image.dtype == np.uint8
        assert image.shape[0] == 150
        assert_array_equal(image, np.asarray(Image.open(path)))


def test_real_inverted_short_masks_are_refused(tmp_path, shared_data):
    folder = shared_data / "accumulation_radar_png"
    for frame in ("20100507_01_008_010", "20110419_01_008_010"):
        mask = tmp_path / "layer_binary_x.png"
        shutil.copy(next(folder.glob(f"{frame}_SG1*.png")), mask)
        shutil.copy(folder / f"{frame}_5m_30m_ORIGINAL.png", tmp_path / "data_x.png")
        with pytest.raises(
            ValueError, match=r"size: expected that of the image, \(150, \d+\), found \(86, "
        ):
            read_pair(tmp_path / "data_x.png")
        with pytest.raises(ValueError, match="inverted"):
            layers_of_mask(read_mask(mask))


def test_real_antialiased_lines_are_refused_as_masks(path, shared_data):
    for real in sorted((shared_data / "layer_line_png").glob("*.png")):
        refused(read_mask, real, "expected 1 bit, or two grey levels of which one is 0, found 256")
        Image.open(real).convert("L").save(path, format="PNG")
        refused(read_mask, path, "two grey levels of which one is 0, found")
