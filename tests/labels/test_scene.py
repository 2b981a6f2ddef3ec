import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from planted_labels import N_LINES, PLAIN_RELIEF, RELIEF, SPACING_M, planted
from refusals import refusal

from reference import checked_settings, draw_climate
from reference import draw_scene as reference_scene
from snowsim.echogram import check_layer_bins, scene_height
from snowsim.front import REFERENCE
from snowsim.io import read_dataset
from snowsim.labels import draw, draw_scene, prepare
from snowsim.labels.undulations import draw_stationary
from snowsim.seeding import random_stream

LAGS = np.array([1, 4, 16, 64, N_LINES - 1])  # scenes do not meet their own beginning again


def change_of(series, lag):
    """Mean square change of series (..., range_line) over some lines."""
    return np.square(series[..., lag:] - series[..., :-lag]).mean()


def law_of(zone, lag):
    """Mean square change of a layer by itself and of a slab, by its formula."""
    law = {name: values[zone] for name, values in RELIEF.items()}
    lag_m = SPACING_M * lag
    falls = np.exp(-((lag_m / law["relief_length_m"]) ** law["relief_exponent"]))
    of_slab = law["slab_change_bins2"] * (lag_m / 1000) ** law["slab_exponent"]
    return 2 * law["relief_variance_bins2"] * (1 - falls), of_slab


@pytest.fixture(scope="module")
def drawn():
    rng = np.random.default_rng(20120429)
    model = prepare(planted(), N_LINES)
    return [draw_scene(model, N_LINES, name=f"{i}", rng=rng) for i in range(1000)]


def test_all_layers_are_labelled_never_cross_and_are_as_many_as_in_the_flight(drawn):
    for scene in drawn:
        check_layer_bins(scene.layer_bins)
        assert np.diff(scene.layer_bins, axis=0).min() >= 1
        assert_array_equal(scene.complete_layer_bins, scene.layer_bins)
        assert scene.n_range_bins == scene_height(scene.layer_bins)
        # As files hold them, with a pixel for each.
        assert_array_equal(scene.layer_bins, scene.layer_bins.astype(np.float32))
        assert scene.mask().sum() == scene.layer_bins.size
    n_layers = np.array([len(scene.layer_bins) - 1 for scene in drawn])
    assert_array_equal(n_layers, [scene.notes["n_layers"] for scene in drawn])
    assert set(n_layers) == set(range(3, 9))


def test_draw_and_draw_scene_are_one_and_the_same_seed_gives_the_same_bytes():
    statistics = planted()
    one = draw(statistics, N_LINES, rng=np.random.default_rng(1))
    model = prepare(statistics, N_LINES)
    draw(model, N_LINES, rng=np.random.default_rng(2))  # what is kept from it changes nothing
    other = draw_scene(model, N_LINES, name="", rng=np.random.default_rng(1)).layer_bins
    assert one.tobytes() == other.tobytes()


def test_first_thickness_fixes_the_zone_and_is_distributed_as_in_the_flight(drawn):
    first = np.array([scene.notes["first_thickness_bins"] for scene in drawn])
    edges = planted()["zone_edge_bins"].values
    zone = np.array([scene.zone for scene in drawn])
    assert ((first >= edges[zone]) & (first < edges[zone + 1])).all()
    # Uniform over 25 bins: mean 27.5 to 7.2 / sqrt(1000) = 0.23; allow four.
    assert_allclose(first.mean(), 27.5, atol=0.91)
    thickness = [(scene.layer_bins[1] - scene.layer_bins[0]).mean() for scene in drawn]
    # Thickness is a multiple of 2^-12 bins.
    assert_allclose(thickness, first, atol=2**-12)


def test_means_of_slabs_scatter_as_in_the_flight(drawn):
    anomaly = np.full((len(drawn), 8), np.nan)
    for scene, of_scene in zip(drawn, anomaly, strict=True):
        mean = np.diff(scene.layer_bins, axis=0).mean(axis=1)
        of_scene[: mean.size] = mean / mean[0] - (1 - 0.02 * np.arange(mean.size))
    # The deepest slab is that of 1000 / 6 scenes: means to 0.1 / sqrt(167) = 0.008; allow four.
    assert_allclose(np.nanmean(anomaly, axis=0), 0, atol=0.032)
    assert_allclose(np.nanvar(anomaly[:, 1:], axis=0).mean(), 0.01, rtol=0.1)
    # Each for itself: some 3000 pairs of neighbours, to 0.02; allow four.
    product = np.nanmean(anomaly[:, 1:-1] * anomaly[:, 2:])
    assert_allclose(product / 0.01, 0, atol=0.08)


@pytest.mark.parametrize("zone", range(4))
def test_layers_and_slabs_change_by_the_law_of_the_zone(drawn, zone):
    scenes = [scene.layer_bins for scene in drawn if scene.zone == zone]
    for lag in LAGS:
        of_layer, of_slab = law_of(zone, lag)
        for apart in (1, 3):
            found = [change_of(bins[apart:] - bins[:-apart], lag) for bins in scenes]
            # 250 scenes of 3 to 8 layers: from 64 lines on some 700 independent changes, whose mean
            # square is known to sqrt(2 / 700) = 5 %; allow four.
            assert_allclose(np.mean(found), 2 * of_layer + apart * of_slab, rtol=0.2)


