"""The flight and the benchmark as numbers and curves that can stand beside what is published of real echograms."""

import numpy as np
import pandas as pd

from snowsim.constants import SPEED_OF_LIGHT_M_S
from snowsim.echogram import along_track_m, bin_size_s, layer_bins_of, to_db
from snowsim.metrics.texture import autocorrelation, equivalent_number_of_looks
from snowsim.reference.echo import draw_layering
from snowsim.reference.radar import hann_response

ACROSS, DOWN = "range_line", "range_bin"
SNOW_ROWS = slice(10, 160)  # [range bins below the surface] 150 rows, as the observed images have
PROFILE_ROWS = np.arange(-60, 400)
AIR_MARGIN_BINS = 40  # above the surface, where nothing but noise is
LINES = 256  # of a block
LAGS = (1, 2, 3, 5, 10, 20, 50)
PERCENTILES = (1, 5, 25, 50, 75, 95, 99)
HISTOGRAM_EDGES_DB = np.arange(-15, 45.5, 0.5)
STANDARD_EDGES = np.arange(-4, 4.25, 0.25)
TAIL_BINS = 100
LOG_SPACING_M, LOG_SAMPLES, N_LOGS = 0.0025, 2000, 40  # of a density log of 5 m
LOG_LAGS = 60
SMOOTHED_WAVENUMBERS = 101
DEPTH_STEP = 40  # [range bins] of the curve of visibility
OTHER_BAND = "observed, other band"

# Real accumulation-radar echograms of Greenland firn, 150 rows from 5 to 30 m depth: another band, other bins, another
# line spacing, so a guide to the order of magnitude and no more.
OBSERVED_CORRELATION = {
    (ACROSS, 1): (0.63, 0.79),
    (ACROSS, 10): (0.51, 0.70),
    (ACROSS, 50): (0.31, 0.57),
    (DOWN, 1): (0.89, 0.89),
    (DOWN, 2): (0.70, 0.70),
    (DOWN, 3): (0.54, 0.54),
    (DOWN, 5): (0.34, 0.34),
}
NONE = (np.nan, np.nan)
# Published values by quantity: unit, lowest and highest, source. The published simulator draws slabs as N(1.24, 0.36)
# of a fixed number of bins. The reference flight's Doppler spectrum is flat by construction.
OBSERVED = {
    "range bin in air": ("cm", 4.33, 4.33, "2012 product; 1.76 in 2009, 1.30 in 2016"),
    "line spacing": ("m", 5.47, 5.47, "frame 20160419_04_082"),
    "range bins of a frame": ("1", 1271, 1271, "frame 20160419_04_082, finer bins"),
    "range lines of a frame": ("1", 904, 904, "frame 20160419_04_082"),
    "brightest echo over noise": ("dB", 53, 53, "sea ice 2016, a brighter surface"),
    f"mean power {TAIL_BINS} bins below the surface": ("dB over noise", 10, 10, "sea ice 2016"),
    "strong layers over noise": ("dB", 20, np.nan, "Greenland 2012: over 20 dB"),
    "surface over the strongest layer": ("dB", 3, 3, "choice of a published simulator"),
    "spread of a layer's power from layer to layer": ("dB", 1.5, 1.5, "choice of a published simulator"),
    "range response, null to null": ("m", 0.2, 0.2, "Hann window over 6 GHz"),
    "range response, equivalent width": ("m", 0.075, 0.075, "Hann window over 6 GHz"),
    "density of snow at the surface": ("g cm-3", 0.31, 0.37, "means of near-surface logs"),
    "density log, detrended deviation": ("g cm-3", 0.046, 0.056, "near-surface logs"),
    "density log, vertical 1/e length": ("cm", 2.2, 2.5, "near-surface logs"),
    "looks of the noise": ("1", *NONE, "none published"),
    "looks under the picks": ("1", *NONE, "none published"),
    "Doppler spectrum, highest over lowest": ("dB", *NONE, "flat by eye, Yari et al. (2021), Fig. 8"),
    "picked share of the flight": ("1", *NONE, "none published"),
    "picked share of train scenes": ("1", *NONE, "partial, Yari et al. (2021); no number published"),
    "missing share of labels in train scenes": ("1", *NONE, "some, Yari et al. (2021); no number published"),
    "test scenes of fewer than 6 layers": ("1", 0.57, 0.57, "Yari et al. (2021), test set"),
    "most layers of a test scene": ("1", 34, 34, "Yari et al. (2021), test set"),
    "accumulation": ("m w.e. per year", 0.1, 0.6, "interior 0.1-0.3, western percolation zone 0.3-0.6"),
    "mean thickness of the first slab": ("range bins", *NONE, "none published"),
    "thickness, deviation over mean": ("1", 0.29, 0.29, "choice of a published simulator: N(1.24, 0.36)"),
    "thickness, correlation length along track": ("range lines", 18, 18, "choice of a published simulator"),
    **{f"power, percentile {p}": ("dB over noise", *NONE, "none published") for p in PERCENTILES},
    **{
        f"autocorrelation along {along}, lag {lag}": ("1", *limits, "real 600-900 MHz firn echograms (other band)")
        for (along, lag), limits in OBSERVED_CORRELATION.items()
    },
}


