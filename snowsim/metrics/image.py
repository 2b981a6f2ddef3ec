"""Similarity of two 8-bit echograms: RMSE, PSNR and SSIM."""

import numpy as np
from skimage.metrics import structural_similarity

DATA_RANGE = 255
WINDOW_SIGMA = 1.5  # [pixels]
WINDOW_RADIUS = 5  # 3.5 sigma, where scikit-image cuts the window


def similarity(image, reference):
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
        If an image is not uint8 or smaller than 11 x 11, or if sizes differ.

    Notes
    -----
    RMSE eq. (9), PSNR eq. (10) and SSIM eq. (11) of Yari et al. (2021), IEEE JSTARS 14:
    ``PSNR = 10 log10(255^2 / MSE)``. SSIM is the mean of `ssim_map` without the outermost 5 pixels,
    whose windows reach over the border.

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
    """Structural similarity around every pixel of two uint8 images, float64, at most 1.

    Luminance x contrast x structure with exponents 1 and ``C3 = C2 / 2``, Wang, Bovik, Sheikh &
    Simoncelli (2004), IEEE TIP 13: ``(2 m n + C1)(2 cov + C2) / ((m^2 + n^2 + C1)(v + w + C2))``,
    ``C = (K 255)^2``, K1 0.01, K2 0.03. Moments are those of the population under a Gaussian
    window, sigma 1.5 pixels, cut at 5; within 5 pixels of the border both images are mirrored, the
    edge pixel repeated. Refuses what `similarity` refuses.
    """
    _check_images(image, reference)
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
    for name, values in (("image", image), ("reference", reference)):
        if not isinstance(values, np.ndarray) or values.dtype != np.uint8:
            got = values.dtype if isinstance(values, np.ndarray) else type(values).__name__
            msg = f"{name} must be a numpy array of uint8, got {got}"
            raise ValueError(msg)
    if image.shape != reference.shape:
        msg = f"image and reference must have one size, got {image.shape} and {reference.shape}"
        raise ValueError(msg)
    smallest = 2 * WINDOW_RADIUS + 1
    if image.ndim != 2 or min(image.shape) < smallest:
        wanted = f"(range_bin, range_line) and at least {smallest} pixels each way"
        msg = f"images must be {wanted}, got {image.shape}"
        raise ValueError(msg)
