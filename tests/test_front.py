"""What people script with: a radar simulated, and scenes without a run."""

import dataclasses
import json
import pickle

import numpy as np
import pytest
import xarray as xr
from click.testing import CliRunner
from numpy.testing import assert_allclose, assert_array_equal
from processes import ROOT
from refusals import refusal

import snowsim
from snowsim import cli
from snowsim.constants import SPEED_OF_LIGHT_M_S
from snowsim.front import REFERENCE
from snowsim.io import PairSet, read_dataset
from snowsim.io.describe import describe
from snowsim.io.pairs import export_pairs, read_spacing
from snowsim.seeding import random_stream
from snowsim.snowpack import PRESETS

SNOW = {"depth_m": [0, 1.0, 2.5], "density_kg_m3": [340, 400, 350]}


def test_layers_are_as_bright_as_their_power_and_noise_as_deep_as_the_radar_says(rng):
    # Slopes so small that no tail hides a layer.
    snow = snowsim.Snowpack(**SNOW, slope=0.001)
    radar = snowsim.Radar.preset("ku-12-18", n_looks=400)
    echogram, layers = snowsim.simulate(snow, radar, n_range_lines=400, rng=rng)
    profile = echogram["Data"].mean("slow_time").values
    below_first_s = layers["peak_twtt"].values[:, 0] - float(echogram["twtt"][0])
    at = np.rint(below_first_s / radar.bin_s).astype(int)
    noise = profile[:20].mean()
    # The nearest bin is off the peak by half a bin at most: below 0.4 dB; 400 lines of 400 looks:
    # 0.01 dB.
    assert_allclose(10 * np.log10(profile[at] - noise), layers["power_db"][:, 0], atol=0.4)
    assert_allclose(10 * np.log10(profile[at[0]] / noise), 27, atol=0.4)


def test_a_climate_draws_its_accumulation_and_its_variability(rng):
    climate = snowsim.Climate(accumulation_m=0.3, n_years=60, density_sd_kg_m3=0.0)
    snow = climate.draw(2, 5.2, rng=rng)
    density = (snow.density_kg_m3[:-1] + snow.density_kg_m3[1:]) / 2
    thickness_m = np.diff(snow.depth_m, axis=0)
    water_m = (thickness_m * density / 1000).mean(axis=1)
    # 60 years of log s.d. 0.22, of years and drift: four of their standard errors.
    assert_allclose(water_m.mean(), 0.3, rtol=4 * 0.22 / np.sqrt(60))
    assert_allclose(np.log(water_m).std(), np.hypot(0.2, 0.1), rtol=4 / np.sqrt(2 * 60))


@pytest.fixture(scope="module")
def drawn():
    return snowsim.scenes(6, rng=1, n_range_bins=320, n_range_lines=64)


def test_a_scene_is_the_same_in_any_order_number_and_process(drawn):
    many = snowsim.scenes(100, rng=1, n_range_bins=320, n_range_lines=64)
    more = pickle.loads(pickle.dumps(many))
    for number in (5, 2):
        assert_array_equal(drawn[number], more[number])
    assert (drawn[0][0] != drawn[1][0]).any()
    assert_array_equal(drawn[4:1:-2][1][0], drawn[2][0])
    assert len(list(drawn)) == 6


