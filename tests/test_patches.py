from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from snowsim.echogram import Scene, layer_mask
from snowsim.patches import draw_index, draw_patches, from_signed, scaled, to_signed


def ramp_scene(n_range_bins=60, n_range_lines=40, name="ramp"):
    """Image that spells out where each pixel came from: 4 x row + column, one layer through it."""
    rows, lines = np.indices((n_range_bins, n_range_lines))
    image = (3 * rows + lines).astype(np.uint8)
    line = np.arange(n_range_lines)
    layer_bins = np.array([10 + 0.25 * line, 30 + 0.5 * line])
    return Scene(name, n_range_bins, layer_bins, image)


def test_a_crop_is_a_window_of_image_and_mask_alike(rng):
    scene = ramp_scene()
    for _ in range(50):
        images, masks = draw_patches([scene], 20, 15, flip=False, rng=rng)
        assert images.shape == masks.shape == (1, 20, 15)
        corners = np.ndindex(60 - 20 + 1, 40 - 15 + 1)
        windows = [np.s_[row : row + 20, line : line + 15] for row, line in corners]
        found = [window for window in windows if np.array_equal(scene.image[window], images[0])]
        # 3 row + column names several corners; the mask must fit one of them.
        assert any(np.array_equal(scene.mask()[window], masks[0]) for window in found)


def test_every_crop_holds_a_layer_and_every_row_of_the_scene_is_reached(rng):
    scene = replace(ramp_scene(n_range_bins=200), layer_bins=np.full((1, 40), 50.0))
    scene.image[:] = np.arange(200)[:, None]
    images, masks = zip(*(draw_patches([scene], 64, 32, rng=rng) for _ in range(500)), strict=True)
    assert all(mask.any() for mask in masks)
    # A window of 64 rows around row 50 reaches from row 0 to row 113; 500 draws of 51 windows take
    # each (1 - 5e-5).
    assert set(np.unique(images)) == set(range(114))


def test_a_flip_mirrors_image_and_mask_together(rng):
    scene = ramp_scene()
    seen = set()
    for _ in range(20):
        images, masks = draw_patches([scene], rng=rng)
        mirrored = not np.array_equal(images[0], scene.image)
        seen.add(mirrored)
        step = -1 if mirrored else 1
        assert_array_equal(images[0], scene.image[:, ::step])
        assert_array_equal(masks[0], scene.mask()[:, ::step])
    assert seen == {True, False}


def test_patches_of_scenes_of_unlike_size_share_the_smallest(rng):
    scenes = [ramp_scene(60, 40, "a"), ramp_scene(80, 30, "b")]
    images, masks = draw_patches(scenes, 64, 64, rng=rng)
    assert images.shape == masks.shape == (2, 60, 30)


@pytest.mark.parametrize("scale", [0.75, 0.5, 0.25])
def test_a_scaled_layer_is_one_pixel_thick_and_where_the_image_shows_it(scale, rng):
    n_range_bins, n_range_lines = 240, 160
    line = np.arange(n_range_lines)
    layer_bins = (80 + 0.3 * line + 12 * np.sin(line / 25))[None]
    # Dark above the layer, bright below, the pixel it crosses in proportion: darkness of a column
    # measures its depth.
    share_below = np.clip(np.arange(n_range_bins)[:, None] + 0.5 - layer_bins, 0, 1)
    image = np.rint(200 * share_below).astype(np.uint8)
    small, small_bins = scaled(image, layer_bins, scale)
    assert small.shape == (round(n_range_bins * scale), round(n_range_lines * scale))
    assert_array_equal(layer_mask(small_bins, small.shape[0]).sum(axis=0), 1)
    darkness = (1 - small / 200).sum(axis=0)
    # Half a grey level in each of the up to 8 rows the step is spread over, 0.02; curvature 12 /
    # 25^2 over +-4 lines.
    assert_allclose(small_bins[0] + 0.5, darkness, atol=0.1)


def test_gaps_stay_gaps_at_half_scale_and_full_scale_changes_nothing():
    scene = ramp_scene()
    scene.layer_bins[1, 10:30] = np.nan
    _, small_bins = scaled(scene.image, scene.layer_bins, 0.5)
    assert_array_equal(np.isnan(small_bins[1]), (np.arange(20) >= 5) & (np.arange(20) < 15))
    image, layer_bins = scaled(scene.image, scene.layer_bins, 1)
    assert image is scene.image
    assert layer_bins is scene.layer_bins


def test_signed_values_come_back_as_the_same_bytes():
    image = np.arange(256, dtype=np.uint8).reshape(1, 16, 16)
    tensor = to_signed(image)
    assert (float(tensor.min()), float(tensor.max())) == (-1, 1)
    assert_array_equal(from_signed(tensor), image)
    assert_array_equal(np.unique(to_signed(image > 3)), [-1, 1])


def test_draws_take_every_item_before_any_comes_again():
    drawn = [draw_index(7, position, 1, "scenes") for position in range(21)]
    for time in range(3):
        assert sorted(drawn[7 * time : 7 * time + 7]) == list(range(7))
    assert drawn[:7] != drawn[7:14]
    assert drawn == [draw_index(7, position, 1, "scenes") for position in range(21)]
    assert drawn != [draw_index(7, position, 2, "scenes") for position in range(21)]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"image": np.zeros((60, 39), np.uint8)}, r"expected a uint8 image of shape \(60, 40\)"),
        ({"image": np.zeros((60, 40))}, "got float64"),
        ({"image": np.full((60, 40), 7, np.uint8)}, "with contrast"),
        ({"layer_bins": np.full((1, 40), 99.0)}, "0 annotated pixels"),
    ],
)
def test_scenes_that_teach_nothing_are_refused_by_name(change, words, rng):
    with pytest.raises(ValueError, match=f"scene ramp.*{words}"):
        draw_patches([replace(ramp_scene(), **change)], 32, 32, rng=rng)
