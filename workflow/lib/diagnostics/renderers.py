"""Every renderer of label sets: what a pixel costs, and what its renders are worth; where their layers lie."""

import time
from dataclasses import replace

import numpy as np
import pandas as pd
from scipy.ndimage import gaussian_filter1d

from lib.diagnostics.drawn_scenes import two_sample_table
from lib.scope import geometry
from lib.tracker_training import compose
from snowsim.metrics.edges import THRESHOLDS, match_counts, score, suppress
from snowsim.metrics.texture import layer_position_error
from snowsim.seeding import random_stream
from snowsim.tracker import OUTPUTS, Training, track, train_steps

SMOOTHED_LINES = 4.0  # standard deviation of the mean along track in which layers are sought


def render_all(render, scenes):
    """Scenes as one renderer, a function of a scene, draws them, and seconds of processor time a pixel."""
    started = time.process_time()
    rendered = [
        replace(scene, image=render(scene), complete_layer_bins=None, echoes=None)
        for scene in scenes
    ]
    return rendered, (time.process_time() - started) / sum(scene.image.size for scene in rendered)


def trained_alone(scenes, validation, settings, *, seed):
    """Fused edge scores on validation scenes of a tracker trained on some scenes alone, and `core_seconds` of that."""
    together, settings = compose(scenes, [], settings, None, seed, added_per_real=1.0)
    started = time.process_time()
    training = Training(settings, seed=seed)
    for _ in train_steps(training, together):
        pass
    seconds = time.process_time() - started
    counts = []
    for scene in validation:
        fused = track(training.network, scene.image, precision=settings.precision)[
            OUTPUTS.index("fuse")
        ]
        counts.append(
            match_counts(
                suppress(fused, where=scene.name), scene.mask(), THRESHOLDS, where=scene.name
            )
        )
    return {**score(counts, THRESHOLDS), "core_seconds": seconds}


def worth(name, rendered, observed, validation, settings, *, seed, n_trainings, n_splits, n_steps):
    """A row a training: two-sample accuracies of a renderer's scenes, and scores of a tracker trained on them alone."""
    seeds = [
        int(random_stream(seed, "train_tracker", str(k)).integers(2**31))
        for k in range(n_trainings)
    ]
    sets = {"observed": observed, name: rendered[: len(observed)]}
    options = {"n_splits": n_splits, "n_steps": n_steps}
    table = two_sample_table(
        sets, **options, stream=lambda *keys: random_stream(seed, "compare_scenes", *keys)
    )
    whole = table[(table["scenes"] == name) & (table["first_row"] < 0)].set_index("classifier")[
        "accuracy"
    ]
    row = {
        "renderer": name,
        "two_sample_network": whole["network"],
        "two_sample_texture": whole["texture"],
    }
    scores = [trained_alone(rendered, validation, settings, seed=s) for s in seeds]
    return [row | {"replica": k, "ods": s["ods"], "ap": s["ap"]} for k, s in enumerate(scores)]


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
        error = layer_position_error(gaussian_filter1d(image, SMOOTHED_LINES, axis=1), buried)[
            "error_bins"
        ]
        found, given = np.isfinite(error), np.isfinite(buried)
        below = image[int(np.nanmax(buried)) + 15 :].mean(axis=1) - image[:40].mean()
        row = {
            "renderer": name,
            "scene": scene.name,
            "outside": is_outside(scene),
            **geometry(scene),
        }
        row["error_bins"] = np.median(np.abs(error[found])) if found.any() else np.nan
        row["share_found"] = found.sum() / given.sum()
        rows.append(row | {"below_grey": below.mean(), "below_deviation": below.std()})
    return pd.DataFrame(rows)
