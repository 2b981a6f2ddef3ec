"""What renders keep of a scene beyond similarity: where layers lie, and texture above and below the surface.

Texture above the snow surface, where there is nothing but noise.
Errors against what may cause them: depth, slope, curvature.
"""

import numpy as np
import pandas as pd
from scipy.ndimage import gaussian_filter

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


AIR_MARGIN_BINS = 8  # kept clear of the highest surface: its echo rises over about 4 bins
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
    n_rows = int(np.floor(np.nanmin(surface))) - AIR_MARGIN_BINS if np.isfinite(surface).any() else 0
    if n_rows < LEAST_BINS:
        msg = f"expected {LEAST_BINS} rows {AIR_MARGIN_BINS} bins clear of the surface, got {max(n_rows, 0)}"
        raise ValueError(msg)
    air = image[:n_rows].astype(float)
    return {
        "air_mean": float(air.mean()),
        "air_deviation": float(air.std()),
        "air_correlation_across": float(autocorrelation(air, [1], along="range_line")[0]),
        "air_correlation_down": float(autocorrelation(air, [1], along="range_bin")[0]),
        "air_blotches": float(gaussian_filter(air, BLOTCH_PIXELS).std()),
    }


def error_by_band(error, value, edges):
    """Summarise errors in bands of another quantity.

    Parameters
    ----------
    error : array_like
        NaN where the thing sought was not found.
    value : array_like, the shape of `error`
        What the bands are of; entries with NaN count nowhere.
    edges : array_like, (band + 1,)
        Ascending; a band holds its lower edge, the last one both.

    Returns
    -------
    pandas.DataFrame
        A row per band: `low, high, n, share_found, mean, mean_absolute, rms`; `n` counts found and not found, the last
        three are NaN where nothing was found.

    Raises
    ------
    ValueError
        If shapes differ or edges do not ascend.
    """
    error, value, edges = (np.asarray(array, dtype=float) for array in (error, value, edges))
    if error.shape != value.shape:
        msg = f"error and value must have one shape, got {error.shape} and {value.shape}"
        raise ValueError(msg)
    if edges.ndim != 1 or edges.size < 2 or not (np.diff(edges) > 0).all():
        msg = f"edges must be two or more ascending numbers, got {edges.tolist()}"
        raise ValueError(msg)
    band = np.searchsorted(edges, value, side="right") - 1
    band[value == edges[-1]] = edges.size - 2
    rows = []
    for i in range(edges.size - 1):
        inside = error[band == i]
        found = inside[np.isfinite(inside)]
        none = found.size == 0
        rows.append(
            {
                "low": edges[i],
                "high": edges[i + 1],
                "n": inside.size,
                "share_found": found.size / inside.size if inside.size else np.nan,
                "mean": np.nan if none else found.mean(),
                "mean_absolute": np.nan if none else np.abs(found).mean(),
                "rms": np.nan if none else np.sqrt(np.mean(found**2)),
            }
        )
    return pd.DataFrame(rows)
