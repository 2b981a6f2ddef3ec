"""Scores of each image and of the whole set: edges, picks, and intervals by resampling the images."""

import numpy as np
import pandas as pd

from snowsim.metrics.comparison import METRICS, replica_scores
from snowsim.metrics.edges import score, stack_counts
from snowsim.metrics.pick_tables import SUMS, errors_of_sums

PICK_SCORES = ["mean_absolute_error_bins", "bias_bins", "share_within", "share_found"]
PICK_SCORES += ["n_layers", "n_missed_layers", "n_false_layers"]


def check_polarity(prediction, truth, where="image"):
    """Refuse an edge map with dark layers on a bright ground, found by what lies under the true ones."""
    on, off = prediction[truth], prediction[~truth]
    if on.size and off.size and np.median(prediction) > 0.5 and on.mean() < off.mean():
        found = f"a mean of {on.mean():.2g} on them and {off.mean():.2g} off"
        msg = f"{where}: expected bright layers on a dark ground, got {found}"
        raise ValueError(msg)


def tabulate_scores(names, counts, picks, *, thresholds, n_bootstrap, rng):
    """Scores of images, a row for each of `names`, and of all of them: rows `all`, `low` and `high`.

    `counts` is of each image what `match_counts` gives (None: no edge scores), `picks` what `layer_rows` gives. `low`
    and `high` are the 2.5 and 97.5 percentiles of `n_bootstrap` resamples of the images, drawn with replacement; NaN
    for one image alone. Columns as `snowsim.score_folders` has them; `ods` and `ois` of one image are its best F.
    """
    sums = pd.DataFrame([rows[list(SUMS)].sum() for rows in picks])
    draws = rng.integers(len(names), size=(n_bootstrap, len(names)))
    times = np.array([np.bincount(draw, minlength=len(names)) for draw in draws])
    # Every image once, all of them, and each as often as a resample has it.
    parts = [sums, sums.sum().to_frame().T, pd.DataFrame(times @ sums.to_numpy(), columns=sums.columns)]
    parts = [errors_of_sums(part, bin_size_m=1)[PICK_SCORES] for part in parts]
    if counts is not None:
        stacked = stack_counts(counts)
        edges = [[_of_edges([image], thresholds) for image in counts], [_of_edges(stacked, thresholds)]]
        edges.append([dict(zip(METRICS, replica_scores([stacked], draw)[0], strict=True)) for draw in draws])
        parts = [pd.concat([pd.DataFrame(e), part], axis=1) for e, part in zip(edges, parts, strict=True)]
    ends = parts[2].quantile([0.025, 0.975]) if len(names) > 1 else pd.DataFrame(index=range(2))
    table = pd.concat([*parts[:2], ends], ignore_index=True)
    table.insert(0, "image", [*names, "all", "low", "high"])
    return table


def _of_edges(counts, thresholds):
    scores = score(counts, thresholds)
    return {name: scores[name] for name in METRICS} | {"threshold": scores["ods_threshold"]}
