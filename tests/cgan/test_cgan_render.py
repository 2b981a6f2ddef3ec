"""Rendering depends on the generator, the layers and the scene's random stream, on nothing else."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import torch
from numpy.testing import assert_array_equal
from refusals import refusal
from toy_scenes import toy_scene, toy_scenes, with_echoes

from snowsim.cgan import Settings, Training, render, trained_generator
from snowsim.echogram import Scene
from snowsim.seeding import random_stream

SETTINGS = Settings(width=4, depth=4, n_steps=1, n_range_bins=64, n_range_lines=64)
SILENCE = SimpleNamespace(random=np.ones, standard_normal=np.zeros)  # random numbers that are none
PIX2PIX = replace(SETTINGS, method="pix2pix")


def untrained(settings):
    weights = Training(settings, seed=1).generator.state_dict()
    return trained_generator({name: weights[name].numpy() for name in weights}, settings)


@pytest.fixture(scope="module")
def generator():
    return untrained(SETTINGS)


def level(n_range_bins, n_range_lines=64, row=20.0):
    """A scene of one level layer, with its echo."""
    return with_echoes(Scene("level", n_range_bins, np.full((1, n_range_lines), row)))


@pytest.mark.parametrize("settings", [SETTINGS, PIX2PIX], ids=["measured", "pix2pix"])
def test_a_scene_depends_on_its_stream_and_not_on_the_scenes_rendered_before_it(settings):
    generator = untrained(settings)
    scenes = list(map(with_echoes, toy_scenes(2)))

    def rendered(number, stream):
        rng = random_stream(7, "render_cgan", stream)
        return render(generator, scenes[number], settings, rng=rng)

    first = rendered(0, stream=0)
    assert (rendered(0, stream=1) != first).any()
    rendered(1, stream=1)
    assert_array_equal(rendered(0, stream=0), first)


def test_the_image_has_the_size_of_the_scene_and_a_taller_one_adds_rows_and_changes_none(
    generator, rng
):
    for size in ((300, 64), (77, 33), (5, 1)):
        image = render(generator, level(*size, row=2.0), SETTINGS, rng=rng)
        assert (image.shape, image.dtype, image.max()) == (size, np.uint8, 255)
    short, tall = (render(generator, level(n), SETTINGS, rng=SILENCE) for n in (144, 800))
    # 4 halvings of 4x4 kernels, and two of 3x3, reach 48 rows up from the edge. Each image is
    # scaled by its own brightest pixel; rounded before and after, and to the next byte in float32.
    scale = short[:96].sum() / tall[:96].sum()
    assert np.abs(short[:96] - scale * tall[:96]).max() <= 2
    assert short.std() > 0


def test_a_layer_deeper_than_any_is_drawn_as_those_above_it(generator):
    # Far below the surface depth has ended to matter: what is around a layer is all that does, and
    # a level of half of the surface's power or a quarter is 3 dB of 40 apart.
    layers = np.repeat([[20.0], [1500.0], [1596.0]], 64, axis=1)
    scene = with_echoes(Scene("deep", 1700, layers))
    scene.echoes.power[1:] = 0.5
    image = render(generator, scene, SETTINGS, rng=SILENCE).astype(int)
    assert np.abs(image[1480:1520] - image[1576:1616]).max() <= 1


def test_scenes_without_layers_in_their_window_are_refused(generator, rng):
    with refusal("scene level: mask without layers"):
        render(generator, level(20, row=30.0), SETTINGS, rng=rng)


def test_the_recipe_that_knows_levels_needs_echoes(generator, rng):
    with refusal("scene toy 1: expected echoes.*snowsim.labels.echoes_of_layers"):
        render(generator, toy_scene(1), SETTINGS, rng=rng)


def test_weights_that_are_not_finite_are_refused(rng):
    diverged = untrained(SETTINGS)
    with torch.no_grad():
        diverged.last.bias.fill_(torch.nan)
    with pytest.raises(FloatingPointError, match="not finite: its training diverged"):
        render(diverged, level(64), SETTINGS, rng=rng)
