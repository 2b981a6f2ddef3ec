from dataclasses import replace

import numpy as np
from made_up import BIN_S, made_up_frame
from numpy.testing import assert_allclose, assert_array_equal

from lib.placeholder_frames import frame_of_scene
from snowsim.alignment import along_track_m, bin_size_s, cut_blocks, layer_bins_of
from snowsim.echogram import from_uint8, to_uint8


def make_level_frame(rng, n_lines=1024, surface_row=210, n_bins=900, depth_bins=(0, 30, 90)):
    bins = surface_row + np.repeat(np.array(depth_bins, dtype=float)[:, None], n_lines, axis=1)
    return made_up_frame(rng.gamma(10, 1e-3, size=(n_bins, n_lines)).astype(np.float32), bins)


def test_blocks_follow_the_published_rule_and_deep_layers_get_a_hundred_rows_below(rng):
    echogram, layers = make_level_frame(rng)
    scenes, skipped = cut_blocks(echogram, layers, name="20120330_04")
    assert skipped == {}
    # 256 lines every 250: 0, 250, 500, 750; the next would end at 1256.
    assert [scene.notes["first_line"] for scene in scenes] == [0, 250, 500, 750]
    assert [scene.name for scene in scenes] == [f"20120330_04_{block:03d}" for block in range(4)]
    power = echogram["Data"].values
    for scene in scenes:
        assert scene.layer_bins.shape == (3, 256)
        assert_allclose(scene.layer_bins[0], 50, atol=1e-5)
        # max(300, 50 + 90 + 100)
        assert scene.n_range_bins == 300
        start = scene.notes["first_line"]
        assert_array_equal(scene.image, to_uint8(power[160:460, start : start + 256])[0])
    echogram, layers = make_level_frame(rng, depth_bins=(0, 30, 400.4))
    scenes, _ = cut_blocks(echogram, layers, name="f")
    assert scenes[0].n_range_bins == 451 + 100


def test_blocks_without_surface_or_pixels_are_skipped_and_layers_without_picks_left_out_of_theirs(
    rng,
):
    echogram, layers = make_level_frame(rng)
    layers["twtt"][0, :256] = np.nan
    echogram["Data"][300, 300] = np.nan
    echogram["Data"][301, 301] = 0
    scenes, skipped = cut_blocks(echogram, layers, name="f")
    assert [scene.name for scene in scenes] == ["f_002", "f_003"]
    assert skipped == {
        "f_000": "the surface is not picked",
        "f_001": "2 pixels without a measurement",
    }
    echogram, layers = make_level_frame(rng)
    layers["twtt"][1, 250:506] = np.nan
    scenes, _ = cut_blocks(echogram, layers, name="f")
    assert [scene.layer_bins.shape[0] for scene in scenes] == [3, 2, 3, 3]


def test_blocks_that_the_window_cuts_short_are_skipped(rng):
    for surface_row, wanted in (
        (40, "rows -10 to 290 are needed, the frame has 900"),
        (860, "rows 810 to 1110 are needed, the frame has 900"),
    ):
        echogram, layers = make_level_frame(rng, surface_row=surface_row, depth_bins=(0, 20))
        scenes, skipped = cut_blocks(echogram, layers, name="f")
        assert scenes == []
        assert set(skipped.values()) == {wanted}


def test_a_scene_becomes_the_frame_it_was_cut_from(rng):
    echogram, layers = make_level_frame(rng)
    scene = cut_blocks(echogram, layers, name="f")[0][0]
    options = {"bin_s": BIN_S, "line_spacing_m": 5.47}
    back, back_layers = frame_of_scene(scene, **options)
    assert_allclose(bin_size_s(back), BIN_S, rtol=1e-12)
    assert_allclose(np.diff(along_track_m(back)), 5.47, rtol=1e-6)
    assert_allclose(layer_bins_of(back_layers, back), scene.layer_bins, atol=1e-6)
    power_db = from_uint8(scene.image, scene.noise_floor_db, scene.maximum_db)
    assert_allclose(10 * np.log10(back["Data"]), power_db, atol=1e-4)  # float32 power
    # Where the image does not tell decibels, 255 stands for 30 dB above the floor, 0 for 10 dB
    # below it.
    mute = replace(scene, noise_floor_db=np.nan, maximum_db=np.nan)
    power = frame_of_scene(mute, **options, contrast_db=30)[0]["Data"].values
    assert_allclose(
        10 * np.log10(power.max() / power.min()), 40 / 255 * np.ptp(scene.image), rtol=1e-5
    )
