"""Levels that label sets are expected to have are those that PHY renders."""

from dataclasses import replace

import numpy as np
from numpy.testing import assert_allclose, assert_array_equal

from snowsim.cgan.brightness import expected_levels
from snowsim.cgan.fades import draw_fades
from snowsim.cgan.inputs import observed_levels
from snowsim.echogram import to_db
from snowsim.front import REFERENCE
from snowsim.io.files import read_dataset
from snowsim.labels import Dress, draw_scene, prepare
from snowsim.phy import render_scene
from snowsim.seeding import random_stream


def test_layers_and_snow_of_phys_render_are_as_bright_as_expected():
    flight = read_dataset(REFERENCE)
    model = prepare(flight, 64, dress=Dress(n_looks=16))
    labels = draw_scene(model, 64, name="bright", rng=np.random.default_rng(1))
    rng = random_stream(7, "render_phy", labels.name)
    render = render_scene(labels, rng=rng)
    observed = observed_levels(render.image, labels.layer_bins, labels.n_range_bins)
    expected = expected_levels(labels, flight)
    error = expected.of_layers - observed.of_layers
    # Three times the speckle of 16 looks in means of 33 lines, 0.19 dB, of the surface's 40 dB; and
    # some for its tails.
    assert np.sqrt(np.nanmean(error**2)) < 0.02
    # Means over 2,000 pixels, or 30 patches of texture of 0.6 dB and 60 gains of 0.4 dB: 0.15 dB of
    # 40. Where the surface rises 40 dB in a bin, a tenth of a bin is 4 dB, of 25 bins 0.16 dB.
    error = expected.of_snow - observed.of_snow
    assert np.sqrt(np.mean(error**2)) < 0.015


def test_a_scene_high_above_its_noise_has_less_contrast_and_fades_are_asked_for():
    flight = read_dataset(REFERENCE)
    model = prepare(flight, 64, dress=Dress(n_looks=16))
    labels = draw_scene(model, 64, name="bright", rng=np.random.default_rng(1))
    levels = expected_levels(labels, flight)
    quieter = replace(labels.echoes, noise_power=labels.echoes.noise_power / 10)
    of_quieter = expected_levels(replace(labels, echoes=quieter), flight)
    # 10 dB more between uppermost layer and noise.
    raised_db = levels.contrast / of_quieter.contrast
    usual_db = np.nanmean(to_db(labels.echoes.power[0] / labels.echoes.noise_power)) + 10
    assert_allclose(raised_db, 1 + 10 / usual_db, rtol=0.01)

    assert np.all(levels.fades == 0)
    faded = expected_levels(labels, flight, fade_spread=3.0, rng=np.random.default_rng(2)).fades
    drawn = draw_fades(labels.layer_bins[0], labels.n_range_bins, 3.0, rng=np.random.default_rng(2))
    assert_array_equal(faded, drawn)
