"""Drawn scenes beside observed ones: can a classifier tell them apart, and by what they differ."""

from functools import partial
from itertools import product

import numpy as np
import pandas as pd

from evaluation.lib.patch_network import fit_network
from evaluation.lib.renders import MARGIN_BINS, surface_regions
from evaluation.lib.two_sample import N_BOOTSTRAP, accuracy, decisions, fitted, textures
from snowsim.echogram import DB_BELOW_NOISE_FLOOR, SURFACE_ROW
from snowsim.metrics.texture import autocorrelation, equivalent_number_of_looks

PATCH = 64  # [pixels] height and width
# The uppermost patches hold the surface, deeper ones snow alone.
FIRST_ROW = SURFACE_ROW - PATCH // 2
LAGS = (1, 2, 3, 5, 7, 10, 15, 20, 30, 50)  # [range lines or bins]
LAYER_LAGS = (1, 2, 4, 8, 16, 32, 64, 128)  # [range lines]
N_SLABS = 8  # the uppermost: deeper ones are rare among observed scenes
N_LAYERS = 20
PEAK_BINS = 2  # about a layer: where its peak is sought
BESIDE_BINS = 12  # and how far the snow beside it
CUBIC = 3
UNPICKED_FROM = 30  # [range bins] below the lowest layer: above, its echo falls
LEAST_UNPICKED = 60


def patches_of(scenes, n_range_bins, n_range_lines):
    """Patches of every scene, arrays (patch, range_bin, range_line), row after row of patches.

    At equal depths in all.
    """
    rows = range(FIRST_ROW, n_range_bins - PATCH + 1, PATCH)
    lines = range(0, n_range_lines - PATCH + 1, PATCH)
    if not (rows and lines):
        msg = f"two-sample test: expected scenes of {FIRST_ROW + PATCH} x {PATCH} pixels or more, "
        msg += f"the smallest has {n_range_bins} x {n_range_lines}"
        raise ValueError(msg)
    corners = list(product(rows, lines))
    patches = []
    for scene in scenes:
        of_scene = [scene.image[row : row + PATCH, line : line + PATCH] for row, line in corners]
        patches.append(np.array(of_scene))
    return patches


def two_sample_table(sets, *, n_splits, n_steps, stream):
    """How often two classifiers tell observed scenes from drawn ones, and one half from the other.

    `sets` maps names to lists of scenes, `observed` first, all of one length; `stream` gives a
    generator by keys. Rows: `scenes`, `classifier`, `first_row` of the patches (-1: all),
    `accuracy`, its 95 % interval over scenes, how many.
    """
    everything = [scene for scenes in sets.values() for scene in scenes]
    n_range_bins = min(scene.n_range_bins for scene in everything)
    n_range_lines = min(scene.n_range_lines for scene in everything)
    patches = {
        name: patches_of(scenes, n_range_bins, n_range_lines) for name, scenes in sets.items()
    }
    features = {name: textures(of_set) for name, of_set in patches.items()}
    n_rows = (n_range_bins - FIRST_ROW) // PATCH
    rows = []
    for name in sets:
        network = partial(fit_network, n_steps=n_steps, rng=stream(name))
        for classifier, given, fit in (
            ("network", patches, network),
            ("texture", features, fitted),
        ):
            observed = given["observed"]
            drawn = given[name]
            if name == "observed":
                observed, drawn = drawn[::2], drawn[1::2]
            n_used = min(n_splits, len(observed), len(drawn))
            right = decisions(observed, drawn, n_splits=n_used, fit=fit)
            n_scenes = len(observed) + len(drawn)
            for number in range(-1, n_rows):
                chosen = slice(None) if number < 0 else number
                first_row = -1 if number < 0 else FIRST_ROW + PATCH * number
                shares = right and [_shares(side, n_rows, chosen) for side in right]
                found = accuracy(shares, rng=stream(name, classifier, number))
                rows.append((name, classifier, first_row, *found, n_scenes))
    columns = ["scenes", "classifier", "first_row", "accuracy", "low", "high", "n_scenes"]
    return pd.DataFrame(rows, columns=columns)


def _shares(right, n_rows, chosen):
    """Share of right decisions on the chosen rows of patches, by scene."""
    return [of_scene.reshape(n_rows, -1)[chosen].mean() for of_scene in right]


def span_of(scene):
    """Decibels from 0 to 255 of a scene's image; NaN where it does not tell, as the cGAN's."""
    return scene.maximum_db - scene.noise_floor_db + DB_BELOW_NOISE_FLOOR


