import numpy as np
import pytest
from made_up import BIN_S, made_up_frame
from numpy.testing import assert_allclose, assert_array_equal
from refusals import refusal

from snowsim.alignment import align_layers, flatten, layer_bins_of, resample_range
from snowsim.constants import SPEED_OF_LIGHT_M_S
from snowsim.echogram import check_echogram, check_layers

SWELL = 60 + 10 * np.sin(np.arange(60) / 9)


def make_frame(rng, n_lines=60, surface_bins=SWELL, elevation_m=2500.0):
    """An echogram with two bright layers, and the layers, on the same lines."""
    bins = np.array([surface_bins, surface_bins + 40])[:, :n_lines]
    power = rng.gamma(4, 0.25e-3, size=(200, n_lines)).astype(np.float32)
    for row in bins:
        power[np.rint(row).astype(int), np.arange(n_lines)] = 1.0
    echogram, layers = made_up_frame(power, bins)
    echogram["Elevation"][:] = elevation_m
    echogram["Time"] = echogram["twtt"].drop_vars("twtt")  # as in datasets of xopr
    layers = layers.assign(Elevation=echogram["Elevation"].copy())
    return echogram, layers.assign_coords(layer=["surface", "Koenig_2"])


def test_gaps_and_holes_stay_and_on_its_own_lines_nothing_changes(rng):
    echogram, layers = make_frame(rng)
    layers["twtt"][1, 20] = np.nan
    aligned = align_layers(layers, echogram)
    assert_array_equal(aligned["twtt"], layers["twtt"])
    check_layers(aligned)
    # Files round times of one line differently.
    rounded = layers.assign_coords(slow_time=layers["slow_time"] + np.timedelta64(300, "ns"))
    assert_array_equal(align_layers(rounded, echogram)["twtt"], layers["twtt"])
    coarse = layers.isel(slow_time=slice(None, None, 4))
    missing = np.isnan(align_layers(coarse, echogram.isel(slow_time=slice(0, 57)))["twtt"].values)
    # Line 20 is missing, and what would lean on it; the surface is untouched.
    assert_array_equal(np.flatnonzero(missing[1]), np.arange(17, 24))
    assert not missing[0].any()
    holed = layers.isel(slow_time=np.r_[0:20, 30:60])
    missing = np.isnan(align_layers(holed, echogram)["twtt"].values)
    # The outermost picks hold for a line; the surface has no picks there, either.
    assert_array_equal(np.flatnonzero(missing[0]), np.arange(21, 29))
    assert_array_equal(missing[0], missing[1])


def test_aligned_layers_lie_on_the_line_between_picks(rng):
    echogram, layers = make_frame(rng, surface_bins=60 + 0.5 * np.arange(60))
    coarse = layers.isel(slow_time=slice(None, None, 4))
    aligned = align_layers(coarse, echogram.isel(slow_time=slice(0, 57)))
    # The layers are straight lines: interpolation is exact up to rounding of 3 us to 4e-22 s.
    assert_allclose(aligned["twtt"], layers["twtt"][:, :57], atol=4e-21)


def test_layers_follow_the_height_of_the_echogram_antenna(rng):
    echogram, layers = make_frame(rng)
    layers["Elevation"] = layers["Elevation"] - 0.3
    aligned = align_layers(layers, echogram)
    later = aligned["twtt"].values - layers["twtt"].values
    # An antenna 0.3 m higher sees everything 0.6 m / c later; elevations of 2500 m round to 5e-13
    # m, 3e-21 s.
    assert_allclose(later, 0.6 / SPEED_OF_LIGHT_M_S, atol=1e-20)


COVER = "a.mat: slow_time: expected to cover 2012-01-01T00:00:00.*, found 50 lines"
WINDOW = "a.mat: twtt: expected layers within the echogram's window"


@pytest.mark.parametrize(
    ("lines", "shift_bins", "message"),
    [
        (slice(0, 50), 0, COVER),
        (slice(10, 60), 0, COVER),
        (slice(None), -61, WINDOW),
        (slice(None), 100, WINDOW),
    ],
)
def test_layers_must_cover_the_echogram_and_lie_within_it(rng, lines, shift_bins, message):
    echogram, layers = make_frame(rng, surface_bins=np.full(60, 60.0))
    layers["twtt"] = layers["twtt"] + shift_bins * BIN_S
    with refusal(message):
        align_layers(layers.isel(slow_time=lines), echogram, where="a.mat")


def test_layers_of_another_place_are_refused(rng):
    echogram, layers = make_frame(rng)
    layers = layers.assign(echogram[["Latitude", "Longitude"]] + 0.01)  # 1.2 km at 70 degrees
    with refusal(
        "a.mat: positions: expected those of the echogram.*, found them 1\\d\\d\\d m away"
    ):
        align_layers(layers, echogram, where="a.mat")


