"""Echoes of drawn scenes: what they keep, what files hold and renders show."""

import dataclasses

import numpy as np
import pytest
import xarray as xr
from numpy.testing import assert_allclose, assert_array_equal
from planted_labels import N_LINES, planted

from snowsim.echogram import Echoes, Kind
from snowsim.io import SceneSet, write_scenes
from snowsim.labels import draw_scene, prepare, redress
from snowsim.phy import render


@pytest.fixture(scope="module")
def drawn():
    model = prepare(planted(), N_LINES)
    rng = np.random.default_rng(1)
    return [draw_scene(model, N_LINES, name=f"{i}", rng=rng) for i in range(200)]


def test_every_echo_has_power_and_the_background_starts_at_the_surface(drawn):
    for scene in drawn:
        echoes = scene.echoes
        assert echoes.power.shape == echoes.bins.shape
        assert (echoes.power > 0).all()
        background = echoes.bins[echoes.kind == Kind.BACKGROUND]
        assert (background > scene.layer_bins[0]).all()
        assert (background < scene.layer_bins[0] + 1).all()


def test_further_echoes_lie_below_the_last_layer_and_are_no_layers(drawn):
    for scene in drawn:
        echoes = scene.echoes
        assert_array_equal(echoes.bins[echoes.kind == Kind.LAYER], scene.layer_bins)
        further = echoes.bins[echoes.kind == Kind.BELOW]
        assert (further > scene.layer_bins[-1]).all()
    # Some 100 bins below the last layer, 30 apart.
    n_further = np.mean([(scene.echoes.kind == Kind.BELOW).sum() for scene in drawn])
    assert_allclose(n_further, 100 / 30, rtol=0.2)


def test_power_and_noise_keep_the_mean_of_the_flight(drawn):
    surface = np.array([scene.echoes.power[0].mean() for scene in drawn])
    noise = np.array([scene.echoes.noise_power for scene in drawn])
    # A lognormal of 1.6 dB scatters by 0.38 of its mean: 200 of them by 0.027; allow four.
    assert_allclose(surface.mean(), 1, atol=0.11)
    assert_allclose(noise.mean(), 1e-3, rtol=0.11)


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
    surface = power[np.rint(echoes.bins[0]).astype(int), np.arange(N_LINES)]
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
    flight = planted()
    same = redress(scene, flight)
    other = redress(scene, flight.assign(variance_bins2=2 * flight["variance_bins2"]))
    for name in ("bins", "power", "kind", "decay_rate"):
        assert_array_equal(getattr(other, name), getattr(scene.echoes, name), err_msg=name)
    assert_array_equal(same.variance_bins2, scene.echoes.variance_bins2)
    assert_array_equal(other.variance_bins2, 2 * scene.echoes.variance_bins2)
