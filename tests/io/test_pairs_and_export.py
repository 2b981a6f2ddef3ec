"""The published benchmark's layout, read and written; images that are no such thing are refused."""

import struct
import zlib

import numpy as np
import pandas as pd
import pytest
from formats import failures, refused
from numpy.testing import assert_array_equal
from PIL import ExifTags, Image
from refusals import refusal

from snowsim.echogram import Scene, layer_mask
from snowsim.io import (
    PairSet,
    export_pairs,
    layer_numbers,
    layers_of_labels,
    read_image,
    read_mask,
    read_pair,
)
from snowsim.io.describe import describe
from snowsim.io.pairs import ANY_GREY


@pytest.fixture
def exported(tmp_path, scenes):
    assert export_pairs(tmp_path / "set", iter(scenes)) == {"n_scenes": 3, "n_merged_pixels": 0}
    return tmp_path / "set"


def test_pairs_come_back_exactly_but_for_whole_bins(tmp_path, exported, scenes):
    for found, scene in zip(PairSet(exported), scenes, strict=True):
        assert_array_equal(found.image, scene.image)
        outside = scene.layer_bins > scene.n_range_bins - 0.5
        assert_array_equal(found.layer_bins, np.where(outside, np.nan, np.rint(scene.layer_bins)))
        for name in ("name", "noise_floor_db", "maximum_db", "zone"):
            assert getattr(found, name) == getattr(scene, name)
    export_pairs(tmp_path / "again", PairSet(exported))
    for path in exported.iterdir():
        assert path.read_bytes() == (tmp_path / "again" / path.name).read_bytes()


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("{", "JSON: expected {bin_size_s, line_spacing_m}, positive numbers"),
        ('{"bin_s": 2e-10}', "spacing: expected {bin_size_s, line_spacing_m}, .*found {'bin_s'"),
        ('{"bin_size_s": "2e-10"}', "spacing: expected .*positive numbers"),
        ("[2e-10, 5.0]", "spacing: expected .*positive numbers"),
        ('{"line_spacing_m": -5.0}', "line_spacing_m must be finite, at least 0.01"),
        ('{"line_spacing_m": NaN}', "line_spacing_m must be finite, at least 0.01"),
        ('{"bin_size_s": 0.2886}', "bin_size_s must be finite, at least 1e-12, at most 1e-06"),
        ('{"line_spacing_m": true}', "spacing: expected .*positive numbers"),
    ],
)
def test_a_spacing_that_says_no_numbers_by_its_names_is_refused(exported, text, told):
    (exported / "spacing.json").write_text(text)
    with refusal(f"spacing.json: {told}"):
        PairSet(exported)


def test_beside_pairs_lies_the_spacing_that_all_scenes_have(tmp_path, scenes):
    for number, scene in enumerate(scenes):
        scene.notes["line_spacing_m"] = 4.0 + (number == 2)
    export_pairs(tmp_path / "unlike", scenes)
    bins = {"bin_size_s": scenes[0].notes["bin_size_s"]}
    assert PairSet(tmp_path / "unlike")[1].notes == bins
    export_pairs(tmp_path / "alike", scenes[:2])
    assert PairSet(tmp_path / "alike")[1].notes == bins | {"line_spacing_m": 4.0}
    for scene in scenes:
        scene.notes.clear()
    export_pairs(tmp_path / "mute", scenes)
    assert not (tmp_path / "mute/spacing.json").exists()


def test_the_published_loader_finds_every_pair(exported, scenes):
    # What BinaLab/MultiScale's SnowData does with a list: read names, put layer_binary_ for data_,
    # take grey > 0.
    names = pd.read_csv(exported / "all.lst", names=["data"])["data"]
    for name, scene in zip(names, scenes, strict=True):
        label = Image.open(str(exported / name).replace("data_", "layer_binary_"))
        assert label.mode == "1"
        assert_array_equal(np.asarray(label.convert("L")) > 0, scene.mask())