def test_a_covariance_that_no_circle_holds_keeps_its_variance(rng):
    # As long as the circle: half of the eigenvalues are negative.
    covariance = 1.0 * (np.arange(65) < 40)
    series = draw_stationary(np.tile(covariance, (4000, 1)), 64, rng=rng)
    assert_allclose(series.var(), 1, rtol=4 * np.sqrt(2 / 4000))


def test_the_surface_moves_slowly_and_by_what_levelling_leaves(drawn):
    rows = np.array([scene.layer_bins[0] for scene in drawn])
    assert_allclose(rows.mean(), 50, atol=0.05)
    for lag in (8, 32, 128):
        slow = 2 * 0.8**2 * (1 - np.exp(-((lag * SPACING_M / 200) ** 2)))
        # Levelling leaves a fraction uniform within a bin: 1 / 6; 1000 rows to 5 %.
        assert_allclose(change_of(rows, lag), slow + 1 / 6, rtol=0.15)
    still = planted(surface_movement_bins=0.0, surface_error_bins=0.0)
    assert_array_equal(draw(still, N_LINES, rng=1)[0], 50)


def test_thin_slabs_are_mirrored_and_counted(drawn):
    n_touched = sum(scene.notes["n_touched"] for scene in drawn)
    assert n_touched < 0.01 * sum(scene.notes["n_samples"] for scene in drawn)
    rough = planted(relief_variance_bins2=np.full(4, 400.0))
    scene = draw_scene(rough, N_LINES, name="rough", rng=np.random.default_rng(3))
    assert 0 < scene.notes["n_touched"] < scene.notes["n_samples"]
    assert np.diff(scene.layer_bins, axis=0).min() >= 1
    assert scene.mask().sum() == scene.layer_bins.size


def test_slabs_below_the_flight_take_the_mean_of_its_last():
    statistics = planted(3, relative_thickness_variance=np.zeros((4, 3)), **PLAIN_RELIEF)
    by_layers = np.zeros((4, 10))
    by_layers[:, 9] = 1
    statistics["n_blocks_by_layers"] = ("zone", "deep"), by_layers
    statistics = statistics.rename(deep="n_layers")
    thickness = np.diff(draw(statistics, 64, rng=np.random.default_rng(4)), axis=0)
    assert len(thickness) == 9
    assert_allclose(thickness[2:] / thickness[0], 0.96, atol=2**-11)


def test_as_many_scenes_have_no_layer_as_blocks_of_the_flight():
    statistics = planted(n_layers=(2, 3)).assign_attrs(n_blocks=10, n_blocks_without_layers=3)
    model = prepare(statistics, 32)
    rng = np.random.default_rng(1)
    scenes = [draw_scene(model, 32, name="", rng=rng) for _ in range(400)]
    n_layers = np.array([len(scene.layer_bins) - 1 for scene in scenes])
    # Binomial of 0.3: 0.023 of 400; allow four.
    assert_allclose((n_layers == 0).mean(), 0.3, atol=0.092)
    assert set(n_layers) == {0, 2, 3}


@pytest.mark.parametrize("n_range_lines", [2, 64, 300, 1024])
def test_a_scene_has_the_width_asked_for(n_range_lines):
    scene = draw_scene(planted(), n_range_lines, name="", rng=np.random.default_rng(5))
    assert scene.layer_bins.shape[1] == scene.echoes.power.shape[1] == n_range_lines


@pytest.mark.parametrize(
    ("lacking", "message"),
    [
        ("relief_length_m", "need relief_length_m, all finite"),
        ("noise_spread_db", "need noise_spread_db"),
    ],
)
def test_label_models_name_what_statistics_lack(lacking, message):
    with refusal(message):
        prepare(planted().drop_vars(lacking), N_LINES)


def test_impossible_widths_are_refused(rng):
    with refusal("prepared for 256 range lines, got 128"):
        draw(prepare(planted(), N_LINES), 128, rng=rng)
    with refusal("n_range_lines must be a whole number of at least 2"):
        draw(planted(), 1, rng=rng)


def test_layers_of_the_packaged_flight_change_along_track_as_annotated_ones():
    """The picker's errors, as long as the lines that it averages, look like relief."""
    seed = 20120429
    settings = checked_settings({})
    climate = draw_climate(settings, rng=random_stream(seed, "climate"))
    annotated = []
    for scene in range(12):
        rng = random_stream(seed, "reference_scenes", "validation", scene)
        truth = reference_scene(
            scene, "validation", climate=climate, settings=settings, n_looks=16, rng=rng
        )
        annotated.append(truth.complete_layer_bins)
    model = prepare(read_dataset(REFERENCE), N_LINES)
    drawn = [draw(model, N_LINES, rng=np.random.default_rng(number)) for number in range(200)]
    for lag in LAGS[1:-1]:
        # From line to line, whole-bin picks do not tell; the median of 12 scenes scatters by a
        # quarter.
        assert 0.5 < median_change(drawn, lag) / median_change(annotated, lag) < 2


def median_change(scenes, lag):
    """Median over scenes of the mean square change of their slabs' thickness over some lines."""
    slabs = [np.diff(layer_bins, axis=0) for layer_bins in scenes if len(layer_bins) > 1]
    return np.median([change_of(thickness, lag) for thickness in slabs])
