"""Every renderer of label sets: what a pixel costs, what renders are worth, where layers lie."""

import time
from dataclasses import replace
from functools import partial

import numpy as np
import pandas as pd
from scipy.ndimage import gaussian_filter1d

from evaluation.lib.drawn_scenes import two_sample_table
from evaluation.lib.tracker_studies import fused_counts
from lib.scope import geometry
from lib.tracker_training import compose
from snowsim.metrics.edges import THRESHOLDS, score
from snowsim.metrics.texture import layer_position_error
from snowsim.seeding import random_stream
from snowsim.tracker import Training, train_steps

SMOOTHED_LINES = 4.0  # standard deviation of the mean along track in which layers are sought


def render_all(render, scenes):
    """Scenes as a renderer, a function of a scene, draws them, and processor time a pixel [s]."""
    started = time.process_time()
    rendered = [
        replace(scene, image=render(scene), complete_layer_bins=None, echoes=None)
        for scene in scenes
    ]
    seconds = time.process_time() - started
    return rendered, seconds / sum(scene.image.size for scene in rendered)


def trained_alone(scenes, validation, settings, *, seed):
    """Fused edge scores on validation scenes of a tracker trained on some scenes alone.

    And `core_seconds` of the training.
    """
    together, settings = compose(scenes, [], settings, None, seed, added_per_real=1.0)
    started = time.process_time()
    training = Training(settings, seed=seed)
    for _ in train_steps(training, together):
        pass
    seconds = time.process_time() - started
    counts = []
    for scene in validation:
        found = fused_counts(
            training.network,
            scene.image,
            scene.mask(),
            precision=settings.precision,
            where=scene.name,
        )
        counts.append(found)
    return {**score(counts, THRESHOLDS), "core_seconds": seconds}


def worth(name, rendered, observed, validation, settings, *, seed, n_trainings, n_splits, n_steps):
    """A row a training: accuracies of the two-sample test, scores of a tracker of renders alone."""
    sets = {"observed": observed, name: rendered[: len(observed)]}
    stream = partial(random_stream, seed, "compare_scenes")
    table = two_sample_table(sets, n_splits=n_splits, n_steps=n_steps, stream=stream)
    whole = table[(table["scenes"] == name) & (table["first_row"] < 0)]
    accuracy = whole.set_index("classifier")["accuracy"]
    rows = []
    for replica in range(n_trainings):
        rng = random_stream(seed, "train_tracker", str(replica))
        scores = trained_alone(rendered, validation, settings, seed=int(rng.integers(2**31)))
        row = {
            "renderer": name,
            "two_sample_network": accuracy["network"],
            "two_sample_texture": accuracy["texture"],
            "replica": replica,
            "ods": scores["ods"],
            "ap": scores["ap"],
        }
        rows.append(row)
    return rows


def position_rows(name, scenes, is_outside):
    """Where renders show the layers they were given: a row a scene, with its `geometry`.

    `error_bins`: median distance of the brightest bin near a layer from it, after a mean along
    track; `share_found` of the layers' pixels have one in reach; `below_grey`: mean level under the
    last layer, less that of the air, and `below_deviation` of its row means. Scenes of the surface
    alone are left out.
    """
    rows = []
    for scene in scenes:
        buried = scene.layer_bins[1:]
        if not np.isfinite(buried).any():
            continue
        image = scene.image.astype(float)
        smoothed = gaussian_filter1d(image, SMOOTHED_LINES, axis=1)
        error = layer_position_error(smoothed, buried)["error_bins"]
        found = error[np.isfinite(error)]
        first_below = int(np.nanmax(buried)) + 15
        below = image[first_below:].mean(axis=1) - image[:40].mean()
        row = {
            "renderer": name,
            "scene": scene.name,
            "outside": is_outside(scene),
            **geometry(scene),
            "error_bins": np.median(np.abs(found)) if found.size else np.nan,
            "share_found": found.size / np.isfinite(buried).sum(),
            "below_grey": below.mean(),
            "below_deviation": below.std(),
        }
        rows.append(row)
    return pd.DataFrame(rows)