def test_scenes_are_written_as_image_pairs_and_written_over(tmp_path, drawn):
    some = drawn[4:1:-2]
    assert some.write(tmp_path / "pairs")["n_scenes"] == 2
    with pytest.raises(ValueError, match="expected an empty or a new one"):
        some.write(tmp_path / "pairs")
    assert some.write(tmp_path / "pairs", force=True)["n_scenes"] == 2
    assert_array_equal(PairSet(tmp_path / "pairs")[1].image, some[0][0])
    with pytest.warns(UserWarning, match=r"pairs: scenes that were there before stay \(1\)"):
        drawn[2:3].write(tmp_path / "pairs", force=True)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda: snowsim.scenes(2, rng=1, renderer="cgan"),
            "^renderer must be one of phy, got 'cgan'$",
        ),
        (lambda: snowsim.scenes(0, rng=1), "^n must be a whole number of at least 1, got 0$"),
        (
            lambda: snowsim.scenes(2, rng=1, renderer=lambda scene: scene.image)[0],
            r"renderer: expected an image \(\d+, 256\) of scene drawn_000000, got \(\)",
        ),
        (
            lambda: snowsim.scenes(
                2,
                rng=1,
                renderer=lambda scene: np.eye(scene.n_range_bins, 256, dtype=np.uint8),
            )[0],
            "^renderer: expected grey levels from 0 to 255, of scene drawn_000000, found none",
        ),
        (
            lambda: snowsim.simulate(
                snowsim.Snowpack(np.array([[30, -30.0], [31, 1]]), [300, 400]),
                snowsim.Radar.preset("snow-2-8", height_m=20.0),
                rng=1,
            ),
            "travel time from the radar to the surface must be finite, above 0",
        ),
        # All in GHz and nanoseconds.
        (
            lambda: snowsim.Radar(centre_hz=5, bandwidth_hz=6, bin_s=0.0867),
            "centre_hz in hertz must be finite, above 1e.06, got 5",
        ),
        # By default it falls to 1 / e within one sample of the sweep.
        (lambda: snowsim.Radar.preset("snow-2-8", window="exponential"), "window exponential uses"),
        (
            lambda: snowsim.Snowpack([0, 2, 1], [300, 300, 300]),
            "depth_m must increase with layer: its steps must be finite, above 0, got -1",
        ),
        (
            lambda: snowsim.Snowpack.from_profile([0.5, 1, 3, 2, 4], [300, 310, 320, 330, 340]),
            "depth_m must increase: its steps must be finite, above 0, got -1",
        ),
        (lambda: snowsim.Snowpack([0, 1], [0.34, 0.4]), "density_kg_m3 must be .* got 0.34 at"),
        (
            lambda: snowsim.Snowpack([0, 1, 2], [300, 320]),
            r"depth_m and density_kg_m3 must be of the same layers .*, got \(3, 1\) and \(2, 1\)",
        ),
        (
            lambda: snowsim.Snowpack([0, 20, 45], [300, 320, 340], roughness_m=2),
            "roughness_m must be finite, at least 0, at most 1, got 2",
        ),
        (
            lambda: snowsim.Snowpack([0, 1], [300, 320], roughness_m=[0.1, 0.1, 0.1]),
            r"roughness_m must fit \(2,\), of the layers, got \(3,\)",
        ),
        (
            lambda: snowsim.Climate(accumulation_m=0.3, n_years=2.5),
            "n_years must be a whole number of at least 1, got 2.5",
        ),
        (
            lambda: snowsim.scenes(2, rng=1).write("none", indices=[]),
            "number of scenes to write must be a whole number of at least 1, got 0",
        ),
        (
            lambda: snowsim.Snowpack(["top", 1], [300, 300]),
            r"snowpack: depth_m must be numbers, got \['top', 1\]",
        ),
        (
            lambda: snowsim.Snowpack([0, 1], np.ma.array([340, 400], mask=[False, True])),
            "density_kg_m3 must be finite",
        ),
        (
            lambda: snowsim.simulate(
                snowsim.Snowpack(np.zeros((1, 7)), [300]), "ku-12-18", n_range_lines=8, rng=None
            ),
            "n_range_lines must be the 7 of the snowpack, got 8",
        ),
        (
            lambda: snowsim.simulate(snowsim.Snowpack(**SNOW), "snow-2-8", rng="one"),
            "rng must be a numpy.random.Generator or a seed",
        ),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(call, message):
    with refusal(message):
        call()


def test_the_statistics_of_the_package_are_small_and_those_of_the_default_run():
    assert REFERENCE.stat().st_size < 4e6
    kept = read_dataset(REFERENCE)
    run = ROOT / "results/statistics.nc"
    made = read_dataset(run) if run.is_file() else None
    if made is None or made.attrs["n_range_lines"] != kept.attrs["n_range_lines"]:
        pytest.skip("no finished run of the default configuration under results")
    # Sums of float32 echoes: the same on one machine type, else to some 1e-6 of what the flight
    # tells to 1e-3.
    xr.testing.assert_allclose(kept, made, rtol=1e-4)