def realism_table(frames, of_flight, others):
    """Every quantity beside its published values and its range over images of another band: a row a quantity.

    `frames` and `others` hold numbers by quantity of every frame and image, `of_flight` value, lowest and highest.
    """
    by_frame = pd.DataFrame(frames)
    numbers = {name: (by_frame[name].median(), by_frame[name].min(), by_frame[name].max()) for name in by_frame}
    numbers |= of_flight
    rows = [(name, *numbers[name], *published) for name, published in OBSERVED.items() if name in numbers]
    columns = ["quantity", "value", "low", "high", "unit", "observed_low", "observed_high", "source"]
    table = pd.DataFrame(rows, columns=columns)
    by_image = pd.DataFrame(others, columns=[name for name in table["quantity"] if "lag" in name])
    for column, values in (("other_band_low", by_image.min()), ("other_band_high", by_image.max())):
        table[column] = table["quantity"].map(values)
    return table


def curve_table(*groups):
    """Median, smallest and largest over frames or zones (dicts of curves) at every x; `visibility` by depth."""
    parts = []
    for name, group in [(name, held) for held in groups for name in held[0]]:
        part = pd.concat([pd.DataFrame({"x": of[name][0], "value": of[name][1]}) for of in group if name in of])
        if name == "visibility":
            part["x"] = (part["x"] // DEPTH_STEP + 0.5) * DEPTH_STEP
        by_x = part.groupby("x")["value"]
        part = pd.DataFrame({"value": by_x.median(), "low": by_x.min(), "high": by_x.max()}).reset_index()
        parts.append(part.assign(curve=name)[["curve", "x", "value", "low", "high"]])
    return pd.concat(parts)


def describe_frame(echogram, layers):
    """Numbers of one frame by quantity, and its curves by name, as (x, value)."""
    power = echogram["Data"].transpose("twtt", "slow_time").values.astype(float)
    layer_bins = layer_bins_of(layers, echogram)
    usable = (np.isfinite(power) & (power > 0)).all(axis=0) & np.isfinite(layer_bins[0])
    power, layer_bins = power[:, usable], layer_bins[:, usable]
    surface = int(np.rint(layer_bins[0].mean()))
    air = power[: surface - AIR_MARGIN_BINS]
    noise = air.mean()
    over_noise = to_db(power / noise)
    snow = over_noise[surface + SNOW_ROWS.start : surface + SNOW_ROWS.stop]
    tracked = [power_at(power, bins) for bins in layer_bins[1:]]
    means = [np.nanmean(values) for values in tracked if np.isfinite(values).any()]
    correlation, curves = describe_texture(snow)
    numbers = {
        "range bin in air": 100 * bin_size_s(echogram) * SPEED_OF_LIGHT_M_S / 2,
        "line spacing": float(np.median(np.diff(along_track_m(echogram)))),
        "range bins of a frame": echogram.sizes["twtt"],
        "range lines of a frame": echogram.sizes["slow_time"],
        "brightest echo over noise": over_noise.max(),
        "strong layers over noise": to_db(np.nanpercentile(np.concatenate(tracked), 95) / noise),
        f"mean power {TAIL_BINS} bins below the surface": to_db(power[surface + TAIL_BINS].mean() / noise),
        "surface over the strongest layer": to_db(power_at(power, layer_bins[0]).mean() / max(means, default=np.nan)),
        "spread of a layer's power from layer to layer": layer_spread_db(means),
        "looks of the noise": equivalent_number_of_looks(air),
        "picked share of the flight": np.isfinite(layer_bins).mean(),
        "accumulation": echogram.attrs.get("accumulation_m", np.nan),
        **{f"power, percentile {p}": np.percentile(snow, p) for p in PERCENTILES},
        **correlation,
    }
    rows = PROFILE_ROWS[surface + PROFILE_ROWS < len(power)]
    curves["row profile"] = (rows, to_db(power[surface + rows].mean(axis=1) / noise))
    curves["histogram"] = histogram(snow, HISTOGRAM_EDGES_DB)
    curves["visibility"] = visibility(power, layer_bins)
    return numbers, curves | standard_curves(snow)


def describe_image(image):
    """What can be said of an 8-bit echogram of unknown scale: texture by quantity, and standard curves."""
    image = image.astype(float)
    numbers, curves = describe_texture(image)
    return numbers, standard_curves(image) | curves


def describe_texture(image):
    """Autocorrelation of an image less the mean of every row: what changes with depth alone is no texture.

    About the overall mean real images give 0.89-0.97 at a lag of one trace, about the row's 0.59-0.74: only the latter
    is near the 0.63-0.79 that is published of them.
    """
    numbers, curves = {}, {}
    for along in (ACROSS, DOWN):
        correlation = autocorrelation(image - image.mean(axis=1, keepdims=True), LAGS, along=along)
        curves[f"autocorrelation along {along}"] = (LAGS, correlation)
        for lag, value in zip(LAGS, correlation, strict=True):
            if (along, lag) in OBSERVED_CORRELATION:
                numbers[f"autocorrelation along {along}, lag {lag}"] = value
    return numbers, curves


def standard_curves(image):
    """Histogram and row profile in standard deviations from the mean: images of another band have no known scale."""
    standard = (image - image.mean()) / image.std()
    return {
        "standard histogram": histogram(standard, STANDARD_EDGES),
        "standard profile": (np.arange(len(image)), standard.mean(axis=1)),
    }


def histogram(values, edges):
    """Middles of the bins, and the density of values in them."""
    density, _ = np.histogram(values, edges, density=True)
    return (edges[1:] + edges[:-1]) / 2, density


def layer_spread_db(means):
    """Standard deviation of mean powers from one layer to the next, without their fall with depth [dB]."""
    levels = to_db(np.array(means))
    # Second differences know no straight line; of independent levels they have six times the variance.
    return float(np.sqrt(np.mean(np.diff(levels, 2) ** 2) / 6)) if levels.size > 4 else np.nan


def power_at(power, bins):
    """Power in the bins of one layer, (range_line,), NaN in gaps."""
    held = np.flatnonzero(np.isfinite(bins))
    values = np.full(bins.size, np.nan)
    values[held] = power[np.rint(bins[held]).astype(int), held]
    return values


def visibility(power, layer_bins):
    """Rise of layers over the snow above and below [dB], block by block: their depths and rises.

    Snow is taken half way to either neighbour, and its decibels averaged: a steady fall with depth is no rise.
    """
    on = [power_at(power, bins) for bins in layer_bins]
    off = [power_at(power, (above + below) / 2) for above, below in zip(layer_bins[:-1], layer_bins[1:], strict=True)]
    depth, rise = [], []
    for layer in range(1, len(layer_bins) - 1):
        three = np.array([on[layer], off[layer - 1], off[layer]])
        for first in range(0, three.shape[1] - LINES + 1, LINES):
            part = three[:, first : first + LINES]
            held = np.isfinite(part).all(axis=0)
            if 2 * held.sum() >= LINES:
                level = to_db(part[:, held].mean(axis=1))
                below = layer_bins[layer] - layer_bins[0]
                depth.append(below[first : first + LINES][held].mean())
                rise.append(level[0] - (level[1] + level[2]) / 2)
    return np.array(depth), np.array(rise)


def describe_flight(statistics):
    """Numbers that belong to the flight as a whole: value, lowest and highest."""
    numbers = {"looks under the picks": spread_of(statistics.attrs["n_looks"])}
    if "doppler_layer_mean" in statistics:
        density = statistics["doppler_layer_mean"].values
        n_smoothed = min(SMOOTHED_WAVENUMBERS, density.size)
        smooth = np.convolve(density, np.full(n_smoothed, 1 / n_smoothed), mode="valid")
        numbers["Doppler spectrum, highest over lowest"] = spread_of(to_db(smooth.max() / smooth.min()))
    own = statistics["source"].values == 0
    mean, variance = (statistics[f"thickness_{name}"].values for name in ("mean_bins", "variance_bins2"))
    numbers["mean thickness of the first slab"] = spread_of(mean[:, 0])
    if own.any():
        numbers["thickness, deviation over mean"] = spread_of((np.sqrt(variance) / mean)[own])
    correlations = (np.fft.irfft(psd) for psd in statistics["thickness_psd"].values[:, 0])
    lengths = [falling_length(correlation / correlation[0]) for correlation in correlations]
    numbers["thickness, correlation length along track"] = spread_of(lengths)
    return numbers


def thickness_curves(statistics):
    """Spectrum of the thickness of the first slab, a curve for each zone."""
    inner = slice(1, -1)  # the highest wavenumber of a one-sided spectrum stands for itself alone
    wavenumber = statistics["wavenumber"].values[inner]
    return [{"thickness PSD": (wavenumber, psd[inner])} for psd in statistics["thickness_psd"].values[:, 0]]


def describe_benchmark(train, test):
    """Picked share of train scenes, and how many layers test scenes have: value, lowest and highest."""
    # The surface is no layer of the count.
    n_layers = np.array([np.isfinite(scene.layer_bins).any(axis=1).sum() - 1 for scene in test])
    counts = [
        [np.isfinite(scene.layer_bins).sum(), np.isfinite(scene.complete_layer_bins).sum()]
        for scene in train
        if scene.complete_layer_bins is not None
    ]
    numbers = {
        "test scenes of fewer than 6 layers": spread_of((n_layers < 6).mean()),
        "most layers of a test scene": spread_of(n_layers.max()),
    }
    if counts:
        picked, complete = np.array(counts).T
        shares = picked / complete
        share = picked.sum() / complete.sum()
        numbers["picked share of train scenes"] = (share, shares.min(), shares.max())
        numbers["missing share of labels in train scenes"] = (1 - share, 1 - shares.max(), 1 - shares.min())
    return numbers


def describe_physics(settings, *, rng):
    """Density logs as the flight draws them, and its range response, there and back: value, lowest and highest."""
    firn, bandwidth_hz = settings.firn, settings.radar.bandwidth_hz
    layering = (firn.layering_sd_kg_m3, firn.layering_length_m)
    logs = draw_layering(N_LOGS, LOG_SAMPLES, LOG_SPACING_M, *layering, rng=rng).astype(float)
    lengths = []
    for log in logs:
        products = np.array([np.mean(log[: LOG_SAMPLES - lag] * log[lag:]) for lag in range(LOG_LAGS)])
        lengths.append(100 * LOG_SPACING_M * falling_length(products / np.mean(log**2)))
    x = np.arange(-8, 8, 1e-3) / bandwidth_hz
    response = hann_response(x, bandwidth_hz) ** 2
    side = response[x >= 0]
    null = x[x >= 0][np.flatnonzero((side[1:-1] < side[:-2]) & (side[1:-1] <= side[2:]))[0] + 1]
    return {
        "range response, null to null": spread_of(2 * null * SPEED_OF_LIGHT_M_S),
        "range response, equivalent width": spread_of(response.sum() * (x[1] - x[0]) * SPEED_OF_LIGHT_M_S),
        "density of snow at the surface": spread_of(firn.surface_density_kg_m3 / 1e3),
        "density log, detrended deviation": spread_of(logs.std(axis=1) / 1e3),
        "density log, vertical 1/e length": spread_of(lengths),
    }


def falling_length(correlation):
    """Lag at which an autocorrelation, 1 at lag 0, has fallen to 1/e, between lags on a straight line."""
    fallen = int(np.argmax(correlation < np.exp(-1)))
    above, below = correlation[fallen - 1 : fallen + 1]
    return fallen - (np.exp(-1) - below) / (above - below)


def spread_of(values):
    """Median, lowest and highest; three times the same of a single one."""
    return np.median(values), np.min(values), np.max(values)