def test_flattening_puts_every_surface_into_one_row_loses_no_pixel_and_moves_layers_along(rng):
    echogram, layers = make_frame(rng)
    level, moved = flatten(echogram, layers)
    check_echogram(level)
    check_layers(moved)
    rows = np.nanargmax(level["Data"].values[:120], axis=0)
    assert np.unique(rows).size == 1
    # Whole bins: what is left of the surface lies within half a bin of that row.
    assert_allclose(layer_bins_of(moved, level)[0], rows[0], atol=0.5 + 1e-6)
    before, after = echogram["Data"].values.T, level["Data"].values.T
    kept = np.isfinite(after)
    assert_array_equal(after[kept].reshape(before.shape), before)
    # The first finite bin is the one that was first, later by the shift of the layers.
    first_s = level["twtt"].values[kept.argmax(axis=1)]
    shift_s = (moved["twtt"] - layers["twtt"]).values[1]
    assert_allclose(first_s - echogram["twtt"].values[0], shift_s, atol=1e-20)
    # Every reflector keeps its height: z - c t / 2.
    height = level["Elevation"] - SPEED_OF_LIGHT_M_S / 2 * level["Surface"]
    assert_allclose(
        height, echogram["Elevation"] - SPEED_OF_LIGHT_M_S / 2 * echogram["Surface"], rtol=1e-13
    )


@pytest.mark.parametrize("method", ["surface", "elevation"])
def test_a_level_frame_comes_back_untouched(rng, method):
    elevation_m = 2500 + 0.5 * np.sin(np.arange(60) / 7)
    level = flatten(*make_frame(rng, elevation_m=elevation_m), method=method)
    again = flatten(*level, method=method)
    assert again[0] is level[0]
    assert again[1] is level[1]


def test_elevation_compensation_levels_the_aircraft_and_not_the_terrain(rng):
    # Flat terrain under an aircraft that climbs 1 m: the surface echo comes later by 2 m / c, 23.1
    # bins.
    climb_m = np.linspace(0, 1, 60)
    surface_bins = 60 + climb_m * 2 / SPEED_OF_LIGHT_M_S / BIN_S
    level, moved = flatten(
        *make_frame(rng, surface_bins=surface_bins, elevation_m=2500 + climb_m), method="elevation"
    )
    # Whole bins: half a bin from the aircraft, as much from the range of the surface.
    assert np.ptp(layer_bins_of(moved, level)[0]) < 1 + 1e-6
    assert np.ptp(level["Elevation"].values) < SPEED_OF_LIGHT_M_S / 2 * BIN_S * (1 + 1e-6)


def test_gaps_of_the_surface_are_bridged_and_one_that_is_nowhere_picked_is_refused(rng):
    # A straight slope without halves, so that the bridge is exact and rounds as the picks do.
    echogram, layers = make_frame(rng, surface_bins=60 + 0.4 * np.arange(60))
    layers["twtt"][0, 20:30] = np.nan
    level, moved = flatten(echogram, layers)
    assert np.ptp(np.nanargmax(level["Data"].values[:130], axis=0)) == 0
    assert np.isnan(moved["twtt"].values[0, 20:30]).all()
    with refusal("method must be one of surface, elevation, none"):
        flatten(echogram, layers, method="flat")
    assert flatten(echogram, layers, method="none")[0] is echogram
    layers["twtt"][0] = np.nan
    with refusal("not known on any range line"):
        flatten(echogram, layers)


@pytest.mark.parametrize("ratio", [2.6, 3])
def test_larger_bins_equal_the_slow_area_average(rng, ratio):
    echogram, _ = make_frame(rng, n_lines=3)
    power = echogram["Data"].values.astype(float)
    found = resample_range(echogram, ratio * BIN_S)["Data"].values
    bins = np.arange(200)
    for row in (0, 1, 7, 30):
        low, high = ratio * row + 0.5 + np.array([-ratio / 2, ratio / 2])
        shares = np.clip(np.minimum(bins + 1, high) - np.maximum(bins, max(low, 0)), 0, None)
        assert_allclose(found[row], shares @ power / shares.sum(), rtol=1e-6)


def test_smaller_bins_lie_on_the_line_between_centres(rng):
    echogram, _ = make_frame(rng)
    power = echogram["Data"].values
    resampled = resample_range(echogram, BIN_S / 2)
    fine = resampled["Data"].values
    assert_allclose(resampled["twtt"][::2], echogram["twtt"], rtol=1e-12)
    # The ratio of bin sizes is exact to 1e-13 of the travel time's own digits; so are the weights.
    assert_allclose(fine[::2], power, rtol=1e-5)
    assert_allclose(fine[1::2], (power[1:].astype(float) + power[:-1]) / 2, rtol=1e-5)


def test_missing_bins_stay_missing_in_bins_of_another_size(rng):
    echogram, _ = make_frame(rng)
    echogram["Data"][50, 3] = np.nan
    for ratio in (0.5, 2):
        missing = np.isnan(resample_range(echogram, ratio * BIN_S)["Data"].values)
        assert missing[:, 3].any()
        assert not np.delete(missing, 3, axis=1).any()
        assert missing.sum() <= 3


@pytest.mark.parametrize("bin_s", [0, -1e-10, np.nan, 1.0])
def test_impossible_bin_sizes_are_refused(rng, bin_s):
    with refusal("bin_s"):
        resample_range(make_frame(rng)[0], bin_s)
