import numpy as np
import pandas as pd
import pytest
from numpy.testing import assert_array_equal
from refusals import refusal

from reference import draw_scene
from reference.benchmark import SLOTS, scene_position
from reference.line import line_length_km
from snowsim.echogram import check_layer_bins, scene_height
from snowsim.seeding import random_stream


def scene(climate, index, split, **options):
    rng = random_stream(1, "scenes", split, index)
    how = {"climate": climate, "settings": climate.settings, "n_looks": 16, "rng": rng}
    return draw_scene(index, split, **how, **options)


@pytest.fixture(scope="module")
def scenes(climate):
    return {
        split: [scene(climate, index, split) for index in range(6)] for split in ("train", "test")
    }


def test_scenes_of_all_splits_are_disjoint_and_few_cover_the_line_as_many_do():
    scene_km = 256 * 5.47e-3
    for split in ("train", "validation", "test"):
        places = [scene_position(index, split, line_length_km()) for index in range(SLOTS + 20)]
        for track, starts in pd.DataFrame(places).groupby(0)[1]:
            assert track.startswith(split)
            assert starts.max() + scene_km < line_length_km()
            assert starts.sort_values().diff().min() > scene_km
    starts = np.sort([scene_position(index, "test", 1200.0)[1] for index in range(20)])
    assert np.diff(starts, prepend=0, append=1200).max() < 150


def test_images_follow_the_rules_of_the_published_benchmark(scenes):
    for one in (*scenes["train"], *scenes["test"]):
        assert one.image.shape == (one.n_range_bins, 256)
        assert one.n_range_bins == scene_height(one.complete_layer_bins)
        assert one.n_range_bins >= 300
        assert abs(np.mean(one.complete_layer_bins[0]) - 50) < 3
        check_layer_bins(one.layer_bins)
    for one in scenes["test"]:  # fully annotated
        assert np.isfinite(one.layer_bins).all()
        assert_array_equal(one.layer_bins, one.complete_layer_bins)


def test_training_picks_miss_pixels_and_few_follow_another_layer(scenes):
    picked = np.concatenate([one.layer_bins.ravel() for one in scenes["train"]])
    truth = np.concatenate([one.complete_layer_bins.ravel() for one in scenes["train"]])
    found = np.isfinite(picked)
    assert 0.3 < found.mean() < 0.95
    error = np.abs(picked - truth)[found]
    # A picker's own errors end at 3 bins; 3 % of pieces behind a gap are of another layer.
    assert 0 < (error > 3).mean() < 0.04
    assert (error <= 2).mean() > 0.85
    for one in scenes["train"]:
        assert np.isfinite(one.layer_bins[0]).mean() > 0.9  # the surface is hard to miss


def test_scenes_differ_in_how_deep_layers_are_seen(climate, scenes):
    more = [scene(climate, index, "test") for index in range(6, 18)]
    n_layers = [len(one.layer_bins) - 1 for one in scenes["test"] + more]
    few = np.mean(np.array(n_layers) < 6)
    assert 0.25 < few < 0.8  # 57 % in the paper; 18 scenes leave 0.12 of standard error
    assert max(n_layers) > 15


def test_a_scene_too_long_for_its_place_is_refused(climate):
    with refusal("kilometres of 2000 range lines must"):
        scene(climate, 0, "test", n_range_lines=2000)
