"""Scenes drawn with radiometry: what they keep, who is labelled, and what comes back from their renders."""

import numpy as np
import pytest
import xarray as xr
from numpy.testing import assert_allclose, assert_array_equal
from planted_labels import N_LINES, planted

from snowsim.echogram import check_layer_bins
from snowsim.io.scenes import SceneSet, write_scenes
from snowsim.labels import draw_scene, prepare
from snowsim.labels.radiometry import labelled_or_not
from snowsim.phy import plan, render_plan, scene_parameters

SPREADS = {
    "noise_spread_db": 1.5,
    "surface_to_noise_spread_db": 2.0,
    "common_spread_db": 3.0,
    "layer_spread_db": 2.0,
}
SPREADS |= {
    "decay_spread": 0.1,
    "background_spread_db": 1.0,
    "further_spacing_bins": 30.0,
    "further_rise_db": 1.0,
}
SPREADS |= {"end_contrast_db": 0.5}


def statistics(**changes):
    fading = {
        "fading_spread_db": [1.0, 2.0],
        "fading_length_lines": [20.0, 40.0],
        "fading_exponent": [1.0, 2.0],
    }
    variables = {
        name: ((), value) for name, value in (SPREADS | {"noise_power": 1e-3} | changes).items()
    }
    variables |= {name: ("interface", value) for name, value in fading.items()}
    by_layer = {
        "peak_power": 0.3 * 0.8 ** np.arange(8),
        "variance_bins2": np.full(8, 0.6),
        "decay_rate": [0.1] * 8,
    }
    by_layer["peak_power"][0] = 1
    variables |= {name: ("layer", values) for name, values in by_layer.items()}
    variables["background_power"] = ("fall", [0.0, 5e-3, 1e-3])
    return planted().merge(xr.Dataset(variables, coords={"fall": [30.0, 100.0, 1000.0]}))


@pytest.fixture(scope="module")
def drawn():
    model = prepare(statistics(), N_LINES, n_layers=(3, 8), radiometry="measured")
    rng = np.random.default_rng(1)
    return [draw_scene(model, N_LINES, name=f"{i}", rng=rng) for i in range(200)]


def test_every_layer_drawn_is_kept_and_labels_are_some_of_them(drawn):
    for scene in drawn:
        check_layer_bins(scene.complete_layer_bins)
        assert scene.peak_power.shape == scene.complete_layer_bins.shape
        assert (scene.peak_power > 0).all()
        assert scene.complete_layer_bins[1, 0] < scene.layer_bins[0, 0] + 1  # background
        whole, labelled = labelled_or_not(scene), np.isfinite(scene.layer_bins)
        assert labelled[0].all()
        assert_array_equal(scene.layer_bins[labelled], whole[labelled])
        # Down to the deepest that shows, on every range line.
        assert (labelled.all(axis=1) | ~labelled.any(axis=1)).all()
        assert (np.diff(labelled[:, 0].astype(int)) <= 0).all()
    share = np.mean([np.isfinite(scene.layer_bins[1:]).mean() for scene in drawn])
    assert 0.3 < share < 1, share


def test_texture_is_on_background_and_on_echoes_without_a_label(drawn):
    flight = statistics(texture_variance=0.02, texture_length_bins=12.0, texture_length_lines=2.0)
    flight = flight.assign(line_gain_spread_db=0.4).assign_attrs(n_looks=16.0)
    for scene in drawn[:20]:
        rows, parameters = scene_parameters(scene, flight, rng=np.random.default_rng(1))
        labelled = [row in scene.layer_bins[:, 0] for row in rows[:, 0]]
        assert_array_equal(parameters["textured_layers"], np.logical_not(labelled))


def test_power_and_noise_keep_the_mean_of_the_flight(drawn):
    surface = np.array([scene.peak_power[0].mean() for scene in drawn])
    noise = np.array([scene.notes["noise_power"] for scene in drawn])
    # A lognormal of 1.6 dB scatters by 0.38 of its mean: 200 of them by 0.027; allow four.
    assert_allclose(surface.mean(), 1, atol=0.11)
    assert_allclose(noise.mean(), 1e-3, rtol=0.11)


