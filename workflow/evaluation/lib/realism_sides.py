"""The two sides of the table of realism: numbers of the flight, and of real material."""

from functools import partial
from itertools import pairwise

import numpy as np
import pandas as pd

from evaluation.lib import pictures, realism, realism_firn, realism_snow, two_sample
from evaluation.lib.realism_table import interval
from snowsim.echogram import along_track_m, layer_bins_of, to_db

FLIGHT_ROW_S = 2.886e-10  # what crops of real pictures are brought to: a range bin of the flight
SMOOTHED_WAVENUMBERS = 101
# What the record holds of a classifier, in this order, beside what real frames measure.
DECIDED = ("flight against real", "its interval, low", "its interval, high", "real against real")


def describe_picture(picture):
    """Numbers of noise, sidelobes and homogeneous snow."""
    numbers = realism.describe_air(picture)
    numbers |= realism.describe_sidelobes(picture)
    return numbers | realism.describe_snow(picture)


def describe_frame(echogram, layers, response):
    """Numbers of a frame of the flight by quantity, and its crops.

    `response`: noise at the rows of real pictures.
    """
    picture = pictures.flight_picture(echogram, layers)
    spacing_m = float(np.median(np.diff(along_track_m(echogram))))
    means = pictures.means_100m(picture, spacing_m)
    power = echogram["Data"].transpose("twtt", "slow_time").values.astype(float)
    along = realism.layer_power_correlation(power, layer_bins_of(layers, echogram))
    numbers = {"line spacing": spacing_m}
    numbers["layers, correlation of power along track, 55 looks"] = along
    numbers |= realism.describe_means(means)
    numbers |= realism.describe_decay(means, realism.BIN_AIR_M[0])
    numbers |= describe_picture(picture)
    numbers |= realism.describe_response(response)
    crops = two_sample.picture_crops(picture, picture.row_s)
    return numbers, crops | two_sample.means_crops(means)


def describe_flight(frames, scenes, statistics, settings, climate, *, rng):
    """Value and interval of every number of the flight: of frames, scenes, statistics, drawn snow.

    `frames`: numbers by quantity, of every frame; `scenes`: of train and of test; `climate` is the
    flight's own.
    """
    train, test = scenes
    cores = realism_snow.draw_cores(climate, rng=rng)
    logs = realism_snow.draw_densities(settings.firn, rng=rng)
    of_cores = [realism_snow.describe_core(core) for core in cores]
    samples = dict(pd.DataFrame(frames)) | dict(pd.DataFrame(of_cores))
    samples["cores, correlation of neighbours"] = realism_snow.neighbour_correlations(cores)
    residuals = [realism_snow.density_residual(log) for log in logs]
    samples["density, deviation about a parabola"] = residuals
    samples["density of snow at the surface"] = [settings.firn.surface_density_kg_m3]
    upper = realism_snow.left_below(statistics, slice(0, 3))
    samples["layers 1 to 3, left of a peak one thickness below"] = upper
    deeper = realism_snow.left_below(statistics, slice(3, None))
    samples["deeper layers, left of a peak one thickness below"] = deeper
    found = {name: interval(list(values), rng=rng) for name, values in samples.items()}
    found |= describe_thickness(train, rng=rng)
    found |= describe_benchmark(train, test, rng=rng)
    return found | describe_doppler(statistics)


def describe_firn(powers, train, settings, climate, *, rng):
    """Value and interval of the flight's power against depth, density steps and slabs.

    `powers`: levels by depth of every frame; and those of snow that `snowsim.Climate` draws.
    """
    steps = realism_firn.describe_flight_firn(climate, settings, rng=rng)
    drawn = realism_firn.describe_climate_firn(settings.radar, rng=rng)
    samples = [pd.DataFrame(rows) for rows in (powers, steps, drawn)]
    found = {
        name: interval(table[name].tolist(), rng=rng) for table in samples for name in table.columns
    }
    slabs = realism_snow.thickness_of(train)
    for name, (units, statistic) in realism_firn.describe_slabs(slabs).items():
        found[name] = interval(units, statistic, rng=rng)
    return found


