"""What renders keep of a scene beyond similarity: where layers lie, texture around the surface."""

from itertools import pairwise

import numpy as np
import pandas as pd
from scipy.ndimage import gaussian_filter

from snowsim.echogram import MINIMUM_ROWS
from snowsim.metrics.image import ssim_map
from snowsim.metrics.texture import autocorrelation, layer_position_error, radial_psd_distance_db

# Kept clear of the surface: half the SSIM window, and the rise of its echo over about 4 bins.
MARGIN_BINS = 8
LEAST_BINS = 16  # rows of a region
BLOTCH_PIXELS = 3.0  # sigma of the average that leaves blotches and takes noise away
N_CLASSES = 4
SHAPES = ("slope", "curvature")


def shape_edges(layer_sets):
    """Quartiles of absolute slope and curvature of all layers of a set of scenes.

    5 edges from 0 to infinity for `slope` [bins per range line] and `curvature` [bins per range
    line squared]; the surface, row 0, is left out.
    """
    # So that a set of no scenes has nothing, instead of no array.
    shapes = {name: [np.empty(0)] for name in SHAPES}
    for layer_bins in layer_sets:
        below = np.asarray(layer_bins, dtype=float)[1:]
        found = layer_position_error(np.zeros((1, below.shape[1])), below)
        for name in SHAPES:
            known = np.isfinite(found[name])
            shapes[name].append(np.abs(found[name][known]))
    edges = {}
    for name, parts in shapes.items():
        values = np.concatenate(parts)
        if values.size == 0:
            msg = (
                "expected layers below the surface, long enough for a slope, found none in any "
                "scene"
            )
            raise ValueError(msg)
        inner = np.quantile(values, np.arange(1, N_CLASSES) / N_CLASSES)
        edges[name] = np.concatenate([[0], inner, [np.inf]])
    return edges


def position_errors(image, layer_bins, edges):
    """Distance from layers to the brightest pixel near them, by the classes of `shape_edges`.

    The surface, row 0, is left out; `n_found` of `n` pixels of layers have a peak in reach. Class 0
    is the flattest.
    """
    found = layer_position_error(image, np.asarray(layer_bins, dtype=float)[1:])
    error = np.abs(found["error_bins"])
    rows = []
    for name in SHAPES:
        shape = np.abs(found[name])
        for shape_class, (low, high) in enumerate(pairwise(edges[name])):
            chosen = (shape >= low) & (shape < high)
            peaks = error[chosen & np.isfinite(error)]
            row = {
                "against": name,
                "shape_class": shape_class,
                "shape_low": low,
                "shape_high": high,
                "n": int(chosen.sum()),
                "n_found": peaks.size,
                "mean_abs_error_bins": peaks.mean() if peaks.size else np.nan,
            }
            rows.append(row)
    return pd.DataFrame(rows)


def surface_regions(layer_bins, n_range_bins):
    """Rows above and below the surface, as slices.

    `below` ends at a row that every scene reaches: all weigh alike.
    """
    surface = np.asarray(layer_bins, dtype=float)[0]
    above = int(np.floor(np.nanmin(surface))) - MARGIN_BINS
    below = int(np.ceil(np.nanmax(surface))) + MARGIN_BINS
    end = min(MINIMUM_ROWS, n_range_bins)
    return {"above": slice(0, max(above, 0)), "below": slice(below, end)}


def texture_by_region(image, observed, layer_bins):
    """Texture of an 8-bit image above and below the surface, and how near it is to the observed.

    `deviation` of grey levels is the contrast; what a constant region does not have is NaN.
    """
    similar = ssim_map(image, observed)
    rows = []
    for region, rows_of in surface_regions(layer_bins, image.shape[0]).items():
        part = image[rows_of].astype(float)
        reference = observed[rows_of].astype(float)
        if len(part) < LEAST_BINS:
            continue
        deviation = part.std()
        along_line = along_bin = distance_db = np.nan
        if deviation > 0:
            [along_line] = autocorrelation(part, [1], along="range_line")
            [along_bin] = autocorrelation(part, [1], along="range_bin")
        if deviation > 0 and reference.std() > 0:
            distance_db = radial_psd_distance_db(part, reference, n_bands=8)
        row = {
            "region": region,
            "deviation": deviation,
            "ssim": similar[rows_of].mean(),
            "autocorrelation_line": along_line,
            "autocorrelation_bin": along_bin,
            "spectrum_distance_db": distance_db,
        }
        rows.append(row)
    return pd.DataFrame(rows)


def air_texture(image, layer_bins):
    """Grey level and texture of the rows above the snow surface, row 0 of `layer_bins`.

    `air_blotches`: deviation once averaged [grey levels]; independent pixels of deviation s leave s
    / 10.6.
    """
    surface = np.asarray(layer_bins, dtype=float)[0]
    known = surface[np.isfinite(surface)]
    highest = int(np.floor(known.min())) if known.size else 0
    n_rows = max(highest - MARGIN_BINS, 0)
    if n_rows < LEAST_BINS:
        msg = f"expected {LEAST_BINS} rows {MARGIN_BINS} bins clear of the surface, got {n_rows}"
        raise ValueError(msg)
    air = np.asarray(image)[:n_rows].astype(float)
    [across] = autocorrelation(air, [1], along="range_line")
    [down] = autocorrelation(air, [1], along="range_bin")
    return {
        "air_mean": float(air.mean()),
        "air_deviation": float(air.std()),
        "air_correlation_across": float(across),
        "air_correlation_down": float(down),
        "air_blotches": float(gaussian_filter(air, BLOTCH_PIXELS).std()),
    }
