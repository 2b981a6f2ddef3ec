import numpy as np
import pytest
from made_up import made_up_frame
from numpy.testing import assert_allclose, assert_array_equal
from refusals import refusal

from snowsim import echogram as eg
from snowsim.alignment import along_track_m
from snowsim.io import echogram, read_echogram


def make_echogram(n_lines=6):
    return made_up_frame(np.ones((40, n_lines)), np.full((1, n_lines), 5.0))[0]


def test_mask_has_one_pixel_per_layer_and_line_inside_the_window():
    layer_bins = np.array([[0.4, -0.6, 1.0], [3.5, 3.0, np.nan], [9.4, 9.6, 12.0]])
    mask = eg.layer_mask(layer_bins, 10)
    assert_array_equal(np.argwhere(mask), [[0, 0], [1, 2], [3, 1], [4, 0], [9, 0]])


def test_a_scene_without_a_layer_has_no_height():
    with refusal("at least one annotated pixel"):
        eg.scene_height(np.full((2, 3), np.nan))


def test_crossing_is_found_across_gaps():
    layer_bins = np.array([[5.0, 5.0], [np.nan, 7.0], [4.0, 9.0]])
    assert_array_equal(np.argwhere(eg.crossing_layers(layer_bins)), [[2, 0]])
    with refusal("layer 2 does not at range_line 0"):
        eg.check_layer_bins(layer_bins)


def test_eight_bit_scaling_puts_floor_minus_ten_at_0_and_maximum_at_255():
    power = np.full((4, 8), 1e-3)
    power[2, 0] = 1.0
    # Mean -30 dB, as the first row; -50 dB lies below the scale.
    power[3, :4] = 1e-5
    power[3, 4:] = 1e-1
    image, noise_floor_db, maximum_db = eg.to_uint8(power)
    assert_allclose(noise_floor_db, -30, atol=1e-12)
    assert_allclose(maximum_db, 0, atol=1e-12)
    assert image[2, 0] == 255
    assert image[3, 0] == 0
    assert image[0, 0] == 64  # 255 * 10 / 40 = 63.75


def test_eight_bit_image_gives_power_back_within_half_a_step(rng):
    power = rng.gamma(16, 1 / 16, size=(50, 40))
    image, noise_floor_db, maximum_db = eg.to_uint8(power)
    step_db = (maximum_db - noise_floor_db + eg.DB_BELOW_NOISE_FLOOR) / 255
    back_db = eg.from_uint8(image, noise_floor_db, maximum_db)
    assert_allclose(back_db, 10 * np.log10(power), atol=step_db / 2 * (1 + 1e-12))


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (-1, "range_bin 1, range_line 2"),
        (np.inf, "range_bin 1, range_line 2"),
        (1, "without contrast"),
    ],
)
def test_eight_bit_scaling_refuses_what_has_no_decibels_or_no_contrast(value, message):
    power = np.ones((3, 3))
    power[1, 2] = value
    with refusal(message):
        eg.to_uint8(power)


def test_a_good_echogram_passes_in_any_order_of_dimensions():
    eg.check_echogram(make_echogram().transpose("slow_time", "twtt"))


@pytest.mark.parametrize(
    ("break_it", "message"),
    [
        (lambda e: e.drop_vars("Surface"), "f.nc: expected variables Surface"),
        (
            lambda e: e.assign_coords(
                slow_time=e["slow_time"].where(e["slow_time"] != e["slow_time"][3])
            ),
            "f.nc: slow_time: expected a time on every range line, .*first is 3",
        ),
        (lambda e: e.assign(Data=-e["Data"]), "f.nc: Data: expected linear power"),
    ],
)
def test_a_broken_echogram_is_refused_with_the_variable_named(break_it, message):
    with refusal(message):
        eg.check_echogram(break_it(make_echogram()), "f.nc")


def test_distance_along_a_parallel_is_its_radius_times_angle():
    echogram = make_echogram(n_lines=2)
    echogram["Latitude"][:] = 60
    echogram["Longitude"][:] = [-40, -39.98]
    # The great circle is shorter than the parallel by 4e-9.
    assert_allclose(along_track_m(echogram)[1], 6.371e6 / 2 * np.radians(0.02), rtol=1e-8)


def test_a_line_without_position_spoils_no_distance_but_its_own():
    echogram = make_echogram(n_lines=7)
    echogram["Latitude"][:] = 70 + 0.01 * np.arange(7)
    whole_m = along_track_m(echogram)
    echogram["Latitude"][[0, 3, 6]] = np.nan
    distance_m = along_track_m(echogram)
    assert np.isnan(distance_m[[0, 6]]).all()
    # From the first that is known; even steps are those of the whole, to some bits of 3 sums.
    assert_allclose(distance_m[1:6], whole_m[1:6] - whole_m[1], rtol=1e-9, atol=1e-6)


def noise_with(rows, power, n_looks, rng):
    """Noise with a ramp of 20 dB down, and rows of other power."""
    ramp = np.geomspace(1e-9, 1e-7, 400)[:, None]
    noise = rng.gamma(n_looks, 1 / n_looks, size=(400, 300)) * ramp
    noise[rows] = power
    return noise


@pytest.mark.parametrize("n_looks", [1, 6])
@pytest.mark.parametrize("power", [1e-20, 1e-33, 1e-300])
@pytest.mark.parametrize("rows", [[17], range(31), range(390, 400), [3, 200]])
def test_rows_of_a_tiny_number_were_not_recorded(n_looks, power, rows, rng):
    noise = noise_with(rows, power, n_looks, rng)
    found = eg.recorded(noise)
    assert_array_equal(np.flatnonzero(np.isnan(found).any(axis=1)), rows)
    assert np.isnan(found[rows]).all()
    kept = np.isfinite(found)
    assert_array_equal(found[kept], noise[kept])
    with refusal("power must have been recorded, got 1e-.* pixels lie far below all others"):
        eg.to_uint8(noise)


def test_a_band_that_is_as_deep_as_each_line_says_was_not_recorded(rng):
    noise = noise_with([], 0, 6, rng)
    band = np.arange(400)[:, None] < 20 + 10 * np.sin(np.arange(300) / 20)
    noise[band] = 3e-22
    # Two tiny numbers, and zeros, which stay as they are.
    noise[-1] = 1e-37
    noise[5] = 0
    band[-1] = True
    band[5] = False
    assert_array_equal(np.isnan(eg.recorded(noise)), band)


@pytest.mark.parametrize("n_looks", [1, 6])
def test_a_true_row_of_air_60_db_down_and_weak_pixels_were_recorded(n_looks, rng):
    noise = noise_with([], 0, n_looks, rng)
    noise[9] *= 1e-6
    noise[30, 30] *= 1e-4
    # A saturated line, and a scene that is mostly one level.
    noise[:, 7] *= 1e9
    assert eg.recorded(noise) is noise
    quiet = np.full((400, 300), 1e-20)
    quiet[50:60] = 1
    assert eg.recorded(quiet) is quiet
    eg.to_uint8(quiet)


def test_reading_leaves_out_what_was_not_recorded(rng, tmp_path):
    noise = noise_with([4, 5], 5e-25, 6, rng)
    twtt = 1e-6 + 3e-10 * np.arange(400)
    made = echogram(noise, twtt=twtt)
    stored = made_up_frame(noise, np.full((1, 300), 60.0))[0]
    stored.to_netcdf(tmp_path / "frame.nc")
    for frame in (made, read_echogram(tmp_path / "frame.nc")):
        missing = np.isnan(frame["Data"].values).any(axis=1)
        assert_array_equal(np.flatnonzero(missing), [4, 5])
