import numpy as np
from numpy.testing import assert_allclose
from planted_labels import N_LINES, PLAIN_RELIEF, planted
from refusals import refusal

from snowsim.labels import Nonstationary, draw_scene, prepare

# Without undulations and spread of means: trend and fold alone bend layers.
SMOOTH = planted(
    n_layers=(5, 12),
    relative_thickness_variance=np.zeros((4, 20)),
    surface_movement_bins=0.0,
    surface_error_bins=0.0,
    **PLAIN_RELIEF,
)


def scenes(statistics, nonstationary, n=200):
    model = prepare(statistics, N_LINES, nonstationary=nonstationary)
    rng = np.random.default_rng(7)
    return [draw_scene(model, N_LINES, name=f"{i}", rng=rng) for i in range(n)]


def test_a_trend_is_found_again_and_leaves_the_mean():
    line = np.arange(N_LINES) / (N_LINES - 1) - 0.5
    with_trend = scenes(SMOOTH, Nonstationary(trend_sd=0.2))
    for scene in with_trend:
        thickness = np.diff(scene.layer_bins, axis=0)
        slope = thickness @ line / (line @ line) / thickness.mean(axis=1)
        # Thickness is a multiple of 2^-12 bins, of 15 or more.
        assert_allclose(slope, scene.notes["trend"], atol=2**-14)
        first_bins = scene.notes["first_thickness_bins"]
        assert_allclose(thickness[0].mean(), first_bins, atol=2**-12)
    trends = np.array([scene.notes["trend"] for scene in with_trend])
    # 200 normal values: their s.d. to 5 %; allow four of those.
    assert_allclose(trends.std(), 0.2, rtol=0.2)


def test_a_fold_bends_layers_in_proportion_to_their_depth():
    for scene in scenes(SMOOTH, Nonstationary(fold_sd_bins=6.0, fold_length_lines=48.0), n=40):
        bins = scene.layer_bins
        # Thickness is a multiple of 2^-12 bins; a crest may lie half a line beside one.
        atol = len(bins) * 2**-11
        assert_allclose(bins[:, 48:], bins[:, :-48], atol=atol)
        amplitude = np.ptp(bins, axis=1) / 2
        expected = abs(scene.notes["fold_bins"])
        assert_allclose(amplitude[-1], expected, rtol=0.01, atol=atol)
        assert amplitude[0] == 0
        depth = bins.mean(axis=1) - 50
        # The thickness of a slab holds a little of the fold in its mean, 48 lines do not divide
        # 256: to 10 %.
        assert_allclose(amplitude, expected * depth / depth[-1], rtol=0.1, atol=atol)


def test_only_the_zones_asked_for_are_bent():
    for scene in scenes(planted(), Nonstationary(trend_sd=0.1, fold_sd_bins=2, zones=(0, 3)), n=60):
        assert ("trend" in scene.notes) == ("fold_bins" in scene.notes) == (scene.zone in (0, 3))


def test_trends_and_folds_keep_layers_apart_and_are_counted():
    bent = scenes(SMOOTH, Nonstationary(trend_sd=1.0, fold_sd_bins=80.0), n=60)
    assert all(np.diff(scene.layer_bins, axis=0).min() >= 1 - 1e-9 for scene in bent)
    assert sum(scene.notes["n_touched"] for scene in bent) > 0


def test_impossible_settings_are_refused():
    with refusal("fold_length_lines must be finite, at least 4, got 3"):
        Nonstationary(fold_length_lines=3)
