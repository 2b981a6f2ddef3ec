"""What renders keep of a scene beyond similarity: where layers lie, and texture above and below the surface."""

import numpy as np
import pandas as pd

from snowsim.echogram import MINIMUM_ROWS
from snowsim.metrics.image import ssim_map
from snowsim.metrics.texture import autocorrelation, layer_position_error, radial_psd_distance_db

MARGIN_BINS = 8  # on both sides of the surface: half the SSIM window, and the rise of the surface's echo
N_CLASSES = 4
SHAPES = ("slope", "curvature")


def shape_edges(layer_sets):
    """Quartiles of absolute slope and curvature over all layers below the surface of a set of scenes.

    Parameters
    ----------
    layer_sets : iterable of ndarray, (layer, range_line)
        Fractional range bins, row 0 the surface, NaN where absent.

    Returns
    -------
    dict of ndarray, (edge,)
        For `slope` [bins per range line] and `curvature` [bins per range line squared], 5 edges from 0 to infinity.

    Raises
    ------
    ValueError
        If no scene has a layer below the surface that is long enough for a slope.
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
    """Distance from layers to the brightest pixel near them, by classes of the layers' slope and curvature.

    Parameters
    ----------
    image : ndarray of uint8, (range_bin, range_line)
    layer_bins : array_like, (layer, range_line)
        Fractional range bins, row 0 the surface, which is left out.
    edges : dict of ndarray
        Of `shape_edges`.

    Returns
    -------
    pandas.DataFrame
        A row per class: `against`, `shape_class` (0 the flattest), `shape_low`, `shape_high`, `n` pixels of layers,
        `n_found` of them with a peak in reach, and over these `mean_abs_error_bins` (NaN without one); see
        `snowsim.metrics.texture.layer_position_error`.
    """
    found = layer_position_error(image, np.asarray(layer_bins, dtype=float)[1:])
    error = np.abs(found["error_bins"])
    rows = []
    for name in SHAPES:
        for shape_class, (low, high) in enumerate(zip(edges[name][:-1], edges[name][1:], strict=True)):
            chosen = (np.abs(found[name]) >= low) & (np.abs(found[name]) < high)
            peaks = error[chosen & np.isfinite(error)]
            rows.append(
                {
                    "against": name,
                    "shape_class": shape_class,
                    "shape_low": low,
                    "shape_high": high,
                    "n": int(chosen.sum()),
                    "n_found": peaks.size,
                    "mean_abs_error_bins": peaks.mean() if peaks.size else np.nan,
                }
            )
    return pd.DataFrame(rows)


def surface_regions(layer_bins, n_range_bins):
    """Rows above and below the surface, with a margin of 8 bins on both sides, as slices by name.

    `below` ends at row 300, which every scene reaches, so that scenes weigh alike.
    """
    surface = np.asarray(layer_bins, dtype=float)[0]
    above = int(np.floor(np.nanmin(surface))) - MARGIN_BINS
    below = int(np.ceil(np.nanmax(surface))) + MARGIN_BINS
    return {"above": slice(0, max(above, 0)), "below": slice(below, min(MINIMUM_ROWS, n_range_bins))}


def texture_by_region(image, observed, layer_bins):
    """Texture of an image above and below the surface, and how near it is to that of the observed scene.

    Parameters
    ----------
    image, observed : ndarray of uint8, (range_bin, range_line)
        The same for the observed scene itself.
    layer_bins : array_like, (layer, range_line)
        Row 0 is the surface.

    Returns
    -------
    pandas.DataFrame
        A row per region of at least 16 rows: `region`; `deviation` of grey levels, the contrast; `autocorrelation_line`
        and `autocorrelation_bin` at lag 1; `spectrum_distance_db`, root mean square ratio of radial spectra to the
        observed, contrast included; mean `ssim` with the observed. The three in between are NaN where a region is
        constant.
    """
    similar = ssim_map(image, observed)
    rows = []
    for region, rows_of in surface_regions(layer_bins, image.shape[0]).items():
        part, reference = image[rows_of].astype(float), observed[rows_of].astype(float)
        if part.shape[0] < 16:
            continue
        row = {"region": region, "deviation": part.std(), "ssim": similar[rows_of].mean()}
        plain = min(part.std(), reference.std()) == 0
        for along in ("range_line", "range_bin"):
            value = np.nan if part.std() == 0 else autocorrelation(part, [1], along=along)[0]
            row[f"autocorrelation_{along.removeprefix('range_')}"] = value
        row["spectrum_distance_db"] = np.nan if plain else radial_psd_distance_db(part, reference, n_bands=8)
        rows.append(row)
    return pd.DataFrame(rows)
