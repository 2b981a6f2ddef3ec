"""Similarity of two 8-bit echograms: RMSE, PSNR and SSIM."""

import numpy as np
from numpy.typing import NDArray
from skimage.metrics import structural_similarity

from snowsim.limits import check_unmasked

DATA_RANGE = 255
WINDOW_SIGMA = 1.5  # [pixels]
WINDOW_RADIUS = 5  # [pixels], 3.5 sigma rounded: scikit-image cuts the window off there


def similarity(image: NDArray[np.uint8], reference: NDArray[np.uint8]) -> dict[str, float]:
    """RMSE, PSNR and SSIM of an image against a reference.

    Parameters
    ----------
    image, reference : ndarray of uint8, (range_bin, range_line)

    Returns
    -------
    dict of float
        `rmse` [grey levels], `psnr` [dB] and `ssim`; 0, infinity and 1 for identical images.

    Raises
    ------
    ValueError
        If an image is not uint8 or smaller than 11 x 11, is masked or holds 0 and 1 alone, or if
        sizes differ.

    Notes
    -----
    RMSE is eq. (9), PSNR eq. (10) and SSIM eq. (11) of Yari et al. (2021), IEEE JSTARS 14: ``PSNR =
    10 log10(255^2 / MSE)``. SSIM is the mean of `ssim_map` without the outermost 5 pixels, whose
    windows reach over the border.

    Examples
    --------
    >>> image = np.arange(400, dtype=np.uint8).reshape(20, 20)
    >>> similarity(image, image)
    {'rmse': 0.0, 'psnr': inf, 'ssim': 1.0}
    >>> round(similarity(image // 2, image)["rmse"], 1)
    64.2
    """
    _check_images(image, reference)
    difference = image.astype(np.int32) - reference
    mean_square = np.mean(difference * difference, dtype=np.float64)
    inside = slice(WINDOW_RADIUS, -WINDOW_RADIUS)
    with np.errstate(divide="ignore"):
        psnr = 10 * np.log10(DATA_RANGE**2 / mean_square)
    return {
        "rmse": float(np.sqrt(mean_square)),
        "psnr": float(psnr),
        "ssim": float(ssim_map(image, reference)[inside, inside].mean()),
    }


def ssim_map(image, reference):
    """Structural similarity (SSIM) around every pixel of two uint8 images, float64, at most 1.

    SSIM is luminance x contrast x structure (Wang, Bovik, Sheikh & Simoncelli 2004, IEEE TIP 13);
    with exponents of 1 and ``C3 = C2 / 2`` it is ``(2 m n + C1)(2 cov + C2) / ((m^2 + n^2 + C1)(v +
    w + C2))``. The constants are ``C = (K 255)^2``, K1 0.01 and K2 0.03. The means m and n, the
    variances v and w and the covariance of the two images are weighted by a Gaussian window of
    sigma 1.5 pixels, which ends at 5 pixels; variances and covariance are those of a population,
    without the factor n / (n - 1). Beyond the border images are mirrored, and the edge pixel is
    repeated.
    """
    _, by_pixel = structural_similarity(
        image,
        reference,
        data_range=DATA_RANGE,
        K1=0.01,
        K2=0.03,
        gaussian_weights=True,
        sigma=WINDOW_SIGMA,
        use_sample_covariance=False,
        full=True,
    )
    return by_pixel


def _check_images(image, reference):
    """ValueError unless two images are grey levels, of one size and not smaller than the window.

    Grey levels are uint8 and not masked, and reach above 1 unless all are 0.
    """
    smallest = 2 * WINDOW_RADIUS + 1
    kinds = {np.asarray(image).dtype, np.asarray(reference).dtype}
    shapes = [np.shape(image), np.shape(reference)]
    fits = shapes[0] == shapes[1] and len(shapes[0]) == 2 and min(shapes[0]) >= smallest
    if kinds != {np.dtype(np.uint8)} or not fits:
        msg = (
            "image and reference must be uint8 (range_bin, range_line) of one size, at least "
            f"{smallest} pixels each way, got {shapes[0]} and {shapes[1]} of "
        )
        msg += ", ".join(map(str, kinds))
        raise ValueError(msg)
    for name, values in {"image": image, "reference": reference}.items():
        check_unmasked(name, values)
        if np.max(values) == 1:
            msg = (
                f"{name} must be grey levels from 0 to 255, got none above 1: of an image in "
                "[0, 1] they are (255 * image).astype(np.uint8)"
            )
            raise ValueError(msg)