def test_commands_write_what_the_functions_give(tmp_path):
    assert set(cli.PRESETS) == set(PRESETS)
    asked = f"{tmp_path}/a.nc --range-lines 4 --set height_m 400 --set window blackman"
    assert CliRunner().invoke(cli.simulate, asked).exit_code == 0
    climate = snowsim.Climate(accumulation_m=0.3)
    radar = snowsim.Radar.preset("snow-2-8", height_m=400.0, window="blackman")
    echogram, layers = snowsim.simulate(climate, radar, n_range_lines=4, rng=0)
    xr.testing.assert_equal(read_dataset(tmp_path / "a.nc"), echogram)
    xr.testing.assert_equal(read_dataset(tmp_path / "a_layers.nc"), layers)
    done = CliRunner().invoke(cli.simulate, f"{asked} --force --set colour 1")
    assert done.exit_code == 2
    assert "a radar has no colour, but bandwidth_hz, " in done.output
    done = CliRunner().invoke(cli.scenes, f"{tmp_path}/s -n 2 --range-lines 16")
    assert done.output.startswith("n_scenes 2")


def test_all_names_people_script_with_come_with_a_star():
    held = {}
    exec("from snowsim import *", held)
    assert {"Tracker", "simulate", *snowsim.__all__} <= set(held)


@pytest.mark.parametrize("window", ["taylor", ("chebwin", 60), ("kaiser_bessel_derived", 14)])
def test_a_radar_takes_the_windows_of_scipy(window, tmp_path, rng):
    radar = snowsim.Radar.preset("snow-2-18", window=window)
    echogram, _ = snowsim.simulate(snowsim.Snowpack(**SNOW), radar, n_range_lines=2, rng=rng)
    echogram.to_netcdf(tmp_path / "echogram.nc")
    assert str(window) in repr(radar)


def test_hills_and_low_radars_keep_the_surface_within_the_window():
    hills = -np.cos(np.linspace(0, 6 * np.pi, 64))
    snow = snowsim.Snowpack(np.array([hills, hills + 1.5]), [340, 420])
    low = snowsim.Radar.preset("accumulation", height_m=15.0)
    for radar in (snowsim.Radar.preset("snow-2-8"), low):
        echogram, layers = snowsim.simulate(snow, radar, rng=1)
        assert 0 <= echogram["twtt"].values[0] <= layers["twtt"].values.min()
        way_s = 2 * (radar.height_m + hills) / SPEED_OF_LIGHT_M_S
        assert_allclose([layers["twtt"][0], echogram["Surface"]], [way_s, way_s], rtol=1e-12)


def test_snow_does_not_change_with_the_arrays_it_was_made_of():
    density = np.array([300.0, 400.0])
    snow = snowsim.Snowpack([0, 1], density)
    density[1] = 5000
    assert snow.density_kg_m3.max() == 400


def test_long_echograms_are_simulated_a_part_at_a_time(monkeypatch):
    monkeypatch.setattr("snowsim.snowpack.simulation.LINES_AT_ONCE", 8)
    snow = snowsim.Snowpack(**SNOW)
    long, layers = snowsim.simulate(snow, "ku-12-18", n_range_lines=20, rng=1)
    first, _ = snowsim.simulate(snow, "ku-12-18", n_range_lines=8, rng=1)
    power = long["Data"].values
    assert power.shape[1] == layers.sizes["slow_time"] == 20
    assert_array_equal(power[:, :8], first["Data"])
    # Speckle of parts is not repeated.
    assert (power[:, 8:16] != power[:, :8]).mean() > 0.99


def test_what_people_print_is_one_readable_line(drawn):
    said = [repr(drawn), repr(drawn.scene(2)), repr(snowsim.Tracker.from_pretrained())]
    said += [repr(snowsim.Radar.preset("snow-2-8")), repr(snowsim.Snowpack(**SNOW))]
    assert said == [
        "Scenes(6 of 320 range bins and 64 range lines)",
        "Scene('drawn_000002', 320 range bins, 64 range lines, 4 layers labelled, image)",
        "Tracker(universal 4, made for bins of 0.2886 ns, lines 5.2 m apart)",
        "Radar(6 GHz about 5 GHz, hann window, bins of 0.0867 ns, 5 looks, 500 m above the snow)",
        "Snowpack(3 layers down to 2.5 m, 340 to 400 kg m-3, range lines: 1)",
    ]


