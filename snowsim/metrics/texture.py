"""Texture of echograms.

Number of looks, autocorrelation, radial spectrum, and where layers' peaks lie.
"""

import numpy as np
from scipy.ndimage import correlate1d
from scipy.signal import savgol_coeffs


def equivalent_number_of_looks(power):
    """Equivalent number of looks of a homogeneous region of linear power, ``mean^2 / variance``.

    The variance is the unbiased one; infinite where the power is constant. It is the M of Gamma(M)
    speckle if pixels are independent; structure in the region makes it smaller. Refused: fewer than
    two pixels, negative or infinite power, and nothing but zeros.
    """
    power = np.asarray(power, dtype=float)
    valid = np.isfinite(power) & (power >= 0)
    if power.size < 2 or not valid.all() or not power.any():
        wanted = "two or more finite values, none negative and not all zero"
        msg = f"power must be {wanted}, got {power.size} values"
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
    n_bins, n_lines = deviation.shape
    window = _hann(n_bins)[:, None] * _hann(n_lines)
    spectrum = np.abs(np.fft.fft2(deviation * window)) ** 2 / np.sum(window**2)
    wavenumbers = np.hypot(np.fft.fftfreq(n_bins)[:, None], np.fft.fftfreq(n_lines))
    band = (wavenumbers * (2 * n_bands)).astype(int)
    used = (band < n_bands) & (wavenumbers > 0)
    n_in_band = np.bincount(band[used], minlength=n_bands)
    if (n_in_band == 0).any():
        ring = f"ring {np.argmin(n_in_band)} of {n_bands}"
        msg = f"image of {deviation.shape} pixels leaves {ring} empty"
        raise ValueError(msg)
    total = np.bincount(band[used], weights=spectrum[used], minlength=n_bands)
    centres = (np.arange(n_bands) + 0.5) / (2 * n_bands)
    return centres, total / n_in_band


def _hann(length):
    # Half a sample inside both ends: even, and without zeros that throw a row or column away.
    return np.sin(np.pi * (np.arange(length) + 0.5) / length) ** 2


def radial_psd_distance_db(image, reference, n_bands=32):
    """Root mean square over the rings of the ratio of two radial spectra [dB].

    Images may differ in size.

    0 means equal spectra, contrast included: an image of twice the contrast is 6 dB away.
    """
    _, psd = radial_psd(image, n_bands)
    _, expected = radial_psd(reference, n_bands)
    ratio_db = 10 * np.log10(psd / expected)
    return float(np.sqrt(np.mean(ratio_db**2)))


def layer_position_error(image, layer_bins, *, search_bins=10, window_lines=9):
    """Distance from every layer to the peak of an image near it; its slope and curvature.

    The peak is the brightest pixel of the range line within `search_bins` of the layer and not
    beyond half way to the next layer; of equals their mean. Where the brightest is the first or
    last pixel searched there is no local peak.

    Returns arrays (layer, range_line): `error_bins`, peak less layer (positive: the peak lies
    deeper), NaN without a peak; `slope` [bins per range line] and `curvature` [bins per range line
    squared], of a parabola fitted over `window_lines`, odd and at least 3, NaN where they meet a
    gap or the end of the block.
    """
    image = np.asarray(image, dtype=float)
    layer_bins = np.asarray(layer_bins, dtype=float)
    if image.ndim != 2 or layer_bins.ndim != 2 or image.shape[1] != layer_bins.shape[1]:
        got = f"got shapes {image.shape} and {layer_bins.shape}"
        msg = f"image and layer_bins must cover the same range lines, {got}"
        raise ValueError(msg)
    infinite = np.argwhere(~np.isfinite(image))
    if infinite.size:
        msg = f"image must be finite, is not at {tuple(infinite[0].tolist())}"
        raise ValueError(msg)
    if not search_bins >= 1 or window_lines < 3 or window_lines % 2 == 0:
        got = f"got {search_bins} and {window_lines}"
        msg = f"search_bins must be at least 1 and window_lines odd and at least 3, {got}"
        raise ValueError(msg)

    def derivative(order):
        fit = savgol_coeffs(window_lines, 2, deriv=order, use="dot")
        return correlate1d(layer_bins, fit, axis=1, mode="constant", cval=np.nan)

    return {
        "error_bins": _peak_bins(image, layer_bins, search_bins) - layer_bins,
        "slope": derivative(1),
        "curvature": derivative(2),
    }


def _peak_bins(image, layer_bins, search_bins):
    """Bin of the brightest pixel in reach of each layer, NaN where it ends the reach."""
    above, below = _half_way(layer_bins)
    last_row = image.shape[0] - 1
    highest = np.maximum(np.maximum(layer_bins - search_bins, above), 0)
    lowest = np.minimum(np.minimum(layer_bins + search_bins, below), last_row)
    farthest = int(search_bins) + 1
    offsets = np.arange(-farthest, farthest + 1)[:, None, None]
    present = np.isfinite(layer_bins)
    centre = np.rint(np.where(present, layer_bins, 0)).astype(int)
    rows = centre + offsets
    inside = present & (rows >= highest) & (rows <= lowest)
    shown = image[np.clip(rows, 0, last_row), np.arange(image.shape[1])]
    values = np.where(inside, shown, -np.inf)
    brightest = (values == values.max(axis=0)) & inside
    n_brightest = brightest.sum(axis=0)
    peak = np.sum(rows * brightest, axis=0) / np.maximum(n_brightest, 1)
    ends = (rows - 1 < highest) | (rows + 1 > lowest)
    at_an_end = (brightest & ends).any(axis=0)
    return np.where((n_brightest > 0) & ~at_an_end, peak, np.nan)


def _half_way(layer_bins):
    """Bins half way to the nearest layer above and below each, -inf and inf where there is none."""
    present = np.isfinite(layer_bins)
    above = np.full(layer_bins.shape, -np.inf)
    below = np.full(layer_bins.shape, np.inf)
    above[1:] = np.where(present, layer_bins, -np.inf)[:-1]
    below[:-1] = np.where(present, layer_bins, np.inf)[1:]
    above = np.maximum.accumulate(above, axis=0)
    below = np.minimum.accumulate(below[::-1], axis=0)[::-1]
    return (layer_bins + above) / 2, (layer_bins + below) / 2


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
