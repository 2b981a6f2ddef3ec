"""Statistics of a few annotated scenes, and what label sets can be drawn from them.

Few scenes may hold too little: that is a result of the learning curve, no failure of it.
"""

import pandas as pd
import xarray as xr
from main_path import logger, run

from lib.label_sets import label_model
from snowsim.frames import frame_of_scene
from snowsim.io.files import write_dataset, write_table
from snowsim.io.scenes import SceneSet
from snowsim.labels import check_labels
from snowsim.seeding import random_stream
from snowsim.statistics import estimate, merge, summarise, warn_of_little


def fit_few(
    few, statistics, choice, *, estimator, finest_lines, synthetic, labels, seed, **meaning
):
    with SceneSet(few) as scenes:
        n_scenes = len(scenes)
        frames = (frame_of_scene(scene, **meaning) for scene in scenes)
        try:
            fitted = fit(frames, estimator, finest_lines)
            radiometry, reason = drawable(fitted, labels, seed)
        except ValueError as refused:
            fitted = xr.Dataset()
            radiometry, reason = "refused", str(refused)
    logger.info("%d scenes: %s %s", n_scenes, radiometry, reason)
    write_dataset(statistics, fitted.assign_attrs(synthetic=synthetic))
    row = {"n_scenes": n_scenes, "radiometry": radiometry, "reason": reason}
    write_table(choice, pd.DataFrame([row]))


def fit(frames, estimator, finest_lines):
    """Statistics of frames."""
    summaries = [summarise(*frame, where=f"scene {i}") for i, frame in enumerate(frames)]
    fitted = estimate(merge(summaries), estimator=estimator, finest_lines=finest_lines)
    warn_of_little(fitted)
    return fitted


def drawable(fitted, labels, seed):
    """The radiometry that label sets can have, and why it is not that of the configuration.

    Where that is refused, it is `constant`, as the refusal advises; ValueError if that is, too.
    """
    try:
        checked(fitted, labels, seed)
    except ValueError as refused:
        checked(fitted, labels | {"radiometry": "constant"}, seed)
        return "constant", str(refused)
    return labels["radiometry"], ""


def checked(fitted, labels, seed):
    """Nothing, or a ValueError where no label sets can be drawn."""
    check_labels(label_model(fitted, **labels), rng=random_stream(seed, "check_labels"))


run(fit_few)
