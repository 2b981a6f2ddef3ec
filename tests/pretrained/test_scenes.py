"""What the shipped tracker is trained on: scenes of variants of the flight."""

import copy
from dataclasses import replace

import numpy as np
import pytest
import torch
from numpy.testing import assert_array_equal
from runs import CONFIG
from toy_scenes import toy_scene, with_echoes

from pretrained.card import digest_of, ranges_of, scores_for_card
from pretrained.resizing import in_bins
from pretrained.scenes import FirnRanges, firn_scene, labelled, on_lines, training_scenes
from snowsim.echogram import Scene
from snowsim.front import REFERENCE
from snowsim.io import read_dataset
from snowsim.patches import check_trainable
from snowsim.snowpack import Climate, Radar
from snowsim.statistics import Ranges
from snowsim.tracker import MultiScaleNetwork


@pytest.fixture(scope="module")
def flight():
    return read_dataset(REFERENCE)


def drawn(flight, variants, n_scenes):
    """Scenes of variants, of which those before the third are of the flight's statistics."""
    given = {"n_varied": 2, "n_range_lines": 64, "phy": CONFIG["phy"], "seed": 1}
    return list(training_scenes(flight, variants, n_scenes, **given))


def test_scenes_of_a_variant_do_not_depend_on_which_others_are_drawn(flight):
    together = drawn(flight, range(3), 2)
    names = [f"variant_{variant:03d}_{number:03d}" for variant in range(3) for number in range(2)]
    assert [scene.name for scene in together] == names
    for variant in (1, 2):
        (alone,) = drawn(flight, [variant], 1)
        scene = together[2 * variant]
        assert_array_equal(alone.image, scene.image)
        assert_array_equal(alone.layer_bins, scene.layer_bins)
    for scene in together:
        check_trainable(scene)


def test_of_clean_firn_layers_are_labelled_where_noise_does_not_hide_them():
    climate = Climate(accumulation_m=0.4)
    n_labelled = []
    for surface_to_noise_db in (5.0, 60.0):
        radar = Radar.preset("snow-2012", surface_to_noise_db=surface_to_noise_db)
        scene = firn_scene("", climate, radar, n_range_lines=64, rng=np.random.default_rng(1))
        labels = scene.layer_bins[np.isfinite(scene.layer_bins).all(axis=1)]
        assert np.isfinite(scene.layer_bins).sum() == labels.size
        n_labelled.append(len(labels))
        # The surface is brightest, and its label lies on the peak, half a bin by rounding, half by
        # speckle of 64 lines.
        assert abs(scene.image.mean(axis=1).argmax() - labels[0].mean()) <= 1
    # The same firn twice, 21 horizons.
    assert n_labelled[0] < n_labelled[1] / 2
    assert 18 <= n_labelled[1] <= 21


def test_lines_farther_apart_are_lines_left_out():
    scene = with_echoes(toy_scene(1))
    thinned = on_lines(scene, np.arange(0, 64, 2))
    assert_array_equal(thinned.layer_bins, scene.layer_bins[:, ::2])
    assert_array_equal(thinned.echoes.bins, scene.echoes.bins[:, ::2])
    assert_array_equal(thinned.echoes.power, scene.echoes.power[:, ::2])


@pytest.mark.parametrize(
    ("power", "hidden"),
    [([0.5, 0.2, 0.5, 0.5], []), ([0.5, 0.2, 0.5, 0.2], [3]), ([0.5, 1e-3, 0.5, 0.5], [1])],
)
def test_labels_end_where_layers_fade_as_truth_does_and_spare_what_noise_hides(power, hidden):
    scene = with_echoes(toy_scene(1))
    # Over noise of 1 powers of .2 and .5 rise by .8 and 1.8 dB at most; truth ends at 1 dB.
    scene.echoes.power[:] = np.array(power)[:, None]
    echoes = replace(scene.echoes, noise_power=1.0)
    seen = labelled(replace(scene, echoes=echoes, complete_layer_bins=scene.layer_bins))
    expected = scene.layer_bins.copy()
    expected[hidden] = np.nan
    assert_array_equal(seen.layer_bins, expected)
    assert_array_equal(seen.complete_layer_bins, scene.layer_bins)


def test_a_layer_lies_on_the_same_snow_after_resampling_to_larger_bins():
    layer_bins = np.full((1, 64), 200.5)
    away = np.arange(320)[:, None] - layer_bins
    image = np.uint8(255 * np.exp(-(away**2) / 50))
    smaller = in_bins(Scene("one layer", 320, layer_bins, image=image), 0.6)
    brightness = smaller.image[:, 0].astype(float)
    middle = (brightness * np.arange(192)).sum() / brightness.sum()
    # Eight bits of brightness on some 20 rows.
    assert abs(middle - smaller.layer_bins[0, 0]) < 0.05


def test_the_digest_is_of_every_weight():
    network = MultiScaleNetwork(2)
    network.initialise(rng=np.random.default_rng(1))
    before = digest_of(network)
    assert digest_of(copy.deepcopy(network)) == before
    with torch.no_grad():
        network.fuse.bias += 1e-6
    assert digest_of(network) != before


def test_ranges_of_the_card_hold_both_kinds_of_scenes(flight):
    alone = ranges_of(flight, Ranges(), FirnRanges(surface_to_noise_db=(20, 21), n_looks=(5, 6)))
    found = ranges_of(flight, Ranges(), FirnRanges(surface_to_noise_db=(20, 70), n_looks=(1, 6)))
    assert found["surface_to_noise_db"] == [alone["surface_to_noise_db"][0], 70]
    assert found["n_looks"] == [1, alone["n_looks"][1]]


def test_scores_of_the_card_are_those_of_the_table_if_there_is_one(tmp_path):
    table = tmp_path / "transfer.csv"
    names = "flight,tracker,ods,recall,precision,f,missed_share,false_share"
    table.write_text(f"{names}\na,universal,.81234,.5,.5,.5,.1,.2\n")
    scores = scores_for_card({str(table): "digest"})
    assert [row["flight"] for row in scores] == ["a"]
    assert scores[0]["ods"] == 0.812
    assert scores_for_card({}) is None
