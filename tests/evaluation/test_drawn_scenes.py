"""The two-sample test and the numbers of drawn scenes, on planted answers."""

from functools import partial

import numpy as np
import pytest
import torch
from numpy.testing import assert_allclose, assert_array_equal

from evaluation.lib import drawn_scenes
from evaluation.lib.drawn_scenes import (
    LAGS,
    LAYER_LAGS,
    describe_image,
    describe_layers,
    span_of,
    two_sample_table,
)
from evaluation.lib.patch_network import fit_network
from evaluation.lib.two_sample import accuracy, decisions
from snowsim.echogram import Scene, to_uint8
from snowsim.seeding import random_stream

N_LINES = 256
LEVEL = np.array([[50.0], [110.0], [170.0]]) * np.ones(N_LINES)


def speckled(rng, *, n_looks=16, rise=1.0, name="scene", wide=1):
    """A scene of level layers, `rise` over the snow.

    Speckle averaged over `wide` lines has as many looks.
    """
    power = np.ones((320, N_LINES))
    power[50:] = 30
    for row in LEVEL[1:, 0].astype(int):
        power[row - 1 : row + 2] *= rise
    shape = n_looks / wide
    speckle = rng.gamma(shape, 1 / shape, (wide, 320, N_LINES + wide))
    shifted = [speckle[0, :, first : first + N_LINES] for first in range(wide)]
    moving = np.mean(shifted, axis=0)
    image, floor, maximum = to_uint8(power * moving)
    return Scene(name, 320, LEVEL, image, noise_floor_db=floor, maximum_db=maximum)


def test_every_scene_is_classified_once_and_by_what_saw_none_of_its_crops():
    one = [np.full((n + 1, 1), n) for n in range(7)]
    other = [frame + 10 for frame in one]

    def fit(crops, truth):
        assert_array_equal(truth, crops[:, 0] >= 10)
        return lambda frame: np.isin(frame[:, 0], crops)  # True would be a crop seen before

    right = decisions(one, other, n_splits=3, fit=fit)
    for side in right:
        assert sorted(map(len, side)) == list(range(1, 8))
    # Nothing is recognised, which is the right answer for the class of False alone.
    assert np.concatenate(right[0]).all()
    assert not np.concatenate(right[1]).any()
    assert decisions(one[:2], other, n_splits=3, fit=fit) is None
    assert np.isnan(accuracy(None, rng=None)).all()


def test_scenes_of_one_kind_are_not_distinguished_and_those_of_fewer_looks_are(rng):
    sets = {
        "observed": [speckled(rng) for _ in range(12)],
        "phy": [speckled(rng) for _ in range(12)],
        "cgan": [speckled(rng, n_looks=4) for _ in range(12)],
    }
    stream = partial(random_stream, 1)
    table = two_sample_table(sets, n_splits=2, n_steps=40, stream=stream)
    whole = table[table["first_row"] < 0]
    whole = whole.set_index(["scenes", "classifier"])["accuracy"]
    for classifier in ("network", "texture"):
        # 384 patches, 192 for the halves: 4 standard errors are 0.10 and 0.14.
        assert abs(whole["phy", classifier] - 0.5) < 0.10
        assert abs(whole["observed", classifier] - 0.5) < 0.14
        assert whole["cgan", classifier] > 0.95
    assert table["first_row"].drop_duplicates().tolist() == [-1, 18, 82, 146, 210]
    low = [Scene("low", 80, LEVEL[:1], scene.image[:80]) for scene in sets["phy"]]
    message = "expected scenes of 82 x 64 pixels or more, the smallest has 80 x 256"
    with pytest.raises(ValueError, match=message):
        two_sample_table(sets | {"phy": low}, n_splits=3, n_steps=1, stream=stream)


def test_a_network_is_a_function_of_its_seed_and_leaves_the_random_state_as_it_was(rng):
    before = torch.random.get_rng_state()
    patches = rng.integers(0, 256, (70, 64, 64)).astype(np.uint8)
    truth = np.arange(70) % 3 == 0
    first = fit_network(patches, truth, n_steps=3, rng=np.random.default_rng(1))
    again = fit_network(patches, truth, n_steps=3, rng=np.random.default_rng(1))
    assert_array_equal(first(patches), again(patches))
    assert torch.equal(before, torch.random.get_rng_state())


def test_planted_looks_correlation_and_contrast_come_back(rng):
    scenes = [speckled(rng, rise=4.0, wide=2) for _ in range(4)]
    for scene in scenes:
        scene.image[30] += 40  # a sidelobe of the surface
    found = [describe_image(scene, span_of(scene)) for scene in scenes]
    mean = {key: np.mean([numbers[key] for numbers in found]) for key in found[0]}
    # 42 rows x 256 lines x 4 scenes, every second one new: known to 1 %; steps of 0.1 dB add (0.1 /
    # 3)^2 / 12 of 1/16.
    assert_allclose(mean["looks of the air", 0], 16, rtol=0.05)
    # Means of two share half with the next and nothing with the one after.
    for lag in LAGS:
        expected = 0.5 if lag == 1 else 0
        assert_allclose(mean["autocorrelation, range_line", lag], expected, atol=0.02)
        # 300 rows less what lies above 30 bins below the lowest layer: half of the pixels.
        assert_allclose(mean["unpicked snow, range_line", lag], expected, atol=0.03)
    assert_allclose(mean["looks of unpicked snow", 0], 16, rtol=0.07)
    # 6.02 dB; the least of 10 rows of 256 lines, 1.1 dB a pixel, lies 1.5 x 0.07 x sqrt(2) below
    # their mean.
    for layer in (1, 2):
        assert_allclose(mean["contrast of layers", layer], 6.02 + 0.2, atol=0.2)
    without = describe_image(scenes[0], np.nan)
    quantities = {quantity for quantity, _ in without}
    regions = ("autocorrelation", "unpicked snow")
    assert quantities == {
        f"{region}, {along}" for region in regions for along in ("range_line", "range_bin")
    }


def test_roughness_of_planted_layers_comes_back_and_few_scenes_make_means_over_these(rng):
    lines = np.arange(N_LINES)
    surface = 50 + 0.1 * lines
    buried = 80 + 0.1 * lines + 0.01 * lines**2
    found = describe_layers(np.array([surface, buried]))
    # Second differences 0 and 0.02; slab: thickness 30 + 0.01 x^2.
    assert_allclose(found["second difference, layers", 0], 0.02 / np.sqrt(2))
    assert_allclose(found["second difference, slabs", 0], 0.02)
    for lag in LAYER_LAGS:
        here = lines[:-lag]
        change = 0.01 * ((here + lag) ** 2 - here**2)
        assert_allclose(found["structure function, slabs", lag], np.mean(change**2))
    assert describe_layers(np.full((2, N_LINES), np.nan)) == {}
    numbers = {
        "observed": [{("a", 1): 1.0}, {("a", 1): 3.0, ("b", 0): 5.0}],
        "phy": [{("a", 1): 2.0}] * 2,
    }
    table = drawn_scenes.scenes_table(numbers, rng=rng)
    table = table.set_index(["quantity", "at", "scenes"])
    assert table.loc["a", 1, "observed"].tolist() == [2, 1, 3, 2]
    assert table.loc["b", 0, "observed"].tolist() == [5, 5, 5, 1]
    assert table.loc["a", 1, "phy"].tolist() == [2, 2, 2, 2]
