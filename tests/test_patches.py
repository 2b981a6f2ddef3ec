from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_array_equal
from refusals import refusal
from toy_scenes import toy_scene

from snowsim.patches import draw_index, draw_patches, from_signed, to_signed


def places(scene):
    """A third map, which names every pixel."""
    return np.arange(scene.image.size).reshape(scene.image.shape)


@pytest.mark.parametrize("flip", [False, True])
def test_a_crop_is_a_window_of_all_maps_alike_and_half_of_them_are_mirrored(rng, flip):
    scene = toy_scene(1, 60, 40)
    mirrored = 0
    for _ in range(50):
        image, mask, place = (
            maps[0] for maps in draw_patches([scene], 20, 15, flip=flip, known=places, rng=rng)
        )
        assert_array_equal(image, scene.image.flat[place])
        assert_array_equal(mask, scene.mask().flat[place])
        steps = np.unique(np.diff(place, axis=1)), np.unique(np.diff(place, axis=0))
        assert steps[0].tolist() in ([1], [-1])
        assert steps[1].tolist() == [40]
        mirrored += steps[0][0] == -1
    # Of 50 a half, give or take 3.5; four of those.
    assert abs(mirrored - 25 * flip) <= 14 * flip


def test_every_crop_holds_a_layer_and_every_row_of_the_scene_is_reached(rng):
    scene = replace(toy_scene(1, 200, 40), layer_bins=np.full((1, 40), 50.0))
    scene.image[:] = np.arange(200)[:, None]
    images, masks = zip(*(draw_patches([scene], 64, 32, rng=rng) for _ in range(500)), strict=True)
    assert all(mask.any() for mask in masks)
    # A window of 64 rows around row 50 reaches from row 0 to row 113; 500 draws of 51 windows take
    # each (1 - 5e-5).
    assert set(np.unique(images)) == set(range(114))


def test_patches_of_scenes_of_unlike_size_share_the_smallest(rng):
    scenes = [toy_scene(1, 60, 40), toy_scene(2, 80, 30)]
    images, masks = draw_patches(scenes, 64, 64, rng=rng)
    assert images.shape == masks.shape == (2, 60, 30)


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
    assert drawn != [draw_index(7, position, 2, "scenes") for position in range(21)]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"image": np.full((60, 40), 7, np.uint8)}, r"uint8 image of shape \(60, 40\) with contr"),
        ({"layer_bins": np.full((1, 40), 99.0)}, "0 annotated pixels"),
    ],
)
def test_scenes_that_teach_nothing_are_refused_by_name(change, words, rng):
    with refusal(f"scene toy 1.*{words}"):
        draw_patches([replace(toy_scene(1, 60, 40), **change)], 32, 32, rng=rng)
