"""Drawn scenes beside observed ones: whether a classifier tells their patches apart, and by what they differ."""

from functools import partial

import numpy as np
import pandas as pd

from lib.diagnostics.patch_network import fit_network
from lib.diagnostics.renders import MARGIN_BINS, surface_regions
from lib.diagnostics.two_sample import N_BOOTSTRAP, accuracy, decisions, textures
from snowsim.echogram import DB_BELOW_NOISE_FLOOR, SURFACE_ROW
from snowsim.metrics.texture import autocorrelation, equivalent_number_of_looks

PATCH = 64  # [pixels] height and width
FIRST_ROW = (
    SURFACE_ROW - PATCH // 2
)  # the uppermost patches hold the surface, deeper ones snow alone
LAGS = (1, 2, 3, 5, 7, 10, 15, 20, 30, 50)  # [range lines or bins]
LAYER_LAGS = (1, 2, 4, 8, 16, 32, 64, 128)  # [range lines]
N_SLABS = 8  # the uppermost: deeper ones are rare among observed scenes
N_LAYERS = 20
PEAK_BINS, BESIDE_BINS = (
    2,
    12,
)  # about a layer: where its peak is sought, and how far the snow beside it
CUBIC = 3


def patches_of(scenes, n_range_bins, n_range_lines):
    """Patches of every scene, arrays (patch, range_bin, range_line): equal depths in all, row after row of patches."""
    rows = range(FIRST_ROW, n_range_bins - PATCH + 1, PATCH)
    lines = range(0, n_range_lines - PATCH + 1, PATCH)
    if not (rows and lines):
        wanted, got = f"{FIRST_ROW + PATCH} x {PATCH}", f"{n_range_bins} x {n_range_lines}"
        msg = f"two-sample test: expected scenes of {wanted} pixels or more, the smallest has {got}"
        raise ValueError(msg)
    return [
        np.array(
            [s.image[row : row + PATCH, line : line + PATCH] for row in rows for line in lines]
        )
        for s in scenes
    ]


def two_sample_table(sets, *, n_splits, n_steps, stream):
    """How often two classifiers tell observed scenes from drawn ones, and one half of the observed from the other.

    `sets` maps names to lists of scenes, `observed` first, all of one length; `stream` gives a
    generator by keys. Rows: `scenes`, `classifier`, `first_row` of the patches (-1: all),
    `accuracy`, its 95 % interval over scenes, how many.
    """
    everything = [scene for scenes in sets.values() for scene in scenes]
    size = [
        min(getattr(scene, f"n_{name}") for scene in everything)
        for name in ("range_bins", "range_lines")
    ]
    patches = {name: patches_of(scenes, *size) for name, scenes in sets.items()}
    features = {name: textures(of_set) for name, of_set in patches.items()}
    n_rows = (size[0] - FIRST_ROW) // PATCH
    rows = []
    for name in sets:
        for classifier, given in (("network", patches), ("texture", features)):
            pair = given["observed"], given[name]
            if name == "observed":
                pair = given[name][::2], given[name][1::2]
            fit = (
                {"fit": partial(fit_network, n_steps=n_steps, rng=stream(name))}
                if given is patches
                else {}
            )
            right = decisions(*pair, n_splits=min(n_splits, *map(len, pair)), **fit)
            for place, chosen in ((-1, slice(None)), *enumerate(range(n_rows))):
                shares = right and [
                    [of.reshape(n_rows, -1)[chosen].mean() for of in side] for side in right
                ]
                found = accuracy(shares, rng=stream(name, classifier, place))
                first_row = -1 if place < 0 else FIRST_ROW + PATCH * place
                rows.append((name, classifier, first_row, *found, sum(map(len, pair))))
    columns = ["scenes", "classifier", "first_row", "accuracy", "low", "high", "n_scenes"]
    return pd.DataFrame(rows, columns=columns)


def span_of(scene):
    """Decibels from 0 to 255 of a scene's image; NaN where it does not tell, as the cGAN's."""
    return scene.maximum_db - scene.noise_floor_db + DB_BELOW_NOISE_FLOOR


