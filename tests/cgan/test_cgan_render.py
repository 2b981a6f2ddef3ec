"""Rendering depends on the generator, the layers and the scene's random stream, on nothing else."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import torch
from numpy.testing import assert_allclose, assert_array_equal
from toy_scenes import toy_scenes

from snowsim.cgan import Settings, Training, render, trained_generator
from snowsim.cgan.inputs import Levels
from snowsim.cgan.scope import outside, scope_of
from snowsim.echogram import Scene
from snowsim.seeding import random_stream

SIZE = {
    "width": 4,
    "depth": 4,
    "n_strided": 1,
    "n_steps": 1,
    "n_range_bins": 64,
    "n_range_lines": 64,
}
SETTINGS = Settings(**SIZE)
SILENCE = SimpleNamespace(random=np.ones, standard_normal=np.zeros)  # random numbers that are none
PIX2PIX = Settings(**SIZE, method="pix2pix", dropout=0.5)


def untrained(settings):
    weights = {
        name: value.numpy()
        for name, value in Training(settings, seed=1).state()["generator"].items()
    }
    return trained_generator(weights, settings)


@pytest.fixture(scope="module")
def generator():
    return untrained(SETTINGS)


def level(n_range_bins, n_range_lines=64, row=20.0):
    """A scene of one level layer."""
    return Scene("level", n_range_bins, np.full((1, n_range_lines), row))


@pytest.mark.parametrize("settings", [SETTINGS, PIX2PIX], ids=["depth", "pix2pix"])
def test_a_scene_depends_on_its_stream_and_not_on_the_scenes_rendered_before_it(settings):
    scenes, generator = toy_scenes(3), untrained(settings)

    def rendered(order):
        stream = {number: random_stream(7, "render_cgan", number) for number in order}
        return {n: render(generator, scenes[n], settings, rng=stream[n]) for n in order}

    forwards, backwards = rendered([0, 1, 2]), rendered([2, 0])
    for number in (0, 2):
        assert_array_equal(forwards[number], backwards[number])
    another = render(generator, scenes[0], settings, rng=random_stream(7, "render_cgan", 1))
    assert (another != forwards[0]).any()


def test_the_image_has_the_size_of_the_scene_and_a_taller_one_adds_rows_and_changes_none(
    generator, rng
):
    for size in ((300, 64), (77, 33), (5, 1)):
        image = render(generator, level(*size, row=2.0), SETTINGS, rng=rng)
        assert (image.shape, image.dtype) == (size, np.uint8)
    short, tall = (render(generator, level(n), SETTINGS, rng=SILENCE) for n in (144, 800))
    # 4 halvings of 4x4 kernels, and two of 3x3, reach 48 rows up from the edge; float32 may round
    # to the next byte.
    assert np.abs(short.astype(int)[:96] - tall[:96]).max() <= 1
    assert short.std() > 0


def test_a_layer_deeper_than_any_is_drawn_as_those_above_it(generator):
    # Far below the surface depth has ended to matter: what is around a layer is all that does.
    layers = np.repeat([[20.0], [1500.0], [1596.0]], 64, axis=1)
    image = render(generator, Scene("deep", 1700, layers), SETTINGS, rng=SILENCE).astype(int)
    assert np.abs(image[1480:1520] - image[1576:1616]).max() <= 1


def test_told_levels_scale_grain_add_fades_and_make_the_brightest_pixel_white(generator):
    scene = level(96)
    plain = render(generator, scene, SETTINGS, rng=SILENCE).astype(float)
    fades = np.zeros((96, 64))
    fades[40:, 32:] = -20
    told = Levels(np.ones((1, 64)), np.ones((96, 64)), fades=fades)
    faded = render(generator, scene, SETTINGS, levels=told, rng=SILENCE)
    white = 255 / (plain + fades).max()
    # Both are rounded, the first before it is scaled.
    assert_allclose(faded, (plain + fades) * white, atol=0.5 + white)
    assert faded.max() == 255

    def relative_grain(contrast):
        levels = replace(told, contrast=contrast, fades=0.0)
        rng = random_stream(1, "contrast")
        rows = render(generator, scene, SETTINGS, levels=levels, rng=rng)[60:80].astype(float)
        return (rows - rows.mean(axis=1, keepdims=True)).std() / rows.mean()

    # An untrained network has little grain, of 2 levels or so at 3: rounding adds 1/12 to its
    # variance.
    assert_allclose(relative_grain(9.0) / relative_grain(3.0), 3, rtol=0.03)


def test_scenes_without_layers_in_their_window_are_refused(generator, rng):
    with pytest.raises(ValueError, match="scene level: mask without layers"):
        render(generator, level(20, row=30.0), SETTINGS, rng=rng)


def test_weights_that_are_not_finite_are_refused(rng):
    diverged = untrained(SETTINGS)
    with torch.no_grad():
        diverged.last.bias.fill_(torch.nan)
    with pytest.raises(FloatingPointError, match="not finite: its training diverged"):
        render(diverged, level(64), SETTINGS, rng=rng)


def test_scenes_outside_what_was_trained_on_are_named_with_the_quantity():
    scope = scope_of(toy_scenes(4))
    assert scope["height"] == [96, 96]
    assert scope["layers"] == [3, 3]
    inside = toy_scenes(4)[2]
    assert outside(inside, scope) == []
    tall = replace(inside, n_range_bins=200)
    assert outside(tall, scope) == ["height 200, trained on 96 to 96"]
    steep = replace(inside, layer_bins=inside.layer_bins + 3.0 * np.arange(64))
    close = replace(inside, layer_bins=inside.layer_bins[2:3] + 4.0 * np.arange(4)[:, None])
    assert [phrase.split()[0] for scene in (steep, close) for phrase in outside(scene, scope)] == [
        "slope",
        "spacing",
    ]
