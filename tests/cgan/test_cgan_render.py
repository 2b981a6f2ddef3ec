"""Rendering depends on the generator, the mask and the scene's own random stream, and on nothing else."""

import numpy as np
import pytest
from numpy.testing import assert_array_equal
from toy_scenes import toy_scenes

from snowsim.cgan import Settings, Training, render, settle_statistics, trained_generator
from snowsim.seeding import random_stream

SETTINGS = Settings(width=4, depth=4, n_strided=1, n_steps=1, n_range_bins=64, n_range_lines=64)


@pytest.fixture(scope="module")
def generator():
    training = Training(SETTINGS, seed=1)
    settle_statistics(training, toy_scenes(2))
    weights = {name: value.numpy() for name, value in training.state()["generator"].items()}
    return trained_generator(weights, SETTINGS)


@pytest.mark.parametrize("statistics", ["training", "scene"])
def test_a_scene_depends_on_its_stream_and_not_on_the_scenes_rendered_before_it(generator, statistics):
    masks = [scene.mask() for scene in toy_scenes(3)]

    def rendered(order):
        stream = {number: random_stream(7, "render_cgan", number) for number in order}
        return {n: render(generator, masks[n], statistics=statistics, rng=stream[n]) for n in order}

    forwards, backwards = rendered([0, 1, 2]), rendered([2, 0])
    for number in (0, 2):
        assert_array_equal(forwards[number], backwards[number])
    another = render(generator, masks[0], statistics=statistics, rng=random_stream(7, "render_cgan", 1))
    assert (another != forwards[0]).any()


def test_the_image_has_the_size_of_the_mask_and_a_taller_window_adds_rows_and_changes_none(generator, rng):
    for size in ((300, 64), (77, 33), (1, 1)):
        image = render(generator, np.ones(size, bool), rng=rng)
        assert (image.shape, image.dtype) == (size, np.uint8)
    mask = np.zeros((160, 64), bool)
    mask[20] = True
    short = render(generator, mask[:144], dropout=0, rng=rng)
    # 4 halvings of 4x4 kernels reach 46 rows up from the edge; bytes may differ by one where float32 rounds otherwise.
    difference = short.astype(int)[:98] - render(generator, mask, dropout=0, rng=rng)[:98]
    assert np.abs(difference).max() <= 1


def test_half_precision_differs_by_few_grey_levels(generator):
    mask = toy_scenes(1)[0].mask()
    exact, half = (
        render(generator, mask, precision=p, rng=np.random.default_rng(1)).astype(int) for p in ("float32", "bfloat16")
    )
    # bfloat16 keeps 8 bits: relative steps of 2^-8 in the about 9 layers on a path, a grey level each at most.
    assert np.abs(exact - half).max() <= 9


@pytest.mark.parametrize(
    ("mask", "words"),
    [
        (np.zeros((20, 10), bool), "mask without layers"),
        (np.ones((20, 10)), "mask must be bool"),
        (np.ones((2, 20, 10), bool), "mask must be bool"),
        (np.zeros((0, 10), bool), "mask without layers"),
    ],
)
def test_masks_that_are_none_are_refused(generator, mask, words, rng):
    with pytest.raises(ValueError, match=words):
        render(generator, mask, rng=rng)


def test_a_generator_without_statistics_is_refused(rng):
    with pytest.raises(ValueError, match="settle_statistics"):
        render(Training(SETTINGS, seed=1).generator, np.ones((20, 10), bool), rng=rng)
    with pytest.raises(ValueError, match="statistics must be one of"):
        render(Training(SETTINGS, seed=1).generator, np.ones((20, 10), bool), statistics="mine", rng=rng)