def describe_image(scene, span_db):
    """Numbers of a scene's image by (quantity, lag or layer).

    Looks and autocorrelation, contrast of layers. Looks are relative to the mean of the range bin:
    sidelobes of the surface rise in the air. Snow, all below the surface and what lies below the
    lowest layer, is taken less the mean of its range bin along track, and less a cubic fall with
    depth down range. `span_db` stands for 0 to 255; without looks and contrast where it is NaN.
    """
    image_db = scene.image * (span_db / 255)
    n_rows = min(scene.n_range_bins, scene.image.shape[0])
    regions = surface_regions(scene.layer_bins, n_rows)
    found = {}
    if regions["above"].stop > MARGIN_BINS and np.isfinite(span_db):
        found["looks of the air", 0] = _looks(image_db[regions["above"]])
    found |= _autocorrelations(scene.image[regions["below"]], "autocorrelation")
    unpicked = slice(int(np.nanmax(scene.layer_bins)) + UNPICKED_FROM, regions["below"].stop)
    if unpicked.stop - unpicked.start >= LEAST_UNPICKED:
        if np.isfinite(span_db):
            found["looks of unpicked snow", 0] = _looks(image_db[unpicked])
        found |= _autocorrelations(scene.image[unpicked], "unpicked snow")
    if np.isfinite(span_db):
        found |= contrast_of_layers(image_db, scene.layer_bins)
    return found


def _looks(image_db):
    power = 10 ** (image_db / 10)
    return equivalent_number_of_looks(power / power.mean(axis=1, keepdims=True))


def _autocorrelations(snow, name):
    mean = snow.mean(axis=1, keepdims=True)
    depth = np.arange(len(snow))
    fall = np.polyval(np.polyfit(depth, mean[:, 0], CUBIC), depth)
    found = {}
    less = {"range_line": snow - mean, "range_bin": snow - fall[:, None]}
    for (along, deviation), length in zip(less.items(), snow.shape[::-1], strict=True):
        lags = [lag for lag in LAGS if lag < length]
        values = autocorrelation(deviation, lags, along=along)
        for lag, value in zip(lags, values, strict=True):
            found[f"{name}, {along}", lag] = value
    return found


def contrast_of_layers(image_db, layer_bins):
    """How far each layer's mean echo rises over the least on either side [dB], uppermost first."""
    found = {}
    lines = np.arange(image_db.shape[1])
    offsets = np.arange(-BESIDE_BINS, BESIDE_BINS + 1)
    for number, layer in enumerate(layer_bins[1 : N_LAYERS + 1], start=1):
        known = np.isfinite(layer)
        rows = np.rint(layer[known]).astype(int) + offsets[:, None]
        inside = (rows >= 0) & (rows < len(image_db))
        if not inside.all() or not known.any():
            continue
        profile = image_db[rows, lines[known]].mean(axis=1)
        peak = profile[np.abs(offsets) <= PEAK_BINS].max()
        above = profile[offsets < -PEAK_BINS].min()
        below = profile[offsets > PEAK_BINS].min()
        found["contrast of layers", number] = peak - np.mean([above, below])
    return found


def describe_layers(layer_bins):
    """Numbers of a scene's layers by (quantity, lag): roughness along track, NaN left out.

    Of layers and slabs: root mean square second difference [bins], and structure function, the mean
    square difference at a lag [bins^2].
    """
    layers = layer_bins[: N_SLABS + 1]
    return _roughness(layers, "layers") | _roughness(np.diff(layers, axis=0), "slabs")


def _roughness(series, name):
    found = {}
    second = np.diff(series, n=2, axis=1)
    if np.isfinite(second).any():
        found[f"second difference, {name}", 0] = np.sqrt(np.nanmean(second**2))
    for lag in LAYER_LAGS:
        change = series[:, lag:] - series[:, :-lag]
        if np.isfinite(change).any():
            found[f"structure function, {name}", lag] = np.nanmean(change**2)
    return found


def scenes_table(numbers, *, rng):
    """Mean over scenes of every number with its 95 % interval of the bootstrap over scenes.

    `numbers` maps names of sets to a list over scenes of numbers by (quantity, lag or layer).
    Columns `quantity, at, scenes, mean, low, high, n_scenes`: those that have the number.
    """
    rows = []
    for name, of_scenes in numbers.items():
        keys = dict.fromkeys(key for of_scene in of_scenes for key in of_scene)
        values = np.array([[of_scene.get(key, np.nan) for key in keys] for of_scene in of_scenes])
        known = np.isfinite(values)
        n_scenes = len(values)
        drawn = rng.multinomial(n_scenes, np.full(n_scenes, 1 / n_scenes), N_BOOTSTRAP)
        n_drawn = drawn @ known
        means = drawn @ np.nan_to_num(values) / np.maximum(n_drawn, 1)
        # A number of a single scene may be missing from a resample.
        means = np.where(n_drawn, means, np.nan)
        mean = np.nanmean(values, axis=0)
        low, high = np.nanpercentile(means, [2.5, 97.5], axis=0)
        n_known = known.sum(axis=0)
        for place, (quantity, at) in enumerate(keys):
            of_key = (mean[place], low[place], high[place], n_known[place])
            rows.append((quantity, at, name, *of_key))
    columns = ["quantity", "at", "scenes", "mean", "low", "high", "n_scenes"]
    return pd.DataFrame(rows, columns=columns).sort_values(["quantity", "at"], kind="stable")
