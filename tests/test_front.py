"""What people script with: a radar simulated, and scenes without a run."""

import pickle

import numpy as np
import pytest
import torch
import xarray as xr
from numpy.testing import assert_allclose, assert_array_equal

import snowsim
from lib.imports import ROOT
from lib.shipped import shipped
from snowsim.constants import SPEED_OF_LIGHT_M_S
from snowsim.echogram import check_echogram, check_layers
from snowsim.front import REFERENCE
from snowsim.io import read_echogram, read_layers
from snowsim.io.files import read_dataset
from snowsim.io.png_pairs import PairSet
from snowsim.phy.waveform import waveform_peak
from snowsim.physical.echo import physical_parameters
from snowsim.physical.radar import PRESETS

SNOW = {"depth_m": [0, 1.0, 2.5], "density_kg_m3": [340, 400, 350]}


def test_a_simulated_echogram_is_read_back_and_its_layers_lie_where_light_takes_them(tmp_path, rng):
    echogram, layers = snowsim.simulate(snowsim.Snowpack(**SNOW), "snow-2-8", n_range_lines=5, rng=rng)
    check_echogram(echogram)
    check_layers(layers)
    for name, dataset in (("echogram", echogram), ("layers", layers)):
        dataset.to_netcdf(tmp_path / f"{name}.nc")
    xr.testing.assert_equal(read_echogram(tmp_path / "echogram.nc")["Data"], echogram["Data"])
    twtt = read_layers(tmp_path / "layers.nc")["twtt"].values
    path_m = 500 + np.cumsum([0, 1 + 0.845 * 0.34, 1.5 * (1 + 0.845 * 0.4)])
    assert_allclose(twtt, np.tile(2 * path_m[:, None] / SPEED_OF_LIGHT_M_S, 5), rtol=1e-12)


def test_mean_power_is_that_of_eq_1_and_noise_lies_as_deep_as_the_radar_says(rng):
    # Slopes so small that no tail hides a layer.
    snow, radar = snowsim.Snowpack(**SNOW, slope=0.001), snowsim.Radar.preset("ku-12-18", n_looks=400)
    echogram, layers = snowsim.simulate(snow, radar, n_range_lines=400, rng=rng)
    profile = echogram["Data"].mean("slow_time").values
    _, given = physical_parameters(snow, radar)
    offset, height = waveform_peak(given["variance_bins2"], given["decay_rate"])
    at = np.rint((layers["peak_twtt"].values[:, 0] - float(echogram["twtt"][0])) / radar.bin_s).astype(int)
    noise = profile[:20].mean()
    # The nearest bin is off the peak by half a bin at most: below 0.4 dB; 400 lines of 400 looks: 0.01 dB.
    assert_allclose(10 * np.log10(profile[at] / (given["peak_power"][:, 0] * height + noise)), 0, atol=0.4)
    assert_allclose(10 * np.log10(profile[at[0]] / noise), 27, atol=0.4)
    assert_allclose(np.diff(layers["peak_twtt"] - layers["twtt"], axis=1), 0, atol=1e-15)
    assert (offset > 0).all()


def test_a_climate_draws_its_accumulation_and_its_variability(rng):
    climate = snowsim.Climate(accumulation_m=0.3, variability=0.2, n_years=400, density_sd_kg_m3=0.0)
    snow = climate.draw(2, 5.2, rng=rng)
    # Mass from depth and density: slabs of 0.3 m w.e. on average, s.d. 0.22 of 400: 1.1 %; allow four.
    middle = (snow.density_kg_m3[:-1] + snow.density_kg_m3[1:]) / 2
    water_m = (np.diff(snow.depth_m, axis=0) * middle).mean(axis=1)[:60] / 1000
    assert_allclose(water_m.mean(), 0.3, rtol=4 * 0.22 / np.sqrt(60))
    assert_allclose(np.log(water_m).std(), np.hypot(0.2, 0.1), rtol=4 / np.sqrt(2 * 60))
    assert snow.density_kg_m3.max() < 917


@pytest.fixture(scope="module")
def drawn():
    return snowsim.scenes(6, rng=1, n_range_bins=320, n_range_lines=64)


def test_a_scene_is_the_same_in_any_order_number_and_process(drawn):
    more = pickle.loads(pickle.dumps(snowsim.scenes(100, rng=1, n_range_bins=320, n_range_lines=64)))
    for number in (5, 2):
        for ours, theirs in zip(drawn[number], more[number], strict=True):
            assert_array_equal(ours, theirs)
    assert (drawn[0][0] != drawn[1][0]).any()
    assert_array_equal(drawn[-1][0], drawn[5][0])
    with pytest.raises(IndexError):
        drawn[6]