def describe_image(scene, span_db):
    """Numbers of a scene's image by (quantity, lag or layer): looks of the air, autocorrelation, contrast of layers.

    Snow is taken less the mean of its range bin along track, and less a cubic fall with depth down
    range. `span_db` stands for 0 to 255; without looks and contrast where it is NaN.
    """
    image_db = scene.image * (span_db / 255)
    regions = surface_regions(scene.layer_bins, min(scene.n_range_bins, scene.image.shape[0]))
    found = {}
    if regions["above"].stop > MARGIN_BINS and np.isfinite(span_db):
        found["looks of the air", 0] = equivalent_number_of_looks(
            10 ** (image_db[regions["above"]] / 10)
        )
    below = scene.image[regions["below"]].astype(float)
    depth = np.arange(len(below))
    fall = np.polyval(np.polyfit(depth, below.mean(axis=1), CUBIC), depth)[:, None]
    for along, part in (
        ("range_line", below - below.mean(axis=1, keepdims=True)),
        ("range_bin", below - fall),
    ):
        lags = [lag for lag in LAGS if lag < part.shape[along == "range_line"]]
        values = autocorrelation(part, lags, along=along)
        found |= {
            (f"autocorrelation, {along}", lag): value
            for lag, value in zip(lags, values, strict=True)
        }
    if np.isfinite(span_db):
        found |= contrast_of_layers(image_db, scene.layer_bins)
    return found


def contrast_of_layers(image_db, layer_bins):
    """How far each layer's mean echo rises over the least on either side of it [dB], uppermost first."""
    found = {}
    lines, offsets = np.arange(image_db.shape[1]), np.arange(-BESIDE_BINS, BESIDE_BINS + 1)
    for number, layer in enumerate(layer_bins[1 : N_LAYERS + 1], start=1):
        known = np.isfinite(layer)
        rows = np.rint(layer[known]).astype(int) + offsets[:, None]
        inside = (rows >= 0) & (rows < len(image_db))
        if not inside.all() or not known.any():
            continue
        profile = image_db[rows, lines[known]].mean(axis=1)
        peak = profile[np.abs(offsets) <= PEAK_BINS].max()
        sides = profile[offsets < -PEAK_BINS].min(), profile[offsets > PEAK_BINS].min()
        found["contrast of layers", number] = peak - np.mean(sides)
    return found


def describe_layers(layer_bins):
    """Numbers of a scene's layers by (quantity, lag): roughness of layers and slabs along track, NaN left out.

    Root mean square second difference [bins], and structure function, the mean square difference at
    a lag [bins^2].
    """
    found = {}
    for name, series in (
        ("layers", layer_bins[: N_SLABS + 1]),
        ("slabs", np.diff(layer_bins[: N_SLABS + 1], axis=0)),
    ):
        second = np.diff(series, n=2, axis=1)
        if np.isfinite(second).any():
            found[f"second difference, {name}", 0] = np.sqrt(np.nanmean(second**2))
        for lag in (lag for lag in LAYER_LAGS if lag < series.shape[1]):
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
        keys = list(dict.fromkeys(key for of_scene in of_scenes for key in of_scene))
        values = np.array([[of_scene.get(key, np.nan) for key in keys] for of_scene in of_scenes])
        known = np.isfinite(values)
        drawn = rng.multinomial(len(values), np.full(len(values), 1 / len(values)), N_BOOTSTRAP)
        n_drawn = drawn @ known
        # A number of a single scene may be missing from a resample.
        means = np.where(n_drawn, drawn @ np.nan_to_num(values) / np.maximum(n_drawn, 1), np.nan)
        columns = (
            np.nanmean(values, axis=0),
            *np.nanpercentile(means, [2.5, 97.5], axis=0),
            known.sum(axis=0),
        )
        rows += [(*key, name, *of_key) for key, *of_key in zip(keys, *columns, strict=True)]
    table = pd.DataFrame(
        rows, columns=["quantity", "at", "scenes", "mean", "low", "high", "n_scenes"]
    )
    return table.sort_values(["quantity", "at"], kind="stable")
