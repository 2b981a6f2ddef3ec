"""Scenes drawn with radiometry: what they keep, who is labelled, what renders show."""

import dataclasses

import numpy as np
import pytest
import xarray as xr
from numpy.testing import assert_allclose, assert_array_equal
from planted_labels import N_LINES, planted

from snowsim.echoes import Echoes, Kind
from snowsim.echogram import check_layer_bins
from snowsim.io.scenes import SceneSet, write_scenes
from snowsim.labels import check_labels, draw_scene, prepare, redress
from snowsim.phy import render

SPREADS = {
    "noise_spread_db": 1.5,
    "surface_to_noise_spread_db": 2.0,
    "common_spread_db": 3.0,
    "layer_spread_db": 2.0,
    "decay_spread": 0.1,
    "background_spread_db": 1.0,
    "further_spacing_bins": 30.0,
    "further_rise_db": 1.0,
    "end_contrast_db": 0.5,
}
FADING = {
    "fading_spread_db": [1.0, 2.0],
    "fading_length_lines": [20.0, 40.0],
    "fading_exponent": [1.0, 2.0],
}


def statistics(**changes):
    """Of a flight with planted spectra and radiometry; numbers may be changed."""
    numbers = SPREADS | {"noise_power": 1e-3} | changes
    peak_power = 0.3 * 0.8 ** np.arange(8)
    peak_power[0] = 1
    variables = {name: ((), value) for name, value in numbers.items()}
    variables |= {name: ("interface", values) for name, values in FADING.items()}
    variables["peak_power"] = ("layer", peak_power)
    variables["variance_bins2"] = ("layer", np.full(8, 0.6))
    variables["decay_rate"] = ("layer", np.full(8, 0.1))
    variables["background_power"] = ("fall", [0.0, 5e-3, 1e-3])
    dataset = planted().merge(xr.Dataset(variables, coords={"fall": [30.0, 100.0, 1000.0]}))
    return dataset.assign_attrs(n_looks=1000.0)


def model_of(flight, **choices):
    """Label model of three to eight layers, with a uniform slab 0 and a flat surface."""
    options = {"n_layers": (3, 8), "first_slab": "uniform", "surface": "flat"}
    return prepare(flight, N_LINES, **options | choices)


@pytest.fixture(scope="module")
def drawn():
    model = model_of(statistics())
    rng = np.random.default_rng(1)
    return [draw_scene(model, N_LINES, name=f"{i}", rng=rng) for i in range(200)]


def test_complete_layers_are_layers_in_order_without_background(drawn):
    for scene in drawn:
        check_layer_bins(scene.complete_layer_bins)
        # As near as a bin, less what float32 rounds.
        assert (np.diff(scene.complete_layer_bins, axis=0) >= 0.999).all()
        is_layer = scene.echoes.kind != Kind.BACKGROUND
        assert_array_equal(scene.complete_layer_bins, scene.echoes.bins[is_layer])
        whole = scene.complete_layer_bins[: len(scene.layer_bins)]
        labelled = np.isfinite(scene.layer_bins)
        assert labelled[0].all()
        assert_array_equal(scene.layer_bins[labelled], whole[labelled])


def test_labels_go_down_to_the_deepest_layer_that_shows(rng):
    model = model_of(statistics(end_contrast_db=4.0))
    drawn = [draw_scene(model, N_LINES, name=f"{i}", rng=rng) for i in range(100)]
    for scene in drawn:
        labelled = np.isfinite(scene.layer_bins)
        assert (labelled.all(axis=1) | ~labelled.any(axis=1)).all()
        assert (np.diff(labelled[:, 0].astype(int)) <= 0).all()
        assert (scene.echoes.kind == Kind.LAYER).sum() == labelled[:, 0].sum()
    share = np.mean([np.isfinite(scene.layer_bins[1:]).mean() for scene in drawn])
    assert 0.1 < share < 0.9, share


def test_every_echo_has_power_and_the_background_starts_at_the_surface(drawn):
    for scene in drawn:
        echoes = scene.echoes
        assert echoes.power.shape == echoes.bins.shape
        assert (echoes.power > 0).all()
        background = echoes.bins[echoes.kind == Kind.BACKGROUND]
        assert (background > scene.layer_bins[0]).all()
        assert (background < scene.layer_bins[0] + 1).all()


def test_no_physics_is_in_notes(drawn):
    counts = {"n_layers", "n_slabs_beyond", "n_samples", "n_touched", "n_means_touched"}
    drawn_and_kept = {
        f"thickness_{moment}_{when}"
        for moment in ("mean", "variance")
        for when in ("drawn", "kept")
    }
    shown = {"radiometry_missing", "n_pixels_unlabelled", "median_rise_db"}
    expected = counts | drawn_and_kept | shown | {"first_thickness_bins"}
    assert set(drawn[0].notes) == expected


def test_power_and_noise_keep_the_mean_of_the_flight(drawn):
    surface = np.array([scene.echoes.power[0].mean() for scene in drawn])
    noise = np.array([scene.echoes.noise_power for scene in drawn])
    # A lognormal of 1.6 dB scatters by 0.38 of its mean: 200 of them by 0.027; allow four.
    assert_allclose(surface.mean(), 1, atol=0.11)
    assert_allclose(noise.mean(), 1e-3, rtol=0.11)