def test_as_many_scenes_have_no_layer_as_blocks_of_the_flight():
    given = statistics().assign_attrs(n_blocks=10, n_blocks_without_layers=3)
    given["n_blocks_by_layers"] = (
        ("zone", "n_layers"),
        np.tile([0, 0, 3, 4], (given.sizes["zone"], 1)),
    )
    model = prepare(
        given, N_LINES, n_layers="measured", first_slab="uniform", radiometry="measured"
    )
    rng = np.random.default_rng(1)
    n_layers = np.array(
        [len(draw_scene(model, N_LINES, name="", rng=rng).layer_bins) - 1 for _ in range(400)]
    )
    # Binomial of 0.3: 0.023 of 400; allow four.
    assert_allclose((n_layers == 0).mean(), 0.3, atol=0.092)
    assert set(n_layers) == {0, 2, 3}


def test_a_higher_contrast_at_the_ends_of_picks_leaves_fewer_labels(drawn):
    picky = prepare(
        statistics(end_contrast_db=3.0), N_LINES, n_layers=(3, 8), radiometry="measured"
    )
    rng = np.random.default_rng(1)
    fewer = [draw_scene(picky, N_LINES, name=f"{i}", rng=rng) for i in range(50)]
    for strict, scene in zip(fewer, drawn, strict=False):
        assert_array_equal(strict.peak_power, scene.peak_power)  # nothing else hangs on it
        assert (np.isfinite(strict.layer_bins) <= np.isfinite(scene.layer_bins)).all()
    assert sum(np.isfinite(scene.layer_bins).sum() for scene in fewer) < sum(
        np.isfinite(scene.layer_bins).sum() for scene in drawn[:50]
    )


def test_files_keep_radiometry_and_renders_follow_it(drawn, tmp_path):
    write_scenes(tmp_path / "labels.nc", drawn[:3])
    with SceneSet(tmp_path / "labels.nc") as scenes:
        scene = scenes[1]
    assert_allclose(scene.peak_power, drawn[1].peak_power, rtol=1e-6)  # float32
    assert_array_equal(scene.mask(), drawn[1].mask())
    layer_bins, parameters = scene_parameters(
        scene, statistics(), n_looks=1000, rng=np.random.default_rng(1)
    )
    scene_plan = plan(layer_bins, parameters, scene.n_range_bins, tolerance_db=0.05)
    power = render_plan(scene_plan, rng=np.random.default_rng(1))
    surface = power[np.rint(layer_bins[0]).astype(int), np.arange(N_LINES)]
    # On the pick lie the surface and the background just below it, that has risen at most whole:
    # 6e-3 of 1.
    assert_allclose(surface.mean(), scene.peak_power[0].mean(), rtol=0.03)


def test_constant_radiometry_is_the_papers_to_the_bit():
    given = statistics()
    plain, constant = (
        draw_scene(
            prepare(data, N_LINES, **options), N_LINES, name="", rng=np.random.default_rng(1)
        )
        for data, options in ((planted(), {}), (given, {"radiometry": "constant"}))
    )
    assert plain.layer_bins.tobytes() == constant.layer_bins.tobytes()
    assert constant.peak_power is None
    assert constant.complete_layer_bins is None


def test_statistics_without_radiometry_are_refused_and_stand_ins_are_named():
    with pytest.raises(ValueError, match="flight statistics need noise_spread_db"):
        prepare(planted(), N_LINES, radiometry="measured")
    unknown = statistics(further_spacing_bins=1000.0, further_rise_db=0.0, end_contrast_db=0.0)
    unknown = unknown.assign_attrs(radiometry_missing="end_contrast_db")
    model = prepare(unknown, N_LINES, n_layers=(3, 3), radiometry="measured")
    scene = draw_scene(model, N_LINES, name="", rng=np.random.default_rng(1))
    assert np.isfinite(scene.layer_bins).all()  # where picks end is not known: all are labelled
    assert scene.notes["radiometry_missing"] == "end_contrast_db"
