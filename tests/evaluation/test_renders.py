"""Positions of layers and texture in renders, and published numbers, on planted answers."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from evaluation.lib.renderers import position_rows
from evaluation.lib.renders import position_errors, shape_edges, surface_regions, texture_by_region
from lib.brightness import expected_levels
from lib.fades import draw_fades
from snowsim.cgan.inputs import observed_levels
from snowsim.echogram import Scene, to_db
from snowsim.front import REFERENCE
from snowsim.io.files import read_dataset
from snowsim.labels import Dress, draw_scene, prepare
from snowsim.phy import render_scene
from snowsim.seeding import random_stream

N_LINES = 128
FLAT = np.full((1, N_LINES), 50.0)  # a surface


def wavy_layers(amplitude=6.0):
    lines = np.arange(N_LINES)
    surface = np.full(N_LINES, 50.0)
    wave = 100 + amplitude * np.sin(lines / 8)
    slope = 160 + 0.2 * lines
    return np.array([surface, wave, slope])


def image_of(layer_bins, shift=0, n_range_bins=320):
    """Black but for one bright pixel per layer and range line, `shift` bins below the layer."""
    image = np.zeros((n_range_bins, layer_bins.shape[1]), dtype=np.uint8)
    lines = np.arange(layer_bins.shape[1])
    for bins in layer_bins:
        rows = np.rint(bins).astype(int) + shift
        image[rows, lines] = 200
    return image


@pytest.mark.parametrize("shift", [0, 3])
def test_planted_shifts_come_back_in_every_class(shift):
    layers = wavy_layers()
    edges = shape_edges([layers])
    table = position_errors(image_of(layers, shift), layers, edges)
    off_bins = np.abs(table["mean_abs_error_bins"] - shift)
    # Layers lie between pixels: rounding moves a peak by up to half a bin.
    assert (off_bins <= 0.5).all()
    assert (table["n"] == table["n_found"]).all()


def test_classes_are_quarters_hold_every_pixel_once_and_order_layers_by_how_they_bend():
    layers = wavy_layers()
    table = position_errors(image_of(layers), layers, shape_edges([layers]))
    for _, rows in table.groupby("against"):
        assert list(rows["shape_class"]) == [0, 1, 2, 3]
        # Two layers below the surface; a slope needs 4 range lines on both sides.
        assert rows["n"].sum() == 2 * (N_LINES - 8)
    straight = wavy_layers(0.0)
    wave = wavy_layers(8.0)
    edges = shape_edges([wave[:2]])
    assert edges["curvature"][0] == 0
    assert np.isinf(edges["curvature"][-1])
    table = position_errors(image_of(straight), straight, edges)
    table = table.set_index(["against", "shape_class"])
    assert table.loc[("curvature", 0), "n"] == 2 * (N_LINES - 8)


def test_scenes_without_layers_below_the_surface_have_no_edges():
    with pytest.raises(ValueError, match="found none in any scene"):
        shape_edges([FLAT])


def test_regions_keep_clear_of_the_surface():
    layers = np.array([np.linspace(45.0, 55.0, N_LINES)])
    regions = surface_regions(layers, 800)
    assert regions["above"] == slice(0, 45 - 8)
    assert regions["below"] == slice(55 + 8, 300)


def test_noise_has_no_texture_and_a_smoothed_image_has(rng):
    noise = rng.integers(0, 256, (320, N_LINES)).astype(np.uint8)
    of_two = (noise[:, :-1].astype(int) + noise[:, 1:]) // 2
    smooth = np.pad(of_two.astype(np.uint8), ((0, 0), (0, 1)), mode="edge")
    of_noise = texture_by_region(noise, noise, FLAT).set_index("region")
    of_smooth = texture_by_region(smooth, noise, FLAT).set_index("region")
    # 42 x 128 and 242 x 128 pixels: the lag-1 correlation of noise is known to 1 / sqrt(n); four of
    # those.
    for region, n in {"above": 42 * 128, "below": 242 * 128}.items():
        likeness = of_noise.loc[region, "autocorrelation_line"]
        assert_allclose(likeness, 0, atol=4 / np.sqrt(n))
        likeness = of_smooth.loc[region, "autocorrelation_line"]
        # The mean of two neighbours correlates by one half with the next.
        assert_allclose(likeness, 0.5, atol=6 / np.sqrt(n))
    assert_allclose(of_noise["spectrum_distance_db"], 0, atol=1e-9)
    assert_allclose(of_noise["ssim"], 1, rtol=1e-12)
    assert (of_smooth["spectrum_distance_db"] > 1).all()


def test_a_constant_region_has_no_texture_and_one_of_few_rows_is_left_out(rng):
    flat = np.full((320, N_LINES), 7, dtype=np.uint8)
    table = texture_by_region(flat, flat, FLAT)
    assert (table["deviation"] == 0).all()
    missing = table[["autocorrelation_line", "autocorrelation_bin", "spectrum_distance_db"]].isna()
    assert missing.to_numpy().all()
    noise = rng.integers(0, 256, (320, N_LINES)).astype(np.uint8)
    table = texture_by_region(noise, noise, FLAT - 30)
    assert list(table["region"]) == ["below"]


def test_a_planted_shift_is_the_position_error_of_a_scene_and_its_geometry_stands_beside_it():
    layers = wavy_layers()
    scene = Scene("planted", 320, layers, image_of(layers, 3))
    bare = Scene("bare", 320, FLAT)
    row = position_rows("cgan", [scene, bare], lambda scene: False).iloc[0]
    # Rounded to whole bins, and blurred along track by four lines of layers that bend.
    assert abs(row["error_bins"] - 3) <= 0.5
    assert row["share_found"] > 0.95
    assert (row["height"], row["layers"]) == (320, 2)


def test_layers_and_snow_of_phys_render_are_as_bright_as_expected():
    flight = read_dataset(REFERENCE)
    model = prepare(flight, 64, dress=Dress(n_looks=16))
    labels = draw_scene(model, 64, name="bright", rng=np.random.default_rng(1))
    rng = random_stream(7, "render_phy", labels.name)
    render = render_scene(labels, rng=rng, tolerance_db=0.05)
    observed = observed_levels(render.image, labels.layer_bins, labels.n_range_bins)
    expected = expected_levels(labels, flight)
    error = expected.of_layers - observed.of_layers
    # Three times the speckle of 16 looks in means of 33 lines, 0.19 dB, of the surface's 40 dB; and
    # some for its tails.
    assert np.sqrt(np.nanmean(error**2)) < 0.02
    # Means over 2,000 pixels, or 30 patches of texture of 0.6 dB and 60 gains of 0.4 dB: 0.15 dB of
    # 40. Where the surface rises 40 dB in a bin, a tenth of a bin is 4 dB, of 25 bins 0.16 dB.
    error = expected.of_snow - observed.of_snow
    assert np.sqrt(np.mean(error**2)) < 0.015


def test_a_scene_high_above_its_noise_has_less_contrast_and_fades_are_asked_for():
    flight = read_dataset(REFERENCE)
    model = prepare(flight, 64, dress=Dress(n_looks=16))
    labels = draw_scene(model, 64, name="bright", rng=np.random.default_rng(1))
    levels = expected_levels(labels, flight)
    quieter = replace(labels.echoes, noise_power=labels.echoes.noise_power / 10)
    of_quieter = expected_levels(replace(labels, echoes=quieter), flight)
    # 10 dB more between uppermost layer and noise.
    raised_db = levels.contrast / of_quieter.contrast
    usual_db = np.nanmean(to_db(labels.echoes.power[0] / labels.echoes.noise_power)) + 10
    assert_allclose(raised_db, 1 + 10 / usual_db, rtol=0.01)

    assert np.all(levels.fades == 0)
    faded = expected_levels(labels, flight, fade_spread=3.0, rng=np.random.default_rng(2)).fades
    drawn = draw_fades(labels.layer_bins[0], labels.n_range_bins, 3.0, rng=np.random.default_rng(2))
    assert_array_equal(faded, drawn)
