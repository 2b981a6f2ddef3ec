"""Drawn scenes: layers as the flight has them, and their echoes, in files, too."""

import dataclasses

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from numpy.testing import assert_allclose, assert_array_equal
from planted_labels import N_LINES, PLAIN_RELIEF, RELIEF, SPACING_M, law, planted
from refusals import refusal

from snowsim.echogram import Echoes, Kind, check_layer_bins, scene_height
from snowsim.io import SceneSet, write_scenes
from snowsim.labels import draw, draw_scene, prepare, with_waveforms_of
from snowsim.labels.undulations import draw_stationary

LAGS = np.array([1, 4, 16, 64, N_LINES - 1])  # scenes do not meet their own beginning again


def change_of(series, lag):
    """Mean square change of series (..., range_line) over some lines."""
    return np.square(series[..., lag:] - series[..., :-lag]).mean()


@pytest.fixture(scope="module")
def drawn():
    rng = np.random.default_rng(20120429)
    model = prepare(planted(), N_LINES)
    return [draw_scene(model, N_LINES, name=f"{i}", rng=rng) for i in range(1000)]


def test_all_layers_are_labelled_never_cross_and_are_as_many_as_in_the_flight(drawn):
    for scene in drawn:
        check_layer_bins(scene.layer_bins)
        assert_array_equal(scene.complete_layer_bins, scene.layer_bins)
        assert scene.n_range_bins == scene_height(scene.layer_bins)
        # As files hold them, with a pixel for each.
        assert_array_equal(scene.layer_bins, scene.layer_bins.astype(np.float32))
        assert scene.mask().sum() == scene.layer_bins.size
    n_layers = np.array([len(scene.layer_bins) - 1 for scene in drawn])
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
    means = (np.diff(scene.layer_bins, axis=0).mean(axis=1) for scene in drawn)
    mean = pd.DataFrame(dict(enumerate(of_scene)) for of_scene in means)
    anomaly = mean.div(mean[0], axis=0) - (1 - 0.02 * np.arange(8))
    # The deepest slab is that of 1000 / 6 scenes: means to 0.1 / sqrt(167) = 0.008; allow four.
    assert_allclose(anomaly.mean(), 0, atol=0.032)
    assert_allclose(anomaly.var()[1:].mean(), 0.01, rtol=0.1)
    # Each for itself: some 3000 pairs of neighbours, to 0.02; allow four.
    product = anomaly[range(1, 7)].to_numpy() * anomaly[range(2, 8)]
    assert_allclose(np.nanmean(product) / 0.01, 0, atol=0.08)


@pytest.mark.parametrize("zone", range(4))
def test_layers_and_slabs_change_by_the_law_of_the_zone(drawn, zone):
    scenes = [scene.layer_bins for scene in drawn if scene.zone == zone]
    relief = {name: values[zone] for name, values in RELIEF.items()}
    for lag in LAGS:
        of_layer, of_slab = law(relief, SPACING_M * lag)
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


def test_slabs_below_the_flight_take_the_mean_of_its_last():
    statistics = planted(3, relative_thickness_variance=np.zeros((4, 3)), **PLAIN_RELIEF)
    by_layers = np.tile(1.0 * (np.arange(10) == 9), (4, 1))
    statistics = statistics.drop_vars("n_blocks_by_layers")
    statistics["n_blocks_by_layers"] = ("zone", "n_layers"), by_layers
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


@pytest.mark.parametrize("n_range_lines", [2, 1024])
def test_a_scene_has_the_width_asked_for(n_range_lines, rng):
    scene = draw_scene(planted(), n_range_lines, name="", rng=rng)
    assert scene.layer_bins.shape[1] == scene.echoes.power.shape[1] == n_range_lines


def test_statistics_that_lack_something_and_impossible_widths_are_refused(rng):
    with refusal("need relief_length_m, all finite"):
        prepare(planted().drop_vars("relief_length_m"), N_LINES)
    with refusal("prepared for 256 range lines, got 128"):
        draw(prepare(planted(), N_LINES), 128, rng=rng)
    with refusal("n_range_lines must be a whole number of at least 2"):
        draw(planted(), 1, rng=rng)


def test_the_background_starts_at_the_surface_and_further_echoes_below_the_last_layer(drawn):
    n_further = 0
    for scene in drawn:
        echoes = scene.echoes
        assert echoes.power.shape == echoes.bins.shape
        assert (echoes.power > 0).all()
        assert_array_equal(echoes.bins[echoes.kind == Kind.LAYER], scene.layer_bins)
        background = echoes.bins[echoes.kind == Kind.BACKGROUND]
        assert (background > scene.layer_bins[0]).all()
        assert (background < scene.layer_bins[0] + 1).all()
        further = echoes.bins[echoes.kind == Kind.BELOW]
        assert (further > scene.layer_bins[-1]).all()
        n_further += len(further)
    # Some 100 bins below the last layer, 30 apart.
    assert_allclose(n_further / len(drawn), 100 / 30, rtol=0.2)


def test_power_and_noise_keep_the_mean_of_the_flight(drawn):
    surface = np.array([scene.echoes.power[0].mean() for scene in drawn])
    noise = np.array([scene.echoes.noise_power for scene in drawn])
    # A lognormal of 1.6 dB scatters by 0.38 of its mean: 1000 of them by 0.012; allow four.
    assert_allclose(surface.mean(), 1, atol=0.05)
    assert_allclose(noise.mean(), 1e-3, rtol=0.05)


def test_files_keep_the_echoes_and_describe_them(drawn, tmp_path):
    write_scenes(tmp_path / "labels.nc", drawn[:3])
    with SceneSet(tmp_path / "labels.nc") as scenes:
        scene = scenes[1]
    for field in dataclasses.fields(Echoes):
        before = getattr(drawn[1].echoes, field.name)
        assert_array_equal(getattr(scene.echoes, field.name), before, err_msg=field.name)
    with xr.open_dataset(tmp_path / "labels.nc", group="echoes") as group:
        assert group["decay_rate"].attrs["units"] == "bin-1"
        assert group["kind"].attrs["flag_meanings"] == "layer background below"


def test_other_statistics_change_waveforms_and_leave_rows_and_powers(drawn):
    scene = drawn[3]
    flight = planted()
    same = with_waveforms_of(scene, flight)
    other = with_waveforms_of(scene, flight.assign(variance_bins2=2 * flight["variance_bins2"]))
    for name in ("bins", "power", "kind", "decay_rate"):
        assert_array_equal(getattr(other, name), getattr(scene.echoes, name), err_msg=name)
    assert_array_equal(same.variance_bins2, scene.echoes.variance_bins2)
    assert_array_equal(other.variance_bins2, 2 * scene.echoes.variance_bins2)
