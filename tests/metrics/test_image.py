import numpy as np
import pytest
from numpy.testing import assert_allclose
from refusals import refusal
from scipy.ndimage import gaussian_filter

from snowsim.metrics.image import similarity, ssim_map


def mean_near(values):
    """Mean under a Gaussian window of 1.5 pixels, cut at 5, mirrored at the border."""
    return gaussian_filter(values, 1.5, radius=5, mode="reflect")


def test_ssim_is_that_of_its_equation(rng):
    reference, noise = rng.integers(0, 128, (2, 14, 12), dtype=np.uint8)
    image = reference + noise
    x, y = image.astype(float), reference.astype(float)
    m, n = mean_near(x), mean_near(y)
    c1, c2 = 2.55**2, 7.65**2
    luminance = (2 * m * n + c1) / (m**2 + n**2 + c1)
    variances = mean_near(x**2 + y**2) - m**2 - n**2
    # Contrast times structure, with C3 = C2 / 2.
    expected = luminance * (2 * mean_near(x * y) - 2 * m * n + c2) / (variances + c2)
    # Sums of squares up to 1.3e5 in float64 against C2 = 58: 1.3e5 / 58 eps = 5e-13.
    assert_allclose(ssim_map(image, reference), expected, rtol=0, atol=5e-13)
    # Windows of the outermost 5 pixels reach over the border and do not count.
    assert_allclose(similarity(image, reference)["ssim"], expected[5:-5, 5:-5].mean(), atol=5e-13)


def test_a_constant_shift_gives_its_own_size(rng):
    reference = rng.integers(0, 200, (40, 50), dtype=np.uint8)
    scores = similarity(reference + np.uint8(17), reference)
    assert_allclose(scores["rmse"], 17, rtol=1e-14)
    assert_allclose(scores["psnr"], 20 * np.log10(255 / 17), rtol=1e-14)


@pytest.mark.parametrize(("shape", "dtype"), [((20, 20), float), ((20, 21), "u1")])
def test_images_of_other_types_and_sizes_are_refused(shape, dtype):
    with refusal("must be uint8 .* of one size, at least 11 pixels"):
        similarity(np.zeros(shape, dtype), np.zeros((20, 20), np.uint8))


def test_masked_images_and_images_from_0_to_1_are_refused(rng):
    image = rng.integers(0, 200, (20, 20), dtype=np.uint8)
    with refusal("^reference must not be masked, got [0-9]+ masked values"):
        similarity(image, np.ma.masked_less(image, 60))
    with refusal("^image must be grey levels from 0 to 255, got none above 1"):
        similarity(image // 100, image)