def test_a_loader_of_torch_takes_scenes_as_they_are(drawn):
    (images, masks), *_ = torch.utils.data.DataLoader(drawn, batch_size=4)
    assert images.shape == masks.shape == (4, 320, 64)
    assert images.dtype == torch.uint8
    assert set(masks.unique().tolist()) == {0, 1}


@pytest.mark.parametrize("radiometry", ["constant", "measured"])
def test_scenes_are_written_in_every_format(tmp_path, radiometry):
    some = snowsim.scenes(3, rng=2, n_range_lines=32, radiometry=radiometry)
    for form in ("pairs", "netcdf", "zarr"):
        assert some.write(tmp_path / form, form)["n_scenes"] == 3
    scene = some.scene(1)
    with xr.open_dataset(tmp_path / "netcdf/scene_scene_000001.nc") as kept:
        assert_array_equal(kept["image"], scene.image)
    with xr.open_zarr(tmp_path / "zarr/scene_scene_000001.zarr", consolidated=False) as kept:
        assert_array_equal(kept["layer_bins"], scene.layer_bins)
    read = {one.name: one for one in PairSet(tmp_path / "pairs")}
    assert_array_equal(next(v for k, v in read.items() if k.endswith("scene_000001")).image, scene.image)
    some.write(tmp_path / "zarr", "zarr")  # again: replaced


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: snowsim.scenes(2, rng=1, renderer="cgan"), "renderer must be phy, got 'cgan'"),
        (lambda: snowsim.scenes(0, rng=1), "n must be at least 1, got 0"),
        (lambda: snowsim.scenes(2, rng=1, n_range_bins=0.5), "n_range_bins must be a whole number"),
        (lambda: snowsim.scenes(2, rng=1).write("x", "gif"), "format must be one of pairs, netcdf, zarr, got 'gif'"),
        (lambda: snowsim.Radar.preset("sonar"), "radar must be one of snow-2-8, .*, got 'sonar'"),
        (lambda: snowsim.Snowpack([0, 2, 1], [300, 300, 300]), "depth_m must be finite and increase with layer"),
        (lambda: snowsim.Snowpack([0, 1], [300, 950]), "density_kg_m3 must .* between 0 and 917, got 950"),
        (lambda: snowsim.Climate(accumulation_m=0.3, n_years=0).draw(2, 5, rng=None), "n_years must be at least 1"),
        (
            lambda: snowsim.simulate(snowsim.Snowpack(np.zeros((1, 7)), [300]), "ku-12-18", n_range_lines=8, rng=None),
            "n_range_lines must be the 7 of the snowpack, got 8",
        ),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused_in_one_line(call, message):
    with pytest.raises(ValueError, match=message):
        call()


def test_the_statistics_of_the_package_are_small():
    assert REFERENCE.stat().st_size < 4e6


def test_the_statistics_of_the_package_are_those_of_the_default_run():
    run = ROOT / "results/statistics.nc"
    if not run.is_file():
        pytest.skip("no finished run of the default configuration under results")
    xr.testing.assert_identical(read_dataset(REFERENCE), shipped(read_dataset(run)))


def test_commands_write_what_the_functions_give(tmp_path):
    from click.testing import CliRunner

    from snowsim.cli import scenes, simulate

    assert set(simulate.PRESETS) == set(PRESETS)
    done = CliRunner().invoke(simulate.command, [str(tmp_path / "a.nc"), "--range-lines", "4", "--height-m", "400"])
    assert done.exit_code == 0, done.output
    climate, radar = snowsim.Climate(accumulation_m=0.3), snowsim.Radar.preset("snow-2-8", height_m=400.0)
    echogram, layers = snowsim.simulate(climate, radar, n_range_lines=4, rng=np.random.default_rng(0))
    xr.testing.assert_equal(read_echogram(tmp_path / "a.nc")["Data"], echogram["Data"])
    xr.testing.assert_equal(read_layers(tmp_path / "a_layers.nc")["twtt"], layers["twtt"])
    done = CliRunner().invoke(scenes.command, [str(tmp_path / "s"), "-n", "2", "--range-lines", "16"])
    assert done.exit_code == 0, done.output
    assert done.output.startswith("n_scenes 2")
    assert len(list((tmp_path / "s").glob("data_*.png"))) == 2
