import numpy as np
import pytest
from numpy.lib.stride_tricks import sliding_window_view
from numpy.testing import assert_allclose

from snowsim.metrics.image import similarity, ssim_map


def draw_pair(rng, shape=(60, 80)):
    reference = rng.integers(0, 256, shape, dtype=np.uint8)
    return np.clip(reference + rng.normal(0, 30, shape), 0, 255).astype(np.uint8), reference


def test_identical_images_score_exactly(rng):
    image, _ = draw_pair(rng)
    assert similarity(image, image.copy()) == {"rmse": 0, "psnr": np.inf, "ssim": 1}


def test_ssim_is_luminance_times_contrast_times_structure(rng):
    image, reference = draw_pair(rng, (14, 12))
    weights = np.exp(-0.5 * (np.arange(-5, 6) / 1.5) ** 2)
    weights = np.outer(weights, weights) / weights.sum() ** 2
    mirrored = [np.pad(each.astype(float), 5, mode="symmetric") for each in (image, reference)]
    windows = [sliding_window_view(each, (11, 11)) for each in mirrored]
    m, n = (np.sum(weights * each, axis=(2, 3)) for each in windows)
    from_m, from_n = (
        each - mean[..., None, None] for each, mean in zip(windows, (m, n), strict=True)
    )
    sd_m, sd_n = (np.sqrt(np.sum(weights * each**2, axis=(2, 3))) for each in (from_m, from_n))
    covariance = np.sum(weights * from_m * from_n, axis=(2, 3))
    c1, c2 = 2.55**2, 7.65**2
    mean_squares = m**2 + n**2
    luminance = (2 * m * n + c1) / (mean_squares + c1)
    variances = sd_m**2 + sd_n**2
    contrast = (2 * sd_m * sd_n + c2) / (variances + c2)
    structure = (covariance + c2 / 2) / (sd_m * sd_n + c2 / 2)
    expected = luminance * contrast * structure
    # Sums of squares up to 1.3e5 in float64 against C2 = 58: 1.3e5 / 58 eps = 5e-13.
    assert_allclose(ssim_map(image, reference), expected, rtol=0, atol=5e-13)
    # Windows of the outermost 5 pixels reach over the border and do not count.
    assert_allclose(similarity(image, reference)["ssim"], expected[5:-5, 5:-5].mean(), atol=5e-13)


def test_a_constant_shift_gives_its_own_size_and_black_against_white_is_zero_decibels(rng):
    reference = rng.integers(0, 200, (40, 50), dtype=np.uint8)
    scores = similarity(reference + np.uint8(17), reference)
    assert_allclose(scores["rmse"], 17, rtol=1e-14)
    assert_allclose(scores["psnr"], 20 * np.log10(255 / 17), rtol=1e-14)
    black, white = np.zeros((20, 20), dtype=np.uint8), np.full((20, 20), 255, dtype=np.uint8)
    scores = similarity(black, white)
    assert scores["rmse"] == 255
    assert scores["psnr"] == 0
    assert_allclose(scores["ssim"], 2.55**2 / (255**2 + 2.55**2))


@pytest.mark.parametrize(
    ("image", "reference"),
    [
        (np.zeros((20, 20)), np.zeros((20, 20), np.uint8)),
        (np.zeros((20, 20), np.uint8), np.zeros((20, 21), np.uint8)),
        (np.zeros((20, 10), np.uint8), np.zeros((20, 10), np.uint8)),
    ],
)
def test_bad_images_are_refused(image, reference):
    with pytest.raises(ValueError, match="must be uint8 .* of one size, at least 11 pixels"):
        similarity(image, reference)
