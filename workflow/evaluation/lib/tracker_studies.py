"""Studies of the tracker: what settings of its training do to its scores, and where it fails."""

import dataclasses
from functools import partial

import numpy as np
import pandas as pd

from snowsim.echogram import SURFACE_ROW, Scene, scene_height
from snowsim.metrics.comparison import compare
from snowsim.metrics.edges import THRESHOLDS, match_counts, score, suppress
from snowsim.tracker import OUTPUTS, Training, TrainingSet, track, train_steps

LAYER_SPACING_BINS = 12
N_LAST = 50  # steps whose loss is averaged: what a training has come to


def runs_table(counts, pairs, *, n_bootstrap, rng):
    """Scores of runs against others, by pairs.

    `counts` maps (setting, training set) to counts by image and replica.
    """
    table = compare(counts, pairs, n_bootstrap=n_bootstrap, rng=rng)
    named = pd.DataFrame(table.pop("name").tolist(), columns=["setting", "training_set"])
    named[["base", "base_training_set"]] = table.pop("base").tolist()
    return pd.concat([named, table], axis=1)


def training_atlas(real, settings, learning_rates, n_seeds):
    """What short trainings come to at some rates and seeds, and one on a scene without labels."""
    for rate in learning_rates:
        changed = dataclasses.replace(settings, learning_rate=rate)
        for replica in range(n_seeds):
            work = partial(short_training, real, changed, replica)
            yield row("loss", rate, work, replica, failure=FloatingPointError, status="diverged")
    first = real[0]
    empty = dataclasses.replace(first, layer_bins=np.full_like(first.layer_bins, np.nan))
    yield row("empty labels", 0, partial(short_training, [empty], changed, 0))


def short_training(real, settings, seed):
    """Mean loss of the last steps of a short training."""
    training = Training(settings, seed=seed)
    steps = train_steps(training, TrainingSet(real, seed=seed))
    losses = [losses["total"] for _, losses in steps]
    return float(np.mean(losses[-N_LAST:]))


def fused_counts(network, image, mask, *, precision, where="image"):
    """Counts of the fused edges that a network finds in an image, against its mask."""
    probabilities = track(network, image, precision=precision)
    edges = suppress(probabilities[OUTPUTS.index("fuse")], where=where)
    return match_counts(edges, mask, THRESHOLDS, where=where)


def tracking_atlas(network, precision, scenes, atlas, render_level):
    """Fused ODS on changed (image, mask) pairs, and on pairs of level layers by `render_level`."""

    def ods(pairs):
        return score([fused_counts(network, *pair, precision=precision) for pair in pairs])["ods"]

    image, mask = scenes[0]
    yield row("flat image", 0, partial(ods, [(image * 0, mask)]))
    for shift in atlas["brightness_shifts"]:
        shifted = [(_brighter(image, shift), mask) for image, mask in scenes]
        yield row("brightness", shift, partial(ods, shifted))
    for cut in atlas["rows_cut"]:
        lower = [(_lower(image, cut), _lower(mask, cut)) for image, mask in scenes]
        yield row("rows cut", cut, partial(ods, lower))
    for n_layers in atlas["n_layers"]:
        yield row("layers", n_layers, partial(ods, [render_level(n_layers)]))


def _brighter(image, shift):
    return np.clip(image.astype(int) + shift, 0, 255).astype(np.uint8)


def _lower(image, cut):
    """Whole sixteens of rows but for some, cut from the bottom, where no layer lies."""
    return image[: len(image) // 16 * 16 - cut]


def row(panel, value, work, replica=0, *, failure=ValueError, status="refused"):
    """Result of work, or NaN and a status where this kind of failure says that it cannot be."""
    found = {"panel": panel, "value": value, "replica": replica, "result": np.nan}
    try:
        return found | {"result": work(), "status": "ok"}
    except failure:
        return found | {"status": status}


def level_scene(n_layers, n_range_lines=256):
    """Level layers, to be rendered."""
    level_bins = SURFACE_ROW + LAYER_SPACING_BINS * np.arange(n_layers + 1.0)
    layer_bins = np.repeat(level_bins[:, None], n_range_lines, axis=1)
    return Scene(f"{n_layers} level layers", scene_height(layer_bins), layer_bins)
