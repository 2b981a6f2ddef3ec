"""Texture of echograms: number of looks, autocorrelation, radial spectrum, and where layers' peaks lie."""

import numpy as np
from scipy.ndimage import correlate1d
from scipy.signal import savgol_coeffs


def equivalent_number_of_looks(power):
    """Equivalent number of looks of a homogeneous region.

    Parameters
    ----------
    power : array_like, any shape
        Linear power of one mean level, not negative.

    Returns
    -------
    float
        ``mean^2 / variance`` (unbiased variance), infinite where the power is constant. It is the M of Gamma(M) speckle
        if pixels are independent; structure in the region makes it smaller.

    Raises
    ------
    ValueError
        If there are fewer than two pixels, or one is negative or not finite, or all are zero.
    """
    power = np.asarray(power, dtype=float)
    if power.size < 2 or not np.isfinite(power).all() or (power < 0).any() or not power.any():
        msg = f"power must be two or more finite values, none negative and not all zero, got {power.size} values"
        raise ValueError(msg)
    with np.errstate(divide="ignore"):
        return float(power.mean() ** 2 / np.var(power, ddof=1))


def autocorrelation(image, lags, *, along):
    """Autocorrelation of an image about its overall mean.

    Parameters
    ----------
    image : array_like, (range_bin, range_line)
        In any unit; decibels or grey levels are usual.
    lags : sequence of int
        [pixels], from 0 to the image's length less one.
    along : {"range_bin", "range_line"}
        Vertical or horizontal.

    Returns
    -------
    ndarray, (lag,)
        ``mean(d(x) d(x + lag)) / mean(d^2)``, d the deviation from the mean of the image; the upper mean is over the
        pairs there are.

    Raises
    ------
    ValueError
        If the image is constant, not finite or not 2-D, or if a lag is out of range.
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


def radial_psd(image, n_bands=32):
    """Power spectral density of an image, averaged over rings of the wavenumber plane.

    Parameters
    ----------
    image : array_like, (range_bin, range_line)
    n_bands : int
        Rings of equal width between wavenumber 0 and 0.5 cycles per pixel; corners beyond are left out.

    Returns
    -------
    wavenumber : ndarray, (band,)
        Centre of each ring [cycles per pixel].
    psd : ndarray, (band,)
        Two-sided density [unit of the image squared, pixels squared] under a Hann window, mean removed: white noise
        of unit variance gives 1.

    Raises
    ------
    ValueError
        If the image is constant, not finite or not 2-D, or too small for a ring to hold a wavenumber.
    """
    deviation = _deviation(image)
    # Half a sample inside both ends: an even window without zeros, so that no row or column is thrown away.
    windows = [np.sin(np.pi * (np.arange(length) + 0.5) / length) ** 2 for length in deviation.shape]
    window = windows[0][:, None] * windows[1]
    spectrum = np.abs(np.fft.fft2(deviation * window)) ** 2 / np.sum(window**2)
    wavenumbers = np.hypot(*np.meshgrid(*(np.fft.fftfreq(length) for length in deviation.shape), indexing="ij"))
    band = (wavenumbers * (2 * n_bands)).astype(int)
    used = (band < n_bands) & (wavenumbers > 0)
    n_in_band = np.bincount(band[used], minlength=n_bands)
    if (n_in_band == 0).any():
        msg = f"image of {deviation.shape} pixels leaves ring {np.argmin(n_in_band)} of {n_bands} empty"
        raise ValueError(msg)
    psd = np.bincount(band[used], weights=spectrum[used], minlength=n_bands) / n_in_band
    return (np.arange(n_bands) + 0.5) / (2 * n_bands), psd


def radial_psd_distance_db(image, reference, n_bands=32):
    """Root mean square over the rings of the ratio of two radial spectra [dB]; images may differ in size.

    0 means equal spectra, contrast included: an image of twice the contrast is 6 dB away.
    """
    ratio = radial_psd(image, n_bands)[1] / radial_psd(reference, n_bands)[1]
    return float(np.sqrt(np.mean((10 * np.log10(ratio)) ** 2)))


def layer_position_error(image, layer_bins, *, search_bins=10, window_lines=9):
    """Distance from every layer to the peak that an image shows near it, with the layer's slope and curvature.

    The peak is the brightest pixel of the range line within `search_bins` of the layer and not beyond half way to the
    next layer; of equals their mean. Where the brightest is the first or last pixel searched there is no local peak.

    Parameters
    ----------
    image : array_like, (range_bin, range_line)
    layer_bins : array_like, (layer, range_line)
        Fractional range bins; NaN where absent.
    search_bins : float
        [range bins]
    window_lines : int
        Odd number, at least 3, of range lines over which a parabola is fitted for slope and curvature.

    Returns
    -------
    dict of ndarray, (layer, range_line)
        `error_bins`, peak less layer (positive: the peak lies deeper), NaN without a peak; `slope` [bins per range
        line] and `curvature`, the second derivative [bins per range line squared], NaN where the fit's window meets a
        gap or the end of the block.

    Raises
    ------
    ValueError
        If widths differ, the image is not finite and 2-D, `search_bins` is below 1 or `window_lines` not odd and >= 3.
    """
    image, layer_bins = np.asarray(image, dtype=float), np.asarray(layer_bins, dtype=float)
    if image.ndim != 2 or layer_bins.ndim != 2 or image.shape[1] != layer_bins.shape[1]:
        msg = f"image and layer_bins must cover the same range lines, got shapes {image.shape} and {layer_bins.shape}"
        raise ValueError(msg)
    if not np.isfinite(image).all():
        msg = f"image must be finite, is not at {tuple(int(i) for i in np.argwhere(~np.isfinite(image))[0])}"
        raise ValueError(msg)
    if not search_bins >= 1 or window_lines < 3 or window_lines % 2 == 0:
        msg = (
            f"search_bins must be at least 1 and window_lines odd and at least 3, got {search_bins} and {window_lines}"
        )
        raise ValueError(msg)
    derivatives = [
        correlate1d(
            layer_bins,
            savgol_coeffs(window_lines, 2, deriv=order, use="dot"),
            axis=1,
            mode="constant",
            cval=np.nan,
        )
        for order in (1, 2)
    ]
    return {
        "error_bins": _peak_bins(image, layer_bins, search_bins) - layer_bins,
        "slope": derivatives[0],
        "curvature": derivatives[1],
    }


def _peak_bins(image, layer_bins, search_bins):
    """Bin of the brightest pixel in reach of each layer, NaN where it lies at an end of the reach."""
    above, below = _half_way(layer_bins)
    highest = np.maximum(np.maximum(layer_bins - search_bins, above), 0)
    lowest = np.minimum(np.minimum(layer_bins + search_bins, below), image.shape[0] - 1)
    offsets = np.arange(-int(search_bins) - 1, int(search_bins) + 2)[:, None, None]
    present = np.isfinite(layer_bins)
    centre = np.rint(np.where(present, layer_bins, 0)).astype(int)
    rows = centre + offsets
    inside = present & (rows >= highest) & (rows <= lowest)
    lines = np.broadcast_to(np.arange(image.shape[1]), rows.shape)
    values = np.where(inside, image[np.clip(rows, 0, image.shape[0] - 1), lines], -np.inf)
    brightest = (values == values.max(axis=0)) & inside
    n_brightest = brightest.sum(axis=0)
    peak = np.sum(rows * brightest, axis=0) / np.maximum(n_brightest, 1)
    ends = inside & ((rows - 1 < highest) | (rows + 1 > lowest))
    return np.where((n_brightest > 0) & ~(brightest & ends).any(axis=0), peak, np.nan)


def _half_way(layer_bins):
    """Bins half way to the nearest layer present above and below each layer, -inf and inf where there is none."""
    present = np.isfinite(layer_bins)
    from_above = np.maximum.accumulate(np.where(present, layer_bins, -np.inf), axis=0)
    from_below = np.minimum.accumulate(np.where(present, layer_bins, np.inf)[::-1], axis=0)[::-1]
    above, below = np.full(layer_bins.shape, -np.inf), np.full(layer_bins.shape, np.inf)
    above[1:], below[:-1] = from_above[:-1], from_below[1:]
    return (layer_bins + above) / 2, (layer_bins + below) / 2


def _deviation(image):
    """Deviation of a 2-D image from its mean; ValueError if there is none."""
    image = np.asarray(image, dtype=float)
    if image.ndim != 2 or image.size == 0 or not np.isfinite(image).all():
        msg = f"image must be (range_bin, range_line), finite and not empty, got shape {image.shape}"
        raise ValueError(msg)
    if image.min() == image.max():
        msg = f"image must not be constant, every pixel is {image.flat[0]:g}"
        raise ValueError(msg)
    return image - image.mean()
