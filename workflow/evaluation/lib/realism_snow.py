"""Snow in numbers: years of cores, real and drawn, density logs, thickness of layers."""

from itertools import pairwise

import numpy as np

from snowsim.reference.echo import draw_layering
from snowsim.reference.line import line_length_km

# As the cores of west Greenland: places, their distance, years.
N_PLACES = 16
PLACE_KM = 60.0
N_YEARS = 62
DENSITY_STEP_M = 0.1
DENSITY_DEPTH_M = 10.0
LOG_SPACING_M = 0.0025
# Annual accumulation, mean and s.d., of real frames of 20 layers or more [m w.e.].
INTERIOR_MOST_M = 0.184 + 0.052
# Of the same frames; a simulator's classes of first layers are in pixels of this scale.
MEAN_FIRST_PX = 56.0
FIRST_PX = ((22, 40), (40, 60), (60, 80), (80, 100))


def draw_cores(climate, *, rng):
    """Accumulation of the years at places 60 km apart along the flight, (place, year) [m w.e.].

    Youngest first.
    """
    from_middle = np.arange(N_PLACES) - (N_PLACES - 1) / 2
    place_km = line_length_km() / 2 + PLACE_KM * from_middle
    cores = []
    for km in place_km:
        lines_km = km + np.array([0, 0.01])  # a distance between lines is needed to draw any
        years = climate.draw_accumulation("cores", lines_km, N_YEARS + 1, rng=rng)
        cores.append(years[1:, 0])
    return np.array(cores)


def anomalies(series):
    """Deviation of annual values from a straight line over their mean; NaN stays."""
    known = np.isfinite(series)
    year = np.arange(series.size)
    line = np.polyfit(year[known], series[known], 1)
    return (series - np.polyval(line, year)) / np.mean(series[known])


def shared_correlation(one, other):
    """Correlation of two series over the years that both have."""
    both = np.isfinite(one) & np.isfinite(other)
    return np.corrcoef(one[both], other[both])[0, 1]


def describe_core(series):
    """Variability from year to year, and whether a rich year follows a rich year."""
    anomaly = anomalies(series)
    with_next = shared_correlation(anomaly[:-1], anomaly[1:])
    return {
        "cores, deviation from year to year": np.nanstd(anomaly),
        "cores, correlation of one year with the next": with_next,
    }


def neighbour_correlations(cores):
    """Correlation of the anomalies of each core with those of the next."""
    by_core = [anomalies(series) for series in cores]
    return [shared_correlation(one, other) for one, other in pairwise(by_core)]


def draw_densities(firn, *, rng):
    """Depth [m] and density [kg m-3] of fine layering, as cores of 0.1 m samples, by place."""
    n_cells = round(DENSITY_DEPTH_M / LOG_SPACING_M)
    n_cells_a_sample = round(DENSITY_STEP_M / LOG_SPACING_M)
    scale = (firn.layering_sd_kg_m3, firn.layering_length_m)
    cells = draw_layering(N_PLACES, n_cells, LOG_SPACING_M, *scale, rng=rng).astype(float)
    density = cells.reshape(N_PLACES, -1, n_cells_a_sample).mean(axis=2)
    depth_m = np.arange(density.shape[1]) * DENSITY_STEP_M
    return [np.column_stack([depth_m, log]) for log in density]


def density_residual(log):
    """Standard deviation of density about a parabola of depth in the upper 10 m [kg m-3]."""
    upper = log[log[:, 0] <= DENSITY_DEPTH_M]
    depth_m, density = upper.T
    parabola = np.polyfit(depth_m, density, 2)
    return np.std(density - np.polyval(parabola, depth_m))


def thickness_of(scenes, most_accumulation_m=np.inf):
    """Thickness of complete layers (slab, range_line) [bins], by scene.

    Of scenes with two slabs where no more snow falls.
    """
    return [
        np.diff(scene.complete_layer_bins, axis=0)
        for scene in scenes
        if scene.complete_layer_bins is not None
        and len(scene.complete_layer_bins) > 2
        and scene.notes["accumulation_m"] <= most_accumulation_m
    ]


def spacing_variation(slabs):
    """Standard deviation over mean of the distance to the next layer, all lines of all scenes.

    NaN without a scene.
    """
    if not slabs:
        return np.nan
    distances = np.concatenate([thickness.ravel() for thickness in slabs])
    return np.nanstd(distances) / np.nanmean(distances)


def mean_variation(slabs):
    """Standard deviation over mean of the mean thickness of the first five layers, over scenes."""
    means = [np.nanmean(thickness[:5]) for thickness in slabs if len(thickness) >= 5]
    return np.std(means) / np.mean(means) if len(means) > 1 else np.nan


def thickness_ratio(slabs, first_px):
    """Mean thickness of deeper layers over the first, where that lies between limits [px].

    NaN without a scene.
    """
    if not slabs:
        return np.nan
    first = np.concatenate([thickness[0] for thickness in slabs])
    ratios = [np.nanmean(thickness[1:], axis=0) / thickness[0] for thickness in slabs]
    as_px = first / np.nanmean(first) * MEAN_FIRST_PX
    low_px, high_px = first_px
    inside = (low_px <= as_px) & (as_px < high_px)
    return np.nanmean(np.concatenate(ratios)[inside]) if inside.any() else np.nan


def left_below(statistics, slabs):
    """What is left of a layer's peak one thickness below, by its fitted decay, by zone.

    Mean over a slice of slabs.
    """
    thickness = statistics["thickness_mean_bins"].values
    decay = statistics["decay_rate"].values[1 : 1 + thickness.shape[1]]
    left = np.exp(-decay * thickness[:, : decay.size])
    return [np.nanmean(of_zone) for of_zone in left[:, slabs] if np.isfinite(of_zone).any()]
