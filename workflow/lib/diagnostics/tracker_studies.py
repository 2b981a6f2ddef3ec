"""Studies of the tracker: what the settings of its training do to its scores, and where it fails."""

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
    """Scores of runs against others, by pairs; `counts` maps (setting, training set) to counts by image and replica."""
    table = compare(counts, pairs, n_bootstrap=n_bootstrap, rng=rng)
    named = pd.DataFrame(table.pop("name").tolist(), columns=["setting", "training_set"])
    named[["base", "base_training_set"]] = table.pop("base").tolist()
    return pd.concat([named, table], axis=1)


def training_atlas(real, settings, learning_rates, n_seeds):
    """What short trainings come to at several rates and seeds, and one on a scene without labels: rows of a table."""
    for rate in learning_rates:
        changed = dataclasses.replace(settings, learning_rate=rate)
        for replica in range(n_seeds):
            work = partial(short_training, real, changed, replica)
            yield row("loss", rate, work, replica, failure=FloatingPointError, status="diverged")
    empty = dataclasses.replace(real[0], layer_bins=np.full_like(real[0].layer_bins, np.nan))
    yield row("empty labels", 0, partial(short_training, [empty], changed, 0))


def short_training(real, settings, seed):
    """Mean loss of the last steps of a short training."""
    losses = [
        step["total"]
        for _, step in train_steps(Training(settings, seed=seed), TrainingSet(real, seed=seed))
    ]
    return float(np.mean(losses[-N_LAST:]))


def tracking_atlas(network, precision, scenes, atlas, render_level):
    """Fused ODS on changed (image, mask) pairs and on pairs of level layers of `render_level`: rows of a table."""

    def ods(pairs):
        edges = [
            suppress(track(network, image, precision=precision)[OUTPUTS.index("fuse")])
            for image, _ in pairs
        ]
        counts = [
            match_counts(found, mask, THRESHOLDS)
            for found, (_, mask) in zip(edges, pairs, strict=True)
        ]
        return score(counts)["ods"]

    yield row("flat image", 0, partial(ods, [(scenes[0][0] * 0, scenes[0][1])]))
    for shift in atlas["brightness_shifts"]:
        shifted = [
            (np.clip(image.astype(int) + shift, 0, 255).astype(np.uint8), mask)
            for image, mask in scenes
        ]
        yield row("brightness", shift, partial(ods, shifted))
    for cut in atlas["rows_cut"]:
        # From the bottom, where no layer lies.
        rows = [image.shape[0] // 16 * 16 - cut for image, _ in scenes]
        lower = [
            (image[:n_rows], mask[:n_rows])
            for (image, mask), n_rows in zip(scenes, rows, strict=True)
        ]
        yield row("rows cut", cut, partial(ods, lower))
    for n_layers in atlas["n_layers"]:
        yield row("layers", n_layers, partial(ods, [render_level(n_layers)]))


def row(panel, value, work, replica=0, *, failure=ValueError, status="refused"):
    """Result of work, or NaN and a status where this kind of failure says that it cannot be done."""
    about = {"panel": panel, "value": value, "replica": replica}
    try:
        return about | {"result": work(), "status": "ok"}
    except failure:
        return about | {"result": np.nan, "status": status}


def level_scene(n_layers, n_range_lines=256):
    """Level layers, to be rendered."""
    layer_bins = SURFACE_ROW + LAYER_SPACING_BINS * np.arange(n_layers + 1.0)[:, None] * np.ones(
        n_range_lines
    )
    return Scene(f"{n_layers} level layers", scene_height(layer_bins), layer_bins)
