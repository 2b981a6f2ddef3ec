"""Texture above the snow surface, where there is nothing but noise."""

import numpy as np
from scipy.ndimage import gaussian_filter

from snowsim.metrics.texture import autocorrelation

MARGIN_BINS = 8  # kept clear of the highest surface: its echo rises over about 4 bins
LEAST_BINS = 16
BLOTCH_PIXELS = 3.0  # sigma of the average that leaves blotches and takes noise away


def air_texture(image, layer_bins):
    """Grey level and texture of the rows above the snow surface.

    Parameters
    ----------
    image : ndarray of uint8, (range_bin, range_line)
    layer_bins : array_like, (layer, range_line)
        Row 0 the surface.

    Returns
    -------
    dict of float
        `air_mean`, `air_deviation` [grey levels]; `air_correlation_across` and `air_correlation_down`, autocorrelation
        at lag 1 along track and down; `air_blotches`, standard deviation once averaged by a Gaussian of 3 pixels [grey
        levels]: independent pixels of deviation s leave s / 10.6.

    Raises
    ------
    ValueError
        If fewer than 16 rows are clear of the surface.
    """
    image, surface = np.asarray(image), np.asarray(layer_bins, dtype=float)[0]
    n_rows = int(np.floor(np.nanmin(surface))) - MARGIN_BINS if np.isfinite(surface).any() else 0
    if n_rows < LEAST_BINS:
        msg = f"expected {LEAST_BINS} rows {MARGIN_BINS} bins clear of the surface, got {max(n_rows, 0)}"
        raise ValueError(msg)
    air = image[:n_rows].astype(float)
    return {
        "air_mean": float(air.mean()),
        "air_deviation": float(air.std()),
        "air_correlation_across": float(autocorrelation(air, [1], along="range_line")[0]),
        "air_correlation_down": float(autocorrelation(air, [1], along="range_bin")[0]),
        "air_blotches": float(gaussian_filter(air, BLOTCH_PIXELS).std()),
    }
