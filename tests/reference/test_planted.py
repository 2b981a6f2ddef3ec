"""Layers in files lie where the renderer drew them."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from snowsim.echogram import SURFACE_ROW, layer_bins_of
from snowsim.io.files import read_dataset, write_dataset
from snowsim.io.scenes import SceneSet, write_scenes
from snowsim.reference import benchmark, checked_settings, draw_climate, draw_frame, draw_scene, flight
from snowsim.reference.radar import range_response
from snowsim.seeding import random_stream

BARE = {  # interfaces alone and short tails: nothing that moves a peak
    "firn": {"layering_sd_kg_m3": 0.0, "crusts_per_year": 0.0, "horizon_year_sd": 0.0, "horizon_local_sd": 0.0},
    "radar": {
        "sensitivity_sd_db": 0.0,
        "missing_rate": 0.0,
        "saturated_rate": 0.0,
        "surface_to_noise_db": 60.0,
        "surface_slope": 0.005,
        "horizon_slope": 0.005,
        "diffuse_share": 0.0,
    },
}
SETTINGS = checked_settings(BARE)
N_LAYERS = 6  # surface and the youngest


@pytest.fixture(scope="module")
def climate():
    return draw_climate(SETTINGS, rng=random_stream(1, "climate"))


@pytest.fixture
def echoes(monkeypatch):
    """Every `Echo` that frames and scenes draw, as they draw it."""
    kept = []
    for module in (flight, benchmark):
        drawn = module.draw_echo
        monkeypatch.setattr(module, "draw_echo", lambda *a, drawn=drawn, **k: kept.append(drawn(*a, **k)) or kept[-1])
    return kept


def peak_rows(echo, line, rows):
    """Rows of the maxima of one line's mean echo next to given rows, at sub-bins, refined by parabolas."""
    n_sub = echo.radar.n_sub_bins
    received = np.convolve(
        echo.sub_bin_power[line].astype(float), range_response(echo.radar).astype(float) ** 2, "same"
    )
    near = echo.margin + np.rint(rows * n_sub).astype(int)[:, None] + np.arange(-4, 5)
    top = near[np.arange(len(rows)), received[near].argmax(axis=1)]
    left, middle, right = (received[top + step] for step in (-1, 0, 1))
    return (top + 0.5 * (left - right) / (left - 2 * middle + right) - echo.margin) / n_sub


def test_layers_in_a_frame_s_file_lie_where_its_mean_echo_peaks(climate, echoes, tmp_path):
    echogram, layers = draw_frame(1, 20, 64, climate=climate, settings=SETTINGS, rng=random_stream(1, "frame"))
    write_dataset(tmp_path / "frame.nc", echogram)
    write_dataset(tmp_path / "layers.nc", layers)
    bins = layer_bins_of(read_dataset(tmp_path / "layers.nc"), read_dataset(tmp_path / "frame.nc"))[:N_LAYERS]
    assert len(bins) == N_LAYERS
    [echo] = echoes
    for line in range(0, 64, 3):
        error = peak_rows(echo, line, bins[:, line]) - bins[:, line]
        assert np.abs(error[np.isfinite(error)]).max() < 0.1
        assert np.isfinite(error).sum() == N_LAYERS


def test_layers_in_a_scene_s_file_lie_where_its_mean_echo_peaks(climate, echoes, tmp_path):
    scene = draw_scene(1, "test", climate=climate, settings=SETTINGS, n_looks=1, rng=random_stream(1, "scene"))
    write_scenes(tmp_path / "scenes.nc", [scene])
    with SceneSet(tmp_path / "scenes.nc") as scenes:
        bins = scenes[0].layer_bins[:N_LAYERS].astype(float)
    assert_allclose(bins, scene.layer_bins[:N_LAYERS], atol=1e-4)  # float32 at row 500
    assert abs(bins[0].mean() - SURFACE_ROW) < 3
    for line in range(0, 256, 9):
        # The benchmark's echo is cropped for its looks; the record it was drawn from is kept whole.
        assert np.abs(peak_rows(echoes[0], line, bins[:, line]) - bins[:, line]).max() < 0.1


def test_a_shift_of_a_fifth_of_a_bin_would_be_seen(climate, echoes):
    scene = draw_scene(1, "test", climate=climate, settings=SETTINGS, n_looks=1, rng=random_stream(1, "scene"))
    bins = scene.layer_bins[:N_LAYERS] + 0.2
    assert np.abs(peak_rows(echoes[0], 7, bins[:, 7]) - bins[:, 7]).min() > 0.1


def test_bright_pixels_of_the_file_lie_on_its_layers(climate, tmp_path):
    echogram, layers = draw_frame(1, 20, 256, climate=climate, settings=SETTINGS, rng=random_stream(1, "frame"))
    write_dataset(tmp_path / "frame.nc", echogram)
    power = read_dataset(tmp_path / "frame.nc")["Data"].transpose("twtt", "slow_time").values
    bins = layer_bins_of(layers, echogram)[:4]
    reach = np.arange(-4, 5)
    for layer in bins:
        # Along the layer: 256 lines of 5 looks leave 3 % of speckle, far less than what a bin aside loses.
        profile = [np.mean(power[np.rint(layer).astype(int) + step, np.arange(256)]) for step in reach]
        assert reach[int(np.argmax(profile))] == 0