def describe_thickness(train, *, rng):
    """How the thickness of layers of train scenes varies, and that of the deeper with the first."""
    slabs = realism_snow.thickness_of(train)
    interior = realism_snow.thickness_of(train, realism_snow.INTERIOR_MOST_M)
    spacing = interval(interior, realism_snow.spacing_variation, rng=rng)
    of_five = interval(slabs, realism_snow.mean_variation, rng=rng)
    found = {
        "layers, spacing, deviation over mean": spacing,
        "layers, mean of five, deviation over mean": of_five,
    }
    for first_px in realism_snow.FIRST_PX:
        low, high = first_px
        ratio = partial(realism_snow.thickness_ratio, first_px=first_px)
        name = f"layers, thickness over a first one of {low} to {high} px"
        found[name] = interval(slabs, ratio, rng=rng)
    return found


def describe_doppler(statistics):
    """How flat the Doppler spectrum is."""
    if "doppler_layer_mean" not in statistics:
        return {}
    density = statistics["doppler_layer_mean"].values
    n_smoothed = min(SMOOTHED_WAVENUMBERS, density.size)
    smooth = np.convolve(density, np.full(n_smoothed, 1 / n_smoothed), mode="valid")
    ratio_db = to_db(smooth.max() / smooth.min())
    return {"Doppler spectrum, highest over lowest": (ratio_db, ratio_db, ratio_db)}


def describe_benchmark(train, test, *, rng):
    """Picked share of train scenes, and how many layers test scenes have."""
    # The surface is no layer of the count.
    n_layers = [int(np.isfinite(scene.layer_bins).any(axis=1).sum()) - 1 for scene in test]
    most = max(n_layers)
    shares = [
        np.isfinite(scene.layer_bins).sum() / np.isfinite(scene.complete_layer_bins).sum()
        for scene in train
        if scene.complete_layer_bins is not None
    ]
    few = interval(n_layers, lambda n: np.mean(np.array(n) < 6), rng=rng)
    return {
        "test scenes of fewer than 6 layers": few,
        "most layers of a test scene": (most, most, most),
        "picked share of train scenes": interval(shares, np.mean, rng=rng),
    }


def describe_real(folder):
    """Numbers of real material, a table of quantity, frame, value; and crops of its frames."""
    numbers = {}
    crops = []
    for frame, means in pictures.read_greenland(folder).items():
        numbers[frame] = realism.describe_means(means)
        for bin_air_m in realism.BIN_AIR_M:
            name = f"{frame}, bins of {100 * bin_air_m:.2f} cm"
            numbers[name] = realism.describe_decay(means, bin_air_m)
        crops.append(two_sample.means_crops(means))
    for frame, picture in pictures.read_sea_ice(folder).items():
        numbers[frame] = describe_picture(picture) | realism.describe_response(picture)
        crops.append(two_sample.picture_crops(picture, FLIGHT_ROW_S))
    numbers |= describe_real_cores(pictures.read_cores(folder))
    for name, log in pictures.read_densities(folder).items():
        residual = realism_snow.density_residual(log)
        numbers[f"{name}, density"] = {"density, deviation about a parabola": residual}
    core = pictures.read_core_b26(folder)
    numbers["B26"] = realism_firn.describe_core_firn(*core)
    numbers |= realism_firn.describe_real_slabs(pictures.read_horizons(folder))
    rows = [
        (quantity, frame, value)
        for frame, of_frame in numbers.items()
        for quantity, value in of_frame.items()
    ]
    return pd.DataFrame(rows, columns=["quantity", "frame", "value"]), crops


def describe_real_cores(cores):
    """Numbers of cores, and of neighbours along the line of GreenTRACS."""
    numbers = {name: realism_snow.describe_core(series) for name, series in cores.items()}
    aligned = [name for name in cores if name.startswith("GreenTRACS") and "," not in name]
    between = realism_snow.neighbour_correlations([cores[name] for name in aligned])
    for (one, other), value in zip(pairwise(aligned), between, strict=True):
        numbers[f"{one} and {other}"] = {"cores, correlation of neighbours": value}
    return numbers


def with_classifier(real, decided):
    """The table of real material with what a classifier decided, by kind of crop."""
    rows = [
        (f"classifier, {kind}", frame, value)
        for kind, values in decided.items()
        for frame, value in zip(DECIDED, values, strict=True)
    ]
    return pd.concat([real, pd.DataFrame(rows, columns=real.columns)], ignore_index=True)


def without_flight(record):
    """A record taken apart: value and interval of flight against real by quantity; the rest."""
    of_flight = record["frame"].isin(DECIDED[:3])
    by_quantity = record[of_flight].groupby("quantity", sort=False)["value"]
    return dict(by_quantity.agg(tuple)), record[~of_flight]
