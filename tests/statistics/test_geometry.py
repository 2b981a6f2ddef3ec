"""Processes with known spectra: their statistics, and label sets drawn from these."""

from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from numpy.testing import assert_allclose, assert_array_equal
from scipy.ndimage import gaussian_filter1d, uniform_filter1d

from snowsim.labels import draw_scene, prepare
from snowsim.labels.process import HALF_CYCLE_SHOWS
from snowsim.statistics.blocks import BAND_EDGES, periodogram, pick_noise, stretches
from snowsim.statistics.surface import surface_statistics
from snowsim.statistics.zones import as_variables, zone_statistics

LAGS = (1, 2, 4, 8, 16, 32, 64, 128, 255)  # of structure functions [range lines]
N_LINES, N_LONG = 256, 4096
LONG = np.fft.rfftfreq(N_LONG)


def mean_square_differences(series):
    """Mean squares of differences at `LAGS`, and of second differences, (..., lag and one)."""
    differences = [series[..., lag:] - series[..., :-lag] for lag in LAGS]
    differences.append(np.diff(series, 2))
    return np.stack([np.mean(part**2, axis=-1) for part in differences], axis=-1)


def matern(wavenumber, knee, slope):
    """Density 1 at wavenumber 0, falling with `slope` beyond `knee` cycles a block."""
    return (1 + (wavenumber * N_LINES / knee) ** 2) ** (-slope / 2)


def series_of(density, shape, rng):
    """Series of a one-sided density at `LONG`, cut from sixteen times as long ones.

    No period of the block.
    """
    real, imaginary = rng.standard_normal((2, *shape, LONG.size))
    white = real + 1j * imaginary
    long = np.fft.irfft(white * np.sqrt(density * N_LONG / 4), N_LONG)
    return long[..., 1000 : 1000 + N_LINES]


def thickness_of(deviation, rng, sd=4.0):
    level = rng.uniform(30, 60, (len(deviation), 1, 1))
    share = 1 + 0.02 * rng.standard_normal((*deviation.shape[:2], 1))
    return level * share + sd * deviation