def test_as_many_scenes_have_no_layer_as_blocks_of_the_flight():
    given = statistics().assign_attrs(n_blocks=10, n_blocks_without_layers=3)
    given["n_blocks_by_layers"] = (
        ("zone", "n_layers"),
        np.tile([0, 0, 3, 4], (given.sizes["zone"], 1)),
    )
    model = model_of(given, n_layers="measured")
    rng = np.random.default_rng(1)
    scenes = [draw_scene(model, N_LINES, name="", rng=rng) for _ in range(400)]
    n_layers = np.array([len(scene.layer_bins) - 1 for scene in scenes])
    # Binomial of 0.3: 0.023 of 400; allow four.
    assert_allclose((n_layers == 0).mean(), 0.3, atol=0.092)
    assert set(n_layers) == {0, 2, 3}


def test_a_higher_contrast_at_the_ends_of_picks_leaves_fewer_labels(drawn):
    picky = model_of(statistics(end_contrast_db=3.0))
    rng = np.random.default_rng(1)
    fewer = [draw_scene(picky, N_LINES, name=f"{i}", rng=rng) for i in range(50)]
    n_fewer = 0
    n_labelled = 0
    for strict, scene in zip(fewer, drawn[:50], strict=True):
        assert_array_equal(strict.echoes.power, scene.echoes.power)  # nothing else hangs on it
        kept = np.isfinite(strict.layer_bins)
        labelled = np.isfinite(scene.layer_bins)
        assert (kept <= labelled).all()
        n_fewer += kept.sum()
        n_labelled += labelled.sum()
    assert n_fewer < n_labelled


def test_files_keep_the_echoes_and_renders_follow_them(drawn, tmp_path):
    write_scenes(tmp_path / "labels.nc", drawn[:3])
    with SceneSet(tmp_path / "labels.nc") as scenes:
        scene = scenes[1]
    for field in dataclasses.fields(Echoes):
        before = getattr(drawn[1].echoes, field.name)
        assert_array_equal(getattr(scene.echoes, field.name), before, err_msg=field.name)
    assert_array_equal(scene.mask(), drawn[1].mask())
    echoes = scene.echoes
    power = render(echoes.bins, echoes.parameters(), scene.n_range_bins, rng=1)
    surface_row = np.rint(echoes.bins[0]).astype(int)
    surface = power[surface_row, np.arange(N_LINES)]
    # On the pick lie the surface and the background just below it, that has risen at most whole:
    # 6e-3 of 1.
    assert_allclose(surface.mean(), echoes.power[0].mean(), rtol=0.03)


def test_files_describe_the_echoes(drawn, tmp_path):
    write_scenes(tmp_path / "labels.nc", drawn[:2])
    with xr.open_dataset(tmp_path / "labels.nc", group="echoes") as group:
        assert group["power"].dtype == np.float64
        assert group["power"].attrs["units"] == "W"
        assert group["decay_rate"].attrs["units"] == "bin-1"
        assert group["n_rows"].attrs["sample_dimension"] == "row"
        assert group["kind"].attrs["flag_meanings"] == "layer background below"


def test_other_statistics_change_waveforms_and_leave_rows_and_powers(drawn):
    scene = drawn[3]
    flight = statistics()
    same = redress(scene, flight)
    other = redress(scene, flight.assign(variance_bins2=2 * flight["variance_bins2"]))
    for name in ("bins", "power", "kind", "decay_rate"):
        assert_array_equal(getattr(other, name), getattr(scene.echoes, name), err_msg=name)
    assert_array_equal(same.variance_bins2, scene.echoes.variance_bins2)
    assert_array_equal(other.variance_bins2, 2 * scene.echoes.variance_bins2)


def test_constant_radiometry_is_the_papers_to_the_bit():
    plain = model_of(planted(), radiometry="constant")
    constant = model_of(statistics(), radiometry="constant")
    first, second = (
        draw_scene(model, N_LINES, name="", rng=np.random.default_rng(1))
        for model in (plain, constant)
    )
    assert first.layer_bins.tobytes() == second.layer_bins.tobytes()
    assert second.echoes is None
    assert second.complete_layer_bins is None


def test_statistics_without_radiometry_are_refused_and_stand_ins_are_named():
    with pytest.raises(ValueError, match="flight statistics need noise_spread_db"):
        model_of(planted())
    unknown = statistics(further_spacing_bins=1000.0, further_rise_db=0.0, end_contrast_db=0.0)
    unknown = unknown.assign_attrs(radiometry_missing="end_contrast_db")
    model = model_of(unknown, n_layers=(3, 3))
    scene = draw_scene(model, N_LINES, name="", rng=np.random.default_rng(1))
    assert np.isfinite(scene.layer_bins).all()  # where picks end is not known: all are labelled
    assert scene.notes["radiometry_missing"] == "end_contrast_db"


def test_statistics_by_which_no_layer_shows_are_refused_before_scenes_are_drawn(rng):
    check_labels(model_of(statistics()), rng=rng)
    check_labels(model_of(statistics(end_contrast_db=33.0), radiometry="constant"), rng=rng)
    refused = "20 of 20 scenes with layers would be labelled at the surface alone.* 33 dB"
    with pytest.raises(ValueError, match=refused) as error:
        check_labels(model_of(statistics(end_contrast_db=33.0)), rng=rng)
    assert "\n" not in str(error.value)