def test_scenes_as_printed_need_statistics_of_the_paper_s_estimator():
    with refusal("needs thickness_psd.* name a file of those"):
        snowsim.scenes(1, rng=1, recipe="paper")
    flight = read_dataset(REFERENCE)
    psd = (("zone", "slab", "wavenumber"), np.ones((4, flight.sizes["slab"], 129)))
    printed = snowsim.scenes(
        2, rng=1, statistics=flight.assign(thickness_psd=psd), recipe="paper", n_range_lines=64
    )
    assert_array_equal(printed.scene(0).layer_bins[0], 50)


def test_a_renderer_that_changes_its_scene_leaves_the_mask_as_drawn():
    def blank(scene):
        return np.full((scene.n_range_bins, scene.n_range_lines), 9, np.uint8)

    def moving(scene):
        scene.layer_bins[:] -= 10
        return blank(scene)

    masks = [
        snowsim.scenes(1, rng=1, n_range_lines=64, renderer=renderer)[0][1]
        for renderer in (blank, moving)
    ]
    assert_array_equal(*masks)


def test_any_function_of_a_scene_renders():
    def rendered(scene):
        noise = random_stream(3, scene.name).exponential(size=(scene.n_range_bins, 64))
        return noise + 30 * scene.mask()

    mine = snowsim.scenes(6, rng=1, n_range_bins=320, n_range_lines=64, renderer=rendered)
    image, mask = mine[2]
    assert image[mask > 0].min() > np.median(image)


@pytest.mark.parametrize(
    ("drawn_as", "found"),
    [
        (lambda noise: np.rint(200 * noise.clip(0, 1)) + 3, "whole numbers from 3 to 203 alone"),
        (lambda noise: np.rint(60 * noise.clip(0.1, 1)).astype(np.float32), "whole numbers from 6"),
        (lambda noise: 10 * np.log10(noise), "-.* pixels"),
        (lambda noise: np.where(noise < 0.1, np.nan, noise), "nan on .* pixels"),
        (lambda noise: np.where(noise > 2, 0, noise), "0 on .* pixels"),
        (lambda noise: np.where(noise > 2, np.inf, noise), "inf on .* pixels"),
        (lambda noise: (100 * noise).astype(np.int64), "type int64"),
        (lambda noise: (100 * noise).astype(np.uint16), "type uint16"),
        (lambda noise: noise > 1, "type bool"),
        (lambda noise: noise + 1j, "type complex128"),
    ],
)
def test_what_no_power_is_is_refused_of_a_renderer_by_naming_uint8(drawn_as, found):
    def rendered(scene):
        rng = random_stream(5, scene.name)
        return drawn_as(rng.exponential(size=(scene.n_range_bins, scene.n_range_lines)))

    mine = snowsim.scenes(1, rng=1, n_range_lines=32, renderer=rendered)
    with refusal(f"grey levels as uint8 .*drawn_000000, found {found}"):
        mine[0]


def test_the_type_of_an_image_says_what_it_is():
    def rendered(scene):
        rng = random_stream(5, scene.name)
        return rng.uniform(1, 250, size=(scene.n_range_bins, 32))

    power = snowsim.scenes(1, rng=1, n_range_lines=32, renderer=rendered)
    grey = snowsim.scenes(
        1, rng=1, n_range_lines=32, renderer=lambda scene: rendered(scene).astype(np.uint8)
    )
    assert_array_equal(grey[0][0], rendered(grey.scene(0)).astype(np.uint8))
    assert np.isfinite(power.scene(0).maximum_db)
    assert np.isnan(grey.scene(0).maximum_db)


def test_a_mirror_is_told_that_its_speckle_is_full():
    with pytest.warns(UserWarning, match="roughness_m is 0, but speckle is full"):
        snowsim.simulate(snowsim.Snowpack(**SNOW, roughness_m=0), "snow-2-8", rng=1)


