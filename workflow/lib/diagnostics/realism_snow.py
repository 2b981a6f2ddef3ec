"""Snow in numbers: years of cores, real and drawn, density logs, thickness of layers and what falls off within one."""

import numpy as np

from snowsim.reference.echo import draw_layering
from snowsim.reference.line import line_length_km

N_PLACES, PLACE_KM, N_YEARS = (
    16,
    60.0,
    62,
)  # as the cores of west Greenland: places, their distance, years
DENSITY_STEP_M, DENSITY_DEPTH_M, LOG_SPACING_M = 0.1, 10.0, 0.0025
INTERIOR_MOST_M = (
    0.184 + 0.052
)  # [m w.e.] annual accumulation, mean and s.d., of real frames of 20 layers or more
MEAN_FIRST_PX = (
    56.0  # of the same frames; a simulator's classes of first layers are in pixels of this scale
)
FIRST_PX = ((22, 40), (40, 60), (60, 80), (80, 100))


def draw_cores(climate, *, rng):
    """Accumulation of the years at places 60 km apart along the flight, (place, year) [m w.e.], youngest first."""
    middle_km = line_length_km() / 2 + PLACE_KM * (np.arange(N_PLACES) - (N_PLACES - 1) / 2)
    places = [
        km + np.array([0, 0.01]) for km in middle_km
    ]  # a distance between lines is needed to draw any
    return np.array(
        [climate.draw_accumulation("cores", at, N_YEARS + 1, rng=rng)[1:, 0] for at in places]
    )


def anomalies(series):
    """Deviation of annual values from a straight line over their mean; NaN stays."""
    known = np.isfinite(series)
    year = np.arange(series.size)
    return (series - np.polyval(np.polyfit(year[known], series[known], 1), year)) / np.mean(
        series[known]
    )


def shared_correlation(one, other):
    """Correlation of two series over the years that both have."""
    both = np.isfinite(one) & np.isfinite(other)
    return np.corrcoef(one[both], other[both])[0, 1]


def describe_core(series):
    """Variability from year to year, and whether a rich year follows a rich year."""
    anomaly = anomalies(series)
    return {
        "cores, deviation from year to year": np.nanstd(anomaly),
        "cores, correlation of one year with the next": shared_correlation(
            anomaly[:-1], anomaly[1:]
        ),
    }


def neighbour_correlations(cores):
    """Correlation of the anomalies of each core with those of the next."""
    by_core = [anomalies(series) for series in cores]
    return [
        shared_correlation(one, other) for one, other in zip(by_core[:-1], by_core[1:], strict=True)
    ]


def draw_densities(firn, *, rng):
    """Depth [m] and density [kg m-3] of the fine layering as cores of 0.1 m samples have it, by place."""
    n_samples, width = round(DENSITY_DEPTH_M / LOG_SPACING_M), round(DENSITY_STEP_M / LOG_SPACING_M)
    scale = (firn.layering_sd_kg_m3, firn.layering_length_m)
    logs = draw_layering(N_PLACES, n_samples, LOG_SPACING_M, *scale, rng=rng).astype(float)
    density = logs.reshape(N_PLACES, -1, width).mean(axis=2)
    return [np.column_stack([np.arange(log.size) * DENSITY_STEP_M, log]) for log in density]


def density_residual(log):
    """Standard deviation of the density of the upper 10 m about a parabola of depth [kg m-3]."""
    depth_m, density = log[log[:, 0] <= DENSITY_DEPTH_M].T
    return np.std(density - np.polyval(np.polyfit(depth_m, density, 2), depth_m))


def thickness_of(scenes, most_accumulation_m=np.inf):
    """Thickness of complete layers (slab, range_line) [bins], of scenes with two slabs where no more snow falls."""
    return [
        np.diff(scene.complete_layer_bins, axis=0)
        for scene in scenes
        if scene.complete_layer_bins is not None
        and len(scene.complete_layer_bins) > 2
        and scene.notes["accumulation_m"] <= most_accumulation_m
    ]


def spacing_variation(slabs):
    """Standard deviation over mean of the distance to the next layer, all lines of all scenes."""
    distances = np.concatenate([thickness.ravel() for thickness in slabs])
    return np.nanstd(distances) / np.nanmean(distances)


def mean_variation(slabs):
    """Standard deviation over mean of the mean thickness of the first five layers, from scene to scene."""
    means = [np.nanmean(thickness[:5]) for thickness in slabs if len(thickness) >= 5]
    return np.std(means) / np.mean(means) if len(means) > 1 else np.nan


def thickness_ratio(slabs, first_px):
    """Mean thickness of deeper layers over the first, where the first is as thick, relative to its mean, as limits."""
    first = np.concatenate([thickness[0] for thickness in slabs])
    ratio = np.concatenate(
        [np.nanmean(thickness[1:], axis=0) / thickness[0] for thickness in slabs]
    )
    first_as_px = first / np.nanmean(first) * MEAN_FIRST_PX
    inside = (first_px[0] <= first_as_px) & (first_as_px < first_px[1])
    return np.nanmean(ratio[inside]) if inside.any() else np.nan


def left_below(statistics, slabs):
    """What is left of a layer's peak one thickness below, by its fitted decay, in a slice of slabs, by zone."""
    thickness = statistics["thickness_mean_bins"].values
    decay = statistics["decay_rate"].values[1 : 1 + thickness.shape[1]]
    left = np.exp(-decay * thickness[:, : decay.size])[:, slabs]
    return [np.nanmean(of_zone) for of_zone in left if np.isfinite(of_zone).any()]