def test_a_list_chooses_and_orders_the_scenes_and_a_mask_alone_is_enough(exported, scenes):
    (exported / "some.lst").write_text(
        "data_20120330_04_003.png\ndata_20120330_04_001.png layer.png\n\n"
    )
    assert PairSet(exported / "some.lst").names == ["20120330_04_003", "20120330_04_001"]
    (exported / "bad.lst").write_text("data_9.png\ndata_20120330_04_001.png\ndata_8.png\n")
    refused(PairSet, exported / "bad.lst", "there, .* found 3, 2 missing: data_8.png, data_9.png")
    (exported / f"layer_{scenes[0].name}.png").unlink()
    assert_array_equal(PairSet(exported)[0].mask(), scenes[0].mask())


def test_complete_layers_can_be_the_labels_and_merged_pixels_are_counted(tmp_path, scenes):
    export_pairs(tmp_path / "set", scenes[:1], layers="complete")
    # Where the other layers have a gap.
    assert np.isfinite(PairSet(tmp_path / "set")[0].layer_bins[2, 40:90]).all()
    numbers, n_merged = layer_numbers([[10.2], [10.4], [12.0]], 20)
    assert numbers[[10, 12], 0].tolist() == [2, 3]
    assert n_merged == 1


@pytest.mark.parametrize("name", ["scene_x.nc", "scene_x.zarr"])
def test_folders_of_scenes_as_netcdf_or_zarr_are_refused_with_what_to_do(tmp_path, name):
    (tmp_path / name).touch()
    refused(PairSet, tmp_path, "found scenes as NetCDF or Zarr: export the scene set as image pa")


def test_a_mask_alone_gives_positions_below_a_gap_not_numbers(rng):
    bins = np.cumsum(rng.integers(2, 9, size=(4, 50)), axis=0).astype(float)
    assert_array_equal(layers_of_labels(layer_mask(bins, 60)), bins)
    thick = np.zeros((10, 1), dtype=bool)
    thick[[2, 3, 4, 7, 8], 0] = True
    assert_array_equal(layers_of_labels(thick), [[3.0], [7.5]])
    bins[1, 10:20] = np.nan
    found = layers_of_labels(layer_mask(bins, 60))
    assert_array_equal(layer_mask(found, 60), layer_mask(bins, 60))
    assert_array_equal(found[1, 10:20], bins[2, 10:20])
    assert np.isnan(found[3, 10:20]).all()


def test_pairs_as_mat_files_are_refused_with_what_to_do(tmp_path):
    path = tmp_path / "data_x.mat"
    path.touch()
    (tmp_path / "all.lst").write_text("data_x.mat\n")
    for read, source in ((read_pair, path), (PairSet, tmp_path / "all.lst"), (PairSet, tmp_path)):
        with refusal(r"expected data_\*.png \(snowsim.io.write_image saves .*found data_x.mat"):
            read(source)


IMAGE = np.arange(300 * 256, dtype=np.uint32).reshape(300, 256).astype(np.uint8)
MASK = layer_mask(np.full((1, 256), 50.0), 300)
REGIONS = np.repeat(np.arange(1, 11, dtype=np.uint8), 30)[:, None].repeat(256, 1)
WRONG = {
    "labels: expected a file layer_": {},
    r"size: expected that of the image, \(300, 256\), found \(86, 256\)": {
        "layer_binary": MASK[:86]
    },
    "mask: expected layers on a dark ground, found 100 %": {"layer_binary": ~MASK},
    "mask: expected layers on a dark ground, found 60 %": {
        "layer_binary": (np.arange(300) % 5 < 3)[:, None].repeat(256, 1)
    },
    "mask: expected .* grey levels of which one is 0, found 256": {"layer_binary": IMAGE},
    "labels: expected at least one layer, found none": {"layer_binary": np.zeros_like(MASK)},
    "mask: expected what layer_x.png has": {
        "layer_binary": MASK,
        "layer": np.roll(MASK, 1, 0).astype(np.uint8),
    },
    "layer numbers: .* 256 times apart": {"layer": (MASK | np.roll(MASK, 5, 0)).astype(np.uint8)},
    "layer numbers: .* 30 pixels a column": {"layer": REGIONS},
    "layer numbers: .* found 1 of numbers up to 60": {"layer": 60 * MASK.astype(np.uint8)},
    "layers must increase strictly with depth": {
        "layer": MASK + 2 * np.roll(MASK, -5, 0).astype(np.uint8)
    },
}


