"""Levels that a generator is told in rendering are those that it learnt from observed images."""

import numpy as np
from numpy.testing import assert_allclose
from toy_scenes import toy_scene, with_echoes

from snowsim.cgan.inputs import expected_image, inputs_of, known_map, snow_level
from snowsim.echogram import to_uint8
from snowsim.phy import render_echoes


def test_phys_mean_power_tells_the_levels_that_its_renders_have(rng):
    scene = with_echoes(toy_scene(3, 160, 128))
    power = render_echoes(scene.echoes, 160, rng=rng, exact=True)
    image = to_uint8(power)[0]
    expected, observed = (
        known_map(levels, scene.layer_bins, snow_level(levels))
        for levels in (expected_image(scene), image)
    )
    # The same of depths and slabs, which do not depend on levels.
    assert_allclose(expected[..., [0, 2, 3, 4, 5]], observed[..., [0, 2, 3, 4, 5]], atol=0)
    error = expected - observed
    # The surface stands at 40 dB and spans two units of the inputs. Speckle of 16 looks is 1.1 dB,
    # in means of 33 lines 0.2 dB or 0.01; four times that.
    assert np.abs(error[..., 1]).max() < 0.04
    # Means over 1,000 pixels or more: but an image counts from the darkest of its rows, a quarter
    # of a decibel below the mean noise, or 0.0125.
    assert np.sqrt(np.mean(error[..., 6] ** 2)) < 0.02


def test_layers_that_nobody_picked_everywhere_are_bridged_and_tell_no_level_there():
    scene = toy_scene(1)
    gap = scene.layer_bins.copy()
    gap[1, 20:30] = np.nan
    known = known_map(scene.image, gap, snow_level(scene.image))
    inputs, slabs = inputs_of(known[None])
    assert inputs.shape == (1, 6, 96, 64)
    assert (np.diff(slabs[0], axis=0) >= 0).all()
    assert (slabs[0, -1] == 4).all()
    n_marked = (inputs[0, 0] > -1).sum(dim=0).numpy()
    assert (n_marked[:20] == 4).all()
    assert (n_marked[20:30] == 3).all()
