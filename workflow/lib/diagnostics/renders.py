"""What renders keep of a scene beyond similarity: where layers lie, and texture above and below the snow surface."""

import numpy as np
import pandas as pd
from scipy.ndimage import gaussian_filter

from snowsim.echogram import MINIMUM_ROWS
from snowsim.metrics.image import ssim_map
from snowsim.metrics.texture import autocorrelation, layer_position_error, radial_psd_distance_db

MARGIN_BINS = (
    8  # kept clear of the surface: half the SSIM window, and the rise of its echo over about 4 bins
)
LEAST_BINS = 16  # rows of a region
BLOTCH_PIXELS = 3.0  # sigma of the average that leaves blotches and takes noise away
N_CLASSES = 4
SHAPES = ("slope", "curvature")


def shape_edges(layer_sets):
    """Quartiles of absolute slope and curvature over all layers below the surface, row 0, of a set of scenes.

    5 edges from 0 to infinity for `slope` [bins per range line] and `curvature` [bins per range
    line squared].
    """
    shapes = {name: [] for name in SHAPES}
    for layer_bins in layer_sets:
        below = np.asarray(layer_bins, dtype=float)[1:]
        found = layer_position_error(np.zeros((1, below.shape[1])), below)
        for name in SHAPES:
            values = np.abs(found[name])
            shapes[name].append(values[np.isfinite(values)])
    edges = {}
    for name in SHAPES:
        values = np.concatenate([np.empty(0), *shapes[name]])
        if values.size == 0:
            msg = "expected layers below the surface, long enough for a slope, found none in any scene"
            raise ValueError(msg)
        inner = np.quantile(values, np.arange(1, N_CLASSES) / N_CLASSES)
        edges[name] = np.concatenate([[0], inner, [np.inf]])
    return edges


def position_errors(image, layer_bins, edges):
    """Distance from layers to the brightest pixel near them, by the classes of slope and curvature of `shape_edges`.

    The surface, row 0, is left out; `n_found` of `n` pixels of layers have a peak in reach. Class 0
    is the flattest.
    """
    found = layer_position_error(image, np.asarray(layer_bins, dtype=float)[1:])
    error = np.abs(found["error_bins"])
    rows = []
    for name in SHAPES:
        for shape_class, (low, high) in enumerate(
            zip(edges[name][:-1], edges[name][1:], strict=True)
        ):
            chosen = (np.abs(found[name]) >= low) & (np.abs(found[name]) < high)
            peaks = error[chosen & np.isfinite(error)]
            mean = peaks.mean() if peaks.size else np.nan
            rows.append((name, shape_class, low, high, int(chosen.sum()), peaks.size, mean))
    columns = "against shape_class shape_low shape_high n n_found mean_abs_error_bins"
    return pd.DataFrame(rows, columns=columns.split())


def surface_regions(layer_bins, n_range_bins):
    """Rows above and below the surface, as slices; `below` ends at a row that every scene reaches: all weigh alike."""
    surface = np.asarray(layer_bins, dtype=float)[0]
    above = int(np.floor(np.nanmin(surface))) - MARGIN_BINS
    below = int(np.ceil(np.nanmax(surface))) + MARGIN_BINS
    return {
        "above": slice(0, max(above, 0)),
        "below": slice(below, min(MINIMUM_ROWS, n_range_bins)),
    }


def texture_by_region(image, observed, layer_bins):
    """Texture of an 8-bit image above and below the surface, and how near it is to that of the observed scene.

    `deviation` of grey levels is the contrast; what a constant region does not have is NaN.
    """
    similar = ssim_map(image, observed)
    rows = []
    for region, rows_of in surface_regions(layer_bins, image.shape[0]).items():
        part, reference = image[rows_of].astype(float), observed[rows_of].astype(float)
        if part.shape[0] < LEAST_BINS:
            continue
        row = {"region": region, "deviation": part.std(), "ssim": similar[rows_of].mean()}
        plain = min(part.std(), reference.std()) == 0
        for along in ("range_line", "range_bin"):
            value = np.nan if part.std() == 0 else autocorrelation(part, [1], along=along)[0]
            row[f"autocorrelation_{along.removeprefix('range_')}"] = value
        row["spectrum_distance_db"] = (
            np.nan if plain else radial_psd_distance_db(part, reference, n_bands=8)
        )
        rows.append(row)
    return pd.DataFrame(rows)


def air_texture(image, layer_bins):
    """Grey level and texture of the rows above the snow surface, row 0 of `layer_bins`.

    `air_blotches`: deviation once averaged [grey levels]; independent pixels of deviation s leave s
    / 10.6.
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