def test_what_takes_seconds_shows_a_bar_on_a_terminal(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr("sys.stderr.isatty", lambda: True, raising=False)
    snowsim.scenes(2, rng=1, n_range_lines=16).write(tmp_path / "few")
    assert "0/2" in capsys.readouterr().err


def test_a_scene_says_what_its_height_cuts_and_the_first_warns(tmp_path):
    low = snowsim.scenes(4, rng=1, n_range_lines=64, n_range_bins=64)
    with pytest.warns(UserWarning, match="n_range_bins=64 cuts") as warned:
        scenes = [low.scene(i) for i in range(4)]
    assert len(warned) == 1
    for scene in scenes:
        n_drawn = scene.complete_layer_bins.size
        assert scene.notes["n_pixels_drawn"] == n_drawn
        # No two layers share a pixel, so the mask holds what is not cut.
        assert scene.notes["n_pixels_cut"] == n_drawn - scene.mask().sum()
    n_cut, n_drawn = low.count_cut()
    assert (n_cut, n_drawn) == tuple(
        sum(scene.notes[name] for scene in scenes) for name in ("n_pixels_cut", "n_pixels_drawn")
    )
    told = f"n_range_bins=64 cuts {n_cut} of {n_drawn} pixels of layers off 4 of 4 scenes"
    with pytest.warns(UserWarning, match=told) as warned:
        low.write(tmp_path / "low")
    assert len(warned) == 1


def test_pairs_have_the_spacing_of_their_flight_beside_them(tmp_path):
    flight = read_dataset(REFERENCE).assign_attrs(bin_size_s=1.2e-10, line_spacing_m=7.25)
    snowsim.scenes(2, rng=1, statistics=flight, n_range_lines=32).write(tmp_path / "mine")
    spacing = {"bin_size_s": 1.2e-10, "line_spacing_m": 7.25}
    assert json.loads((tmp_path / "mine/spacing.json").read_text()) == spacing
    for scene in PairSet(tmp_path / "mine/all.lst"):
        assert scene.notes == spacing
    assert "range bins of 1.2e-10 s" in describe(tmp_path / "mine")[0]["sizes"]


def test_pairs_of_two_spacings_never_share_a_folder(tmp_path):
    fine = read_dataset(REFERENCE).assign_attrs(bin_size_s=1.2e-10)
    snowsim.scenes(1, rng=1, n_range_lines=32).write(tmp_path / "usual")
    of_fine = snowsim.scenes(1, rng=1, statistics=fine, n_range_lines=32)
    with refusal(
        "spacing.json: bin_size_s: expected .* scenes, 1.2e-10, found 2.886e-10 of others"
    ):
        of_fine.write(tmp_path / "usual", force=True)
    assert_allclose(read_spacing(tmp_path / "usual")["bin_size_s"], 2.886e-10)
    usual, other = PairSet(tmp_path / "usual")[0], of_fine.scene(0)
    other = dataclasses.replace(other, name="other")
    with refusal("other: bin_size_s: expected 2.886e-10 as of the scenes before; .* found 1.2e-10"):
        export_pairs(tmp_path / "both", [usual, other])
    unknown = dataclasses.replace(usual, name="unknown", notes={})
    with refusal("spacing.json: bin_size_s: expected the range bin of the scenes, unknown, found"):
        export_pairs(tmp_path / "usual", [unknown])


def test_numbers_of_lines_may_be_small_integers_of_numpy():
    n_lines = np.uint8(200)
    climate = snowsim.Climate(accumulation_m=0.3)
    drawn, _ = snowsim.simulate(climate, "snow-2012", n_range_lines=n_lines, rng=1)
    assert drawn.sizes["slow_time"] == 200
    image, _ = snowsim.scenes(np.uint8(1), n_range_lines=np.int8(20), rng=1)[0]
    assert image.shape[1] == 20


def test_a_snowpack_that_begins_below_the_surface_is_warned_of():
    with pytest.warns(UserWarning, match="begins 1 m below the mean surface.*is the surface, at 0"):
        snowsim.Snowpack([1, 2.5], [400, 350])


@pytest.mark.parametrize("change", [{"bin_size_s": 0.2886}, {"line_spacing_m": -5.2}])
def test_statistics_of_impossible_spacing_are_refused(change):
    dataset = xr.load_dataset(REFERENCE).assign_attrs(change)
    name, value = next(iter(change.items()))
    with refusal(f"^statistics: {name} must be finite, .*, got {value}"):
        snowsim.scenes(1, statistics=dataset, rng=1)