@pytest.mark.parametrize(("message", "labels"), WRONG.items())
def test_wrong_labels_are_refused(tmp_path, labels, message):
    for name, values in {"data": IMAGE, **labels}.items():
        Image.fromarray(values).save(tmp_path / f"{name}_x.png")
    refused(lambda folder: read_pair(folder / "data_x.png"), tmp_path, message)


def test_checked_scenes_tell_their_sizes_and_those_that_fail_are_named_together(exported, scenes):
    pairs = PairSet(exported)
    rows = pd.DataFrame(pairs.check())
    assert rows["n_range_bins"].tolist() == [300, 320, 301]
    assert (rows[["n_range_lines", "n_layers", "tells_db"]] == [256, 6, True]).all(axis=None)
    assert len(pairs.files(slice(1, 3))) == 7  # images, two labels of each, and spacing.json
    narrow = Scene("narrow", 300, scenes[0].layer_bins[:, :200], image=scenes[0].image[:, :200])
    narrow.notes.update(scenes[0].notes)
    export_pairs(exported, [narrow], list_name="narrow.lst")
    (exported / f"data_{scenes[1].name}.png").write_bytes(b"nothing")
    cut, other_width = failures(PairSet(exported).check, 2, 4)
    assert cut.startswith(str(exported))
    assert other_width == "narrow: width: expected 256 range lines as in most, found 200"


@pytest.mark.parametrize("size", [(10_000, 7_000), (10_000, 9_500), (60_000, 60_000)])
def test_decompression_bombs_are_refused_by_their_size(path, size):
    # Below Pillow's own warning, between its warning and its error, beyond both; a file of a few
    # kilobytes.
    content = b"\x89PNG\r\n\x1a\n"
    header = struct.pack(">IIBBBBB", *size, 8, 0, 0, 0, 0)
    for chunk in (b"IHDR" + header, b"IDAT" + zlib.compress(bytes(10**6)), b"IEND"):
        content += struct.pack(">I", len(chunk) - 4) + chunk + struct.pack(">I", zlib.crc32(chunk))
    path.write_bytes(content)
    refused(read_image, path, "image: expected a whole grey image of at most 67108864 pixels")


@pytest.mark.parametrize("name", ["../x", "a b", "data_x", "binary_x", "", "20120330_04_002"])
def test_names_that_loaders_would_trip_over_are_refused(tmp_path, scenes, name):
    scenes[0].name = name
    with refusal("expected a plain file name .*, unlike all others"):
        export_pairs(tmp_path / "set", scenes)


def test_missing_images_and_folders_that_loaders_would_trip_over_are_refused(tmp_path, scenes):
    with refusal("must not contain data_"):
        export_pairs(tmp_path / "my_data_set", scenes)
    scenes[0].image = None
    with refusal("expected an image"):
        export_pairs(tmp_path / "other", scenes)


def test_real_masks_that_are_inverted_or_antialiased_are_refused(path, shared_data):
    inverted = list((shared_data / "accumulation_radar_png").glob("*_SG1*.png"))
    assert inverted
    for mask in inverted:
        with refusal("inverted"):
            layers_of_labels(read_mask(mask))
    for real in sorted((shared_data / "layer_line_png").glob("*.png")):
        Image.open(real).convert("L").save(path, format="PNG")
        refused(read_mask, path, "two grey levels of which one is 0, found")


@pytest.mark.parametrize("mode", ["L", "RGB"])
def test_a_jpeg_image_is_read_as_a_png_one_and_named(path, rng, mode):
    image = rng.integers(0, 256, (300, 64), dtype=np.uint8)
    Image.fromarray(image).convert(mode).save(path, format="JPEG", quality=95)
    with Image.open(path) as opened:
        expected = np.asarray(opened.convert("L"))
    assert_array_equal(read_image(path, ANY_GREY)[0], expected)
    assert describe(path)[0]["format"] == "a JPEG image"


def test_an_image_is_turned_as_its_orientation_says(path, rng):
    image = rng.integers(0, 256, size=(30, 20), dtype=np.uint8)
    orientation = Image.Exif()
    orientation[ExifTags.Base.Orientation] = 6  # shown after a turn by 90 degrees to the right
    Image.fromarray(image).save(path, format="PNG", exif=orientation)
    assert_array_equal(read_image(path)[0], np.rot90(image, -1))
