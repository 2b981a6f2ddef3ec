"""Parts of an error add up, and each is seen where it was planted."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from evaluation.lib.renders import air_texture
from evaluation.lib.similarity import (
    PARTS,
    as_bytes,
    error_parts,
    with_other_speckle,
    without_speckle,
)
from snowsim.echogram import to_uint8
from snowsim.metrics.image import similarity


@pytest.fixture
def power(rng):
    """Mean power of a flat, layered scene, (range_bin, range_line)."""
    row = np.arange(200)[:, None]
    strong = 300 * np.exp(-np.abs(row - 60) / 9)
    weak = 30 * np.exp(-np.abs(row - 110) / 6)
    return np.broadcast_to(1 + strong + weak, (200, 256))


def test_parts_add_up_to_the_mean_square_error(rng):
    image, reference = rng.integers(0, 256, (2, 40, 50), dtype=np.uint8)
    parts = error_parts(image, reference)
    assert list(parts) == list(PARTS)
    # Sums of 2000 float64 values: 1e-12 of the largest of them.
    mean_square = similarity(image, reference)["rmse"] ** 2
    assert_allclose(sum(parts.values()), mean_square, rtol=1e-11)


@pytest.mark.parametrize(
    ("error", "part"),
    [
        (np.full((40, 640), 3.0), "grey level"),
        (3.0 * (-1.0) ** np.arange(40)[:, None] * np.ones(640), "mean by depth"),
        (3.0 * np.sign(np.arange(640) - 319.5) * np.ones((40, 1)), "along track"),
    ],
)
def test_a_planted_error_falls_into_its_part(error, part):
    reference = np.full((40, 640), 100.0)
    parts = error_parts(reference + error, reference)
    # A step along track loses what averaging takes off its edge: 4 * 6 / sqrt(pi) of 640 lines at
    # most.
    tolerance = 0.03 if part == "along track" else 1e-12
    assert_allclose(parts[part], 9, rtol=tolerance)
    assert_allclose(parts["speckle observed"], 0, atol=1e-24)


def test_speckle_of_either_image_falls_into_its_part(rng):
    reference = np.full((200, 256), 100.0)
    noise = 7 * rng.standard_normal(reference.shape)
    parts = error_parts(reference + noise, reference)
    # Averaging over sigma 6 keeps 1 / (2 sqrt(pi) 6) of the variance of white noise, and takes that
    # off twice.
    kept = 1 / (2 * np.sqrt(np.pi) * 6)
    taken_off = 2 / (np.sqrt(2 * np.pi) * 6)
    expected = 49 * (1 - taken_off + kept)
    # 51200 draws: the variance is known to sqrt(2 / n) = 0.6 %; allow four of those.
    tolerance = 4 * np.sqrt(2 / noise.size)
    assert_allclose(parts["speckle of the render"], expected, rtol=tolerance)
    assert_allclose(parts["speckle observed"], 0, atol=1e-24)
    swapped = error_parts(reference, reference + noise)
    assert_allclose(swapped["speckle observed"], expected, rtol=0.03)


def test_other_speckle_is_as_far_off_as_a_second_observation_of_the_same_snow(power, rng):
    def observed():
        return power * rng.gamma(16, 1 / 16, power.shape)

    image, floor_db, maximum_db = to_uint8(observed())
    grey_per_db = 255 / (maximum_db - floor_db + 10)
    second_db = 10 * np.log10(observed()) - floor_db + 10
    second = as_bytes(second_db * grey_per_db)
    redrawn = with_other_speckle(image, floor_db, maximum_db, 16, rng=rng)
    truly = similarity(second, image)
    estimated = similarity(redrawn, image)
    # The speckle that stays in the mean, 1 / (2 sqrt(pi) 6) = 5 % of its variance in power, counts
    # for the bound.
    assert_allclose(estimated["rmse"], truly["rmse"], rtol=0.05)
    assert_allclose(estimated["ssim"], truly["ssim"], atol=0.04)


def test_without_speckle_keeps_what_is_flat_along_track():
    flat = np.repeat(np.arange(30.0)[:, None], 40, axis=1)
    assert_allclose(without_speckle(flat), flat, rtol=1e-12)


def test_bytes_are_rounded_and_end_at_their_ends_and_images_of_two_sizes_are_refused():
    levels = np.array([-3.0, 0.4, 99.6, 300.0])
    assert_array_equal(as_bytes(levels), [0, 0, 100, 255])
    with pytest.raises(ValueError, match="must have one size"):
        error_parts(np.zeros((3, 3)), np.zeros((3, 4)))


def test_air_of_noise_has_no_texture_and_blotches_are_seen(rng):
    surface = np.full((1, 256), 60.0)
    noise = 100 + 8 * rng.standard_normal((120, 256))
    texture = air_texture(noise, surface)
    n = 52 * 256
    assert_allclose(texture["air_mean"], 100, atol=4 * 8 / np.sqrt(n))
    assert_allclose(texture["air_deviation"], 8, rtol=4 / np.sqrt(2 * n))
    # Autocorrelations of white noise scatter by 1 / sqrt(n).
    assert_allclose(texture["air_correlation_across"], 0, atol=4 / np.sqrt(n))
    assert_allclose(texture["air_correlation_down"], 0, atol=4 / np.sqrt(n))
    # A Gaussian of sigma 3 leaves 1 / (2 sqrt(pi) 3) of the deviation; about n / (4 pi 9) = 118
    # values are independent.
    left = 8 / (2 * np.sqrt(np.pi) * 3)
    assert_allclose(texture["air_blotches"], left, rtol=4 / np.sqrt(2 * 118))
    blotched = noise + 5 * np.sin(np.arange(256) / 20)
    assert air_texture(blotched, surface)["air_blotches"] > 3
    noise[60:] = 250  # what lies below the surface does not count
    assert air_texture(noise, surface) == texture


@pytest.mark.parametrize("surface", [np.full((1, 20), 10.0), np.full((2, 20), np.nan)])
def test_too_little_air_is_refused(surface):
    with pytest.raises(ValueError, match="expected 16 rows 8 bins clear of the surface"):
        air_texture(np.zeros((100, 20)), surface)