@pytest.mark.parametrize("slope", [2, 4, 6])
@pytest.mark.parametrize("knee", [4, 8])
def test_a_matern_spectrum_comes_back_to_1_db_and_50_db_down(knee, slope, rng):
    thickness = thickness_of(series_of(matern(LONG, knee, slope), (500, 2), rng), rng)
    density = zone_statistics(thickness, n_zones=1)["thickness_psd"].mean(axis=(0, 1)) / 16
    cycle = np.arange(1, N_LINES // 2)
    truth = matern(cycle / N_LINES, knee, slope)
    held = (cycle >= 3) & (truth > 1e-5)
    difference_db = 10 * np.log10(density[1 : N_LINES // 2] / truth)
    # 1000 periodograms: to 0.14 dB a wavenumber.
    assert np.abs(difference_db)[held].max() < 1


def test_errors_of_a_picker_as_long_as_it_averages_are_left_out(rng):
    spectrum = matern(LONG, 4, 6)
    deviation = series_of(spectrum, (500, 2), rng)
    errors = uniform_filter1d(rng.standard_normal(deviation.shape), 9, axis=-1)
    exact = zone_statistics(thickness_of(deviation, rng), n_zones=1)["thickness_psd"]
    picked = thickness_of(deviation + errors, rng)
    as_picked = zone_statistics(picked, n_zones=1)["thickness_psd"]
    held = zone_statistics(picked, n_zones=1, finest_lines=16)["thickness_psd"]
    assert (as_picked[..., 17:30] > 3 * exact[..., 17:30]).all()
    assert (held[..., 17:] == 0).all()
    assert_array_equal(held[..., :17], as_picked[..., :17])


def test_a_white_series_keeps_its_density_and_variance(rng):
    series = 3 * rng.standard_normal((4000, N_LINES))
    density = periodogram(series, tapered=True).mean(axis=0)
    assert_allclose(density[1:-1], 18, rtol=5 / np.sqrt(4000))
    assert_allclose(density.sum() / N_LINES, 9 * 255 / 256, rtol=0.01)  # 4000 x 128 values


def test_what_half_a_cycle_shows_in_the_first_two():
    phase = 2 * np.pi * np.arange(16)[:, None] / 16
    half_turn = np.pi * np.arange(N_LINES) / N_LINES
    waves = np.sqrt(2) * np.cos(half_turn + phase)
    density = periodogram(waves, tapered=True).mean(axis=0)
    assert_allclose(density[1:3] / N_LINES, HALF_CYCLE_SHOWS, rtol=0.01)


def statistics_of(thickness, rows=None, **settings):
    rows = [np.full(N_LINES, 50.0)] if rows is None else rows
    surface = surface_statistics([SimpleNamespace(surface_bins=row) for row in rows], 1)
    coords = {
        "band_edge_wavenumber": ("band_edge", BAND_EDGES / N_LINES),
        "wavenumber": np.fft.rfftfreq(N_LINES),
    }
    zones = as_variables(zone_statistics(thickness, **settings))
    return xr.Dataset(zones | surface, coords=coords)


def drawn_from(statistics, n_scenes, rng, **settings):
    model = prepare(statistics, N_LINES, radiometry="constant", **settings)
    return [draw_scene(model, N_LINES, name="", rng=rng) for _ in range(n_scenes)]


def mean_differences(scenes):
    """Mean square differences of slab thickness of label sets, (slab, lag) averaged over all."""
    slabs = [np.diff(scene.layer_bins, axis=0) for scene in scenes]
    return np.mean([mean_square_differences(part).mean(axis=0) for part in slabs], axis=0)


@pytest.mark.parametrize("knee", [0.5, 1.5, 6])
def test_structure_functions_of_labels_are_those_of_the_blocks(knee, rng):
    deviation = series_of(matern(LONG, knee, 4) / knee, (500, 3), rng)
    thickness = thickness_of(deviation, rng, sd=1.0)
    scenes = drawn_from(statistics_of(thickness, n_zones=1), 500, rng, n_layers=(3, 3))
    truth = mean_square_differences(thickness).mean(axis=(0, 1))
    drawn = mean_differences(scenes)
    # 1500 series on either side: the slowest, one wave each, to 2 x 3.7 %.
    assert_allclose(drawn[:-2] / truth[:-2], 1, atol=0.15)
    assert_allclose(np.sqrt(drawn[-1] / truth[-1]), 1, atol=0.05)
    # At a block's whole length what is slower matters, of which the trend tells but one number.
    assert LAGS[-1] == N_LINES - 1
    assert_allclose(drawn[-2] / truth[-2], 1, atol=0.25)


def test_noise_of_picks_is_found_by_layer_and_not_drawn(rng):
    deviation = series_of(matern(LONG, 4, 6), (200, 4), rng)
    smooth = thickness_of(deviation, rng)
    planted = np.array([0.2, 0.3, 0.5, 0.2, 0.2])
    noise = planted[:, None] * rng.standard_normal((200, 5, N_LINES))
    picked = smooth + np.diff(noise, axis=1)
    found = zone_statistics(picked, n_zones=1)
    inner = slice(1, -1)
    # 200 blocks of 31 wavenumbers, paired by the taper: products to about 6 % of the geometric mean
    # of squares.
    error = found["pick_noise_bins2_standard_error"][inner]
    variance = planted[inner] ** 2
    assert np.all(np.abs(found["pick_noise_bins2"][inner] - variance) < 4 * error)
    assert np.all(error < 0.1 * variance + 0.01)
    none, _ = pick_noise(smooth, np.ones((200, 4), dtype=bool), 4)
    assert none.max() < 1e-4 * planted.min() ** 2
    scenes = drawn_from(statistics_of(picked, n_zones=1), 200, rng, n_layers=(4, 4), surface="flat")
    drawn = mean_differences(scenes)
    truth = mean_square_differences(smooth).mean(axis=(0, 1))
    noisy = mean_square_differences(picked).mean(axis=(0, 1))
    # What the noise hides of the steepest bends is lost with it; the rest stays, 800 series to some
    # 5 %.
    assert_allclose(drawn[4:8] / truth[4:8], 1, atol=0.2)
    assert noisy[-1] > 20 * truth[-1] > 20 * drawn[-1]


def surface_rows(n, rng, *, levelled):
    """A slow error of 0.9 bins, and what whole-bin levelling leaves of a movement of many."""
    white = rng.standard_normal((2, n, N_LINES + 200))
    smooth = gaussian_filter1d(white[0], 20)[:, 100:-100]
    # Smoothing by 20 lines leaves 1 / sqrt(40 sqrt(pi)) of white noise.
    slow = 0.9 * np.sqrt(40 * np.sqrt(np.pi)) * smooth
    way = np.cumsum(gaussian_filter1d(white[1], 5), axis=1)[:, 100:-100]
    left = way - np.rint(way) if levelled else 0
    return 50 + slow + left


@pytest.mark.parametrize("levelled", [True, False])
def test_the_surface_is_drawn_as_observed(levelled, rng):
    rows = surface_rows(300, rng, levelled=levelled)
    deviation = series_of(matern(LONG, 4, 4), (40, 2), rng)
    statistics = statistics_of(thickness_of(deviation, rng), rows)
    assert_allclose(statistics["surface_fraction"], float(levelled), atol=0.1)
    drawn = np.array([s.layer_bins[0] for s in drawn_from(statistics, 300, rng)])
    observed = mean_square_differences(rows).mean(axis=0)
    ratio = mean_square_differences(drawn).mean(axis=0) / observed
    assert_allclose(ratio[:-2], 1, atol=0.15)
    assert not levelled or abs(ratio[-1] - 1) < 0.1
    flat = drawn_from(statistics, 2, rng, surface="flat")
    assert_array_equal([s.layer_bins[0] for s in flat], 50)


def test_number_of_layers_and_first_slab_are_those_of_the_zone(rng):
    deviation = series_of(matern(LONG, 4, 4), (400, 12), rng)
    thickness = thickness_of(deviation, rng, sd=0.5)
    level = thickness[:, 0].mean(axis=1)
    n_layers = np.where(level > np.median(level), 3, rng.choice([5, 6, 7, 12], 400))
    thickness[np.arange(12) >= n_layers[:, None]] = np.nan
    statistics = statistics_of(thickness, n_zones=2)
    assert_array_equal(statistics["n_blocks_by_layers"].sum("n_layers"), 200)
    scenes = drawn_from(statistics, 800, rng)
    first = np.array([s.notes["first_thickness_bins"] for s in scenes])
    n = np.array([s.notes["n_layers"] for s in scenes])
    edge = float(statistics["zone_edge_bins"][1])
    assert set(n[first > max(edge, 46)]) == {3}
    thin = n[first < min(edge, 44)]
    assert thin.min() >= 3
    assert abs(np.median(thin) - 6) <= 1
    # Quantiles of 400 and 800 values of a range of 30 bins: to 30 x 0.5 sqrt(3 / 800) = 0.9.
    at = [0.1, 0.25, 0.5, 0.75, 0.9]
    assert_allclose(np.quantile(first, at), np.quantile(level, at), atol=3)


def test_label_models_name_what_statistics_lack(rng):
    deviation = series_of(matern(LONG, 4, 4), (40, 2), rng)
    statistics = statistics_of(thickness_of(deviation, rng), tapered=False)
    lacking = {
        "n_layers": "n_blocks_by_layers",
        "first_slab": "first_thickness_quantile_bins",
        "surface": "surface_psd",
    }
    other = {"n_layers": (5, 40), "first_slab": "uniform", "surface": "flat"}
    for setting, name in lacking.items():
        lesser = statistics.drop_vars(name)
        with pytest.raises(ValueError, match=f"need {name}"):
            prepare(lesser, N_LINES, radiometry="constant")
        prepare(lesser, N_LINES, radiometry="constant", **{setting: other[setting]})


def test_spectra_are_those_of_the_longest_stretches_that_are_often_whole(rng):
    deviation = series_of(matern(LONG, 8, 2), (300, 2), rng)
    thickness = thickness_of(deviation, rng)
    whole = zone_statistics(thickness, n_zones=1)["thickness_psd"]
    thickness[:, :, 100:104] = np.nan
    assert stretches(thickness, 4).shape == (600, 2, 128)
    result = zone_statistics(thickness, n_zones=1)
    assert result["n_spectral_lines"] == 128
    assert result["n_psd_samples"].tolist() == [[300, 300]]
    of_halves = result["thickness_psd"][..., 8:120].mean(axis=(0, 1))
    # 300 periodograms of half the resolution, which the knee hardly bends.
    assert_allclose(of_halves / whole[..., 8:120].mean(axis=(0, 1)), 1, atol=0.3)
    thickness[:, :, ::8] = np.nan
    with pytest.raises(
        ValueError, match="stretches of 16 lines of a slab without gaps .* at least 1, got 0"
    ):
        zone_statistics(thickness)


def test_neighbours_are_known_to_be_opposite_though_picks_have_gaps(rng):
    n_blocks, n_layers = 200, 8
    # Layers undulate independently, so what thickens a slab thins its neighbours.
    position = series_of(matern(LONG, 40, 4), (n_blocks, n_layers), rng)
    thickness = rng.uniform(30, 60, (n_blocks, 1, 1)) + np.diff(position, axis=1)
    start = rng.integers(0, 60, thickness.shape[:2])
    for block, slab in np.ndindex(start.shape):
        for first in range(start[block, slab], 256, 90):
            thickness[block, slab, first : first + 30] = np.nan
    result = zone_statistics(thickness, n_zones=1, finest_lines=16)
    assert result["n_spectral_lines"] == 32
    correlation = result["thickness_correlation"]
    # Some 1500 pairs of stretches: known to 0.03 in the lowest bands, of one wavenumber.
    assert_allclose(correlation[:3, 1], -0.5, atol=0.08)
    assert np.abs(correlation[:3, 2:]).max() < 0.12
    # Every slab has its own spectrum: eight cycles of a block are one of 32 lines.
    density = result["thickness_psd"][0, :, 8]
    truth = 2 * matern(8 / N_LINES, 40, 4)
    assert np.abs(10 * np.log10(density / truth)).max() < 1


def test_stretches_without_gaps_count_only_where_slab_0_places_the_block(rng):
    thickness = 20 + rng.standard_normal((8, 2, 256))
    # No block has both slabs: slab 1 says nothing of slab 0.
    thickness[:4, 1] = np.nan
    thickness[4:, 0] = np.nan
    thickness[:4, 0, ::8] = np.nan
    with pytest.raises(
        ValueError, match="that slab 0 places must be a whole number of at least 1, got 0"
    ):
        zone_statistics(thickness)
