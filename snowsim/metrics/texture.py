"""Texture of echograms: autocorrelation."""

import numpy as np


def autocorrelation(image, lags, *, along):
    """Autocorrelation of an image, in any unit, about its overall mean at lags [pixels], (lag,).

    ``mean(d(x) d(x + lag)) / mean(d^2)``, d the deviation from the mean of the image; the upper
    mean is over the pairs there are `along` "range_bin" or "range_line". Constant images and lags
    out of range are refused.
    """
    deviation = _deviation(image)
    if along not in ("range_bin", "range_line"):
        msg = f"along must be range_bin or range_line, got {along!r}"
        raise ValueError(msg)
    if along == "range_line":
        deviation = deviation.T
    length = deviation.shape[0]
    outside = [lag for lag in lags if not 0 <= lag < length]
    if outside:
        msg = f"lags must lie in [0, {length - 1}] along {along}, got {outside[0]}"
        raise ValueError(msg)
    pairs = [np.mean(deviation[: length - lag] * deviation[lag:]) for lag in lags]
    return np.array(pairs) / np.mean(deviation**2)


def _deviation(image):
    """Deviation of a 2-D image from its mean; ValueError if there is none."""
    image = np.asarray(image, dtype=float)
    if image.ndim != 2 or image.size == 0 or not np.isfinite(image).all():
        got = f"got shape {image.shape}"
        msg = f"image must be (range_bin, range_line), finite and not empty, {got}"
        raise ValueError(msg)
    if image.min() == image.max():
        msg = f"image must not be constant, every pixel is {image.flat[0]:g}"
        raise ValueError(msg)
    return image - image.mean()
