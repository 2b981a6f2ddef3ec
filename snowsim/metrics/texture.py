"""Texture of echograms: number of looks, autocorrelation, radial spectrum, and where layers' peaks lie."""

import numpy as np
from scipy.ndimage import correlate1d
from scipy.signal import savgol_coeffs


def equivalent_number_of_looks(power):
    """Equivalent number of looks of a homogeneous region of linear power, ``mean^2 / variance`` (unbiased variance).

    Infinite where the power is constant. It is the M of Gamma(M) speckle if pixels are independent;
    structure in the region makes it smaller. Refused: fewer than two pixels, negative or infinite
    power, and nothing but zeros.
    """
    power = np.asarray(power, dtype=float)
    if power.size < 2 or not np.isfinite(power).all() or (power < 0).any() or not power.any():
        msg = f"power must be two or more finite values, none negative and not all zero, got {power.size} values"
        raise ValueError(msg)
    with np.errstate(divide="ignore"):
        return float(power.mean() ** 2 / np.var(power, ddof=1))


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


def radial_psd(image, n_bands=32):
    """Power spectral density of an image, averaged over rings of the wavenumber plane.

    Returns the centres of `n_bands` rings of equal width between 0 and 0.5 [cycles per pixel],
    corners beyond left out, and the two-sided density there [unit of the image squared, pixels
    squared] under a Hann window, mean removed: white noise of unit variance gives 1. Images that
    are constant, or too small for a ring to hold a wavenumber, are refused.
    """
    deviation = _deviation(image)
    # Half a sample inside both ends: an even window without zeros, so that no row or column is
    # thrown away.
    windows = [
        np.sin(np.pi * (np.arange(length) + 0.5) / length) ** 2 for length in deviation.shape
    ]
    window = windows[0][:, None] * windows[1]
    spectrum = np.abs(np.fft.fft2(deviation * window)) ** 2 / np.sum(window**2)
    wavenumbers = np.hypot(
        *np.meshgrid(*(np.fft.fftfreq(length) for length in deviation.shape), indexing="ij")
    )
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

    The peak is the brightest pixel of the range line within `search_bins` of the layer and not
    beyond half way to the next layer; of equals their mean. Where the brightest is the first or
    last pixel searched there is no local peak.

    Returns arrays (layer, range_line): `error_bins`, peak less layer (positive: the peak lies
    deeper), NaN without a peak; `slope` [bins per range line] and `curvature` [bins per range line
    squared], of a parabola fitted over `window_lines`, odd and at least 3, NaN where they meet a
    gap or the end of the block.
    """
    image, layer_bins = np.asarray(image, dtype=float), np.asarray(layer_bins, dtype=float)
    if image.ndim != 2 or layer_bins.ndim != 2 or image.shape[1] != layer_bins.shape[1]:
        msg = f"image and layer_bins must cover the same range lines, got shapes {image.shape} and {layer_bins.shape}"
        raise ValueError(msg)
    if not np.isfinite(image).all():
        msg = f"image must be finite, is not at {tuple(int(i) for i in np.argwhere(~np.isfinite(image))[0])}"
        raise ValueError(msg)
    if not search_bins >= 1 or window_lines < 3 or window_lines % 2 == 0:
        got = f"got {search_bins} and {window_lines}"
        msg = f"search_bins must be at least 1 and window_lines odd and at least 3, {got}"
        raise ValueError(msg)
    fits = [savgol_coeffs(window_lines, 2, deriv=order, use="dot") for order in (1, 2)]
    slope, curvature = (
        correlate1d(layer_bins, fit, axis=1, mode="constant", cval=np.nan) for fit in fits
    )
    return {
        "error_bins": _peak_bins(image, layer_bins, search_bins) - layer_bins,
        "slope": slope,
        "curvature": curvature,
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
        msg = (
            f"image must be (range_bin, range_line), finite and not empty, got shape {image.shape}"
        )
        raise ValueError(msg)
    if image.min() == image.max():
        msg = f"image must not be constant, every pixel is {image.flat[0]:g}"
        raise ValueError(msg)
    return image - image.mean()
