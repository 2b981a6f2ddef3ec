"""Accumulation by a tracker's picks against that of true horizons, and picks without training."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.ndimage import gaussian_filter, gaussian_filter1d, uniform_filter
from skimage.filters import sato

from lib.placeholder_frames import placeholder_layers
from pretrained.resizing import resized
from pretrained.scores import Calibrated, Picks, followed, pick_scores
from snowsim.constants import KOVACS_M3_KG, SPEED_OF_LIGHT_M_S, WATER_DENSITY_KG_M3
from snowsim.echogram import Scene, to_uint8
from snowsim.seeding import random_stream
from snowsim.snowpack import Climate, Radar, accumulation, simulate
from snowsim.tracker import Calibration, fused_logits, half_width_rows

# Of the firn of flights and climates: density at the surface [kg m-3], annual mean [K].
FIRN = {"density": 340.0, "temperature_k": 243.0}
BIN_S = 2.886e-10  # of the tracker, to whose rows errors of picks are known
CLIMATES = {"climate_0.2": 0.2, "climate_0.4": 0.4, "climate_0.6": 0.6}  # [m w.e. / yr]
NEAR_BINS = 4.0  # of a true horizon to a pick that is it
NEAR_SURFACE_BINS = 3.0
# The baseline: grey levels under a Gaussian (rows, range lines), less the mean around (rows, range
# lines), chosen on the flight of seed 1001.
PEAK = (1.0, 6.0)
AROUND = (15, 41)
# Ridges: grey levels under a Gaussian of so many range lines, width of a ridge [range bins], and
# the strength, in standard deviations, at which one speaks neither for nor against a layer; chosen
# on the flights of seeds 1001 and 1003 and on clean firn.
RIDGE_LINES = 6.0
RIDGE_BINS = 2.0
EVEN_STRENGTH = 0.5


# All that is linked is kept: nothing says how sure it is.
UNTRAINED = Calibrated(None, Calibration(0.0, 1.0, 0.5, 0.0, 0.0, 0.0, 0.0), (10.0, 0.0, 0.0))


@dataclass(frozen=True, eq=False)
class Snow:
    """A scene, its range bin [s], and the mass above its layers [m w.e.] where that is known."""

    scene: Scene
    bin_s: float
    water_m: np.ndarray | None = None


def snow_of_climate(accumulation_m, seed, n_scenes):
    """List of `Snow` of annual layers that `snowsim.simulate` draws."""
    radar = Radar.preset("snow-2012", n_looks=16)
    drawn = []
    for number in range(n_scenes):
        rng = random_stream(seed, "snow_of_climate", accumulation_m, number)
        echogram, layers = simulate(Climate(accumulation_m=accumulation_m), radar, rng=rng)
        image, *_ = to_uint8(echogram["Data"].values)
        bins = (layers["peak_twtt"].values - float(echogram["twtt"][0])) / radar.bin_s
        scene = Scene(f"climate_{number}", len(image), bins, image=image)
        drawn.append(Snow(scene, radar.bin_s, layers["water_m"].values))
    return drawn


def baseline_logits(image):
    """Map (range_bin, range_line) for `pretrained.scores.followed`, of an image alone.

    Smoothed grey, which is power in dB, over the local mean: positive where there is a peak.
    """
    smooth = gaussian_filter(image.astype(np.float32), PEAK)
    over = smooth - uniform_filter(smooth, AROUND)
    return over / over.std()


def ridge_logits(image):
    """The same by the strength of ridges along track: Sato et al. (1998), Med. Image Anal. 2."""
    smooth = gaussian_filter1d(image.astype(np.float32), RIDGE_LINES, axis=1)
    strength = sato(smooth, sigmas=[RIDGE_BINS], black_ridges=False)
    return strength / strength.std() - EVEN_STRENGTH


def layers_of(picks, snow):
    """Layers dataset of `Picks` below the true surface of a scene."""
    surface = snow.scene.layer_bins[0]
    below = np.where(picks.bins > surface + NEAR_SURFACE_BINS, picks.bins, np.nan)
    deeper = np.isfinite(below).any(axis=1)
    bins = np.vstack([surface, below[deeper]])
    sure = np.vstack([np.ones(surface.size), picks.sure[deeper]])
    half_s = half_width_rows(sure) * BIN_S
    twtt = bins * snow.bin_s
    times = np.datetime64("2000-01-01", "ns") + np.arange(surface.size) * np.timedelta64(40, "ms")
    layers = placeholder_layers(twtt, times).assign_coords(layer=np.arange(len(bins)))
    added = {"twtt_low": twtt - half_s, "twtt_high": twtt + half_s, "confidence": sure}
    return layers.assign({name: (layers["twtt"].dims, of) for name, of in added.items()})


def water_above(horizons_s, depth_at, snow, line):
    """Mass above true horizons on some range lines [m w.e.], (layer, line), as known or converted.

    `horizons_s` (layer, line) are their travel times below the surface, `depth_at` the depths of
    such times.
    """
    if snow.water_m is not None:
        return snow.water_m[:, line]
    # Of t = (2 / c) (z + .845 w), Kovacs et al. (1995).
    depth_m = np.interp(horizons_s, depth_at["below_s"].values, depth_at.values)
    optical_m = SPEED_OF_LIGHT_M_S * horizons_s / 2
    return (optical_m - depth_m) / (KOVACS_M3_KG * WATER_DENSITY_KG_M3)


def years_of(layers, snow):
    """Rows of a scene's line-years between picks, beside their true accumulation.

    `true` [m w.e. / yr] is of the year between the true horizons nearest to the picks above and
    below it, `top` and `base`; it is the `within`-th year between them. `right` tells whether both
    are near and as many years apart as was found; `true_mean` is the mean of all years between.
    """
    try:
        found = accumulation(layers, year=0, **FIRN)
    except ValueError:  # no two picks on a line
        return pd.DataFrame()
    thickness_m = found["thickness_m"].values
    above_m = np.vstack([np.full(thickness_m.shape[1], np.nan), thickness_m[:-1]])
    row = np.arange(len(thickness_m))[:, None]
    first = np.maximum.accumulate(np.where(thickness_m != above_m, row, 0))
    year, line = np.nonzero(np.isfinite(thickness_m))
    names = ("accumulation_m_we", "low", "high", "n_years", "flag", "depth_m", "thickness_m")
    years = pd.DataFrame({name: found[name].values[year, line] for name in names})
    within = year - first[year, line]
    depth_at = found["depth_at"]
    horizons_s = (snow.scene.layer_bins - snow.scene.layer_bins[0])[:, line] * snow.bin_s
    water_m = water_above(horizons_s, depth_at, snow, line)
    top_m = years["depth_m"] - within * years["thickness_m"]
    base_m = top_m + years["n_years"] * years["thickness_m"]
    nearest = {}
    near = True
    for name, end_m in (("top", top_m), ("base", base_m)):
        end_s = np.interp(end_m, depth_at.values, depth_at["below_s"].values)
        away = np.nan_to_num(np.abs(horizons_s - end_s), nan=np.inf)
        nearest[name] = away.argmin(axis=0)
        near = near & (away.min(axis=0) < NEAR_BINS * snow.bin_s) & (nearest[name] > 0)
    right = near & (nearest["base"] - nearest["top"] == years["n_years"])
    each = np.arange(line.size)
    # Read only where the count is right: there, the year's horizons exist.
    above = np.where(right, nearest["top"] + within, 0)
    true_m = water_m[above + right, each] - water_m[above, each]
    mass_m = water_m[nearest["base"], each] - water_m[nearest["top"], each]
    mean_m = mass_m / years["n_years"]
    truth = {"true": true_m, "true_mean": mean_m, "right": right}
    return years.assign(line=line, within=within, **truth, **nearest)


def accumulation_scores(tables, n_possible):
    """Scores of the years of all scenes, list of tables of `years_of`, by name.

    Of spans between picks whose years are counted rightly `bias`, `rms` (both relative) and
    `correlation` of changes along track, of their means; `inside`, how often the truth of a year in
    them lies in its interval; `given`, of all line-years; of spans counted wrongly their share, and
    the share of them with a flag, beside that of right ones.
    """
    numbered = [table.assign(scene=number) for number, table in enumerate(tables) if len(table)]
    if not numbered:
        return {"given": 0.0}
    years = pd.concat(numbered, ignore_index=True)
    of_right = years[years["right"]]
    spans = years[years["within"] == 0]
    right = spans[spans["right"]]
    wrong = spans[~spans["right"]]
    found = right["accumulation_m_we"]
    both = right.groupby(["scene", "top", "base"])[["accumulation_m_we", "true_mean"]]
    changes = right[["accumulation_m_we", "true_mean"]] - both.transform("mean")
    return {
        "bias": found.sum() / right["true_mean"].sum() - 1,
        "rms": np.sqrt(((found / right["true_mean"] - 1) ** 2).mean()),
        "inside": of_right["true"].between(of_right["low"], of_right["high"]).mean(),
        "correlation": changes.corr().iloc[0, 1],
        "given": len(years) / n_possible,
        "wrong": len(wrong) / len(spans),
        "wrong_flagged": wrong["flag"].mean(),
        "right_flagged": right["flag"].mean(),
    }


def scored_snow(name, snows, tracker, picks_of):
    """Row of accumulation scores of a tracker's picks, `picks_of(scene)`, on a list of `Snow`."""
    picks = [picks_of(each.scene) for each in snows]
    tables = [years_of(layers_of(own, each), each) for own, each in zip(picks, snows, strict=True)]
    # The snow above the uppermost horizon is of no whole year.
    n_possible = sum(np.isfinite(each.scene.layer_bins[2:]).sum() for each in snows)
    of_picks = pick_scores(picks, [each.scene for each in snows])
    shares = {name: of_picks[name] for name in ("f", "missed_share", "false_share")}
    return {"flight": name, "tracker": tracker, **shares} | accumulation_scores(tables, n_possible)


def rows_of_flight(name, snows, tracker, scale):
    """Rows of a tracker, of two ways without training and of true horizons on a list of `Snow`.

    `tracker` is a `pretrained.scores.Calibrated`, `scale` brings scenes to its bins and lines.
    """

    def tracked(scene):
        logits = fused_logits(tracker.network, resized(scene.image, scale))
        return followed(logits, tracker, scene.image.shape)

    def untrained(logits_of):
        return lambda scene: followed(logits_of(scene.image), UNTRAINED, scene.image.shape)

    def true(scene):
        below = scene.layer_bins[1:]
        return Picks(below, np.ones(below.shape))

    ways = {
        "universal": tracked,
        "baseline": untrained(baseline_logits),
        "sato": untrained(ridge_logits),
        "true horizons": true,
    }
    return [scored_snow(name, snows, way, picks_of) for way, picks_of in ways.items()]
