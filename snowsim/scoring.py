"""Scores of a tracker's files: `snowsim.score_folders`, which the command `snowsim score` calls."""

from concurrent.futures import ProcessPoolExecutor
from contextlib import ExitStack
from functools import partial

import numpy as np
import pandas as pd

from snowsim.io.guard import refusal
from snowsim.io.predictions import pair_files, read_labels, read_map
from snowsim.metrics.comparison import METRICS, replica_scores
from snowsim.metrics.edges import THRESHOLDS, match_counts, score, stack_counts, suppress
from snowsim.metrics.pick_tables import SUMS, errors_of_sums, layer_rows
from snowsim.metrics.picks import pick_layers

PICK_SCORES = ["mean_absolute_error_bins", "bias_bins", "share_within", "share_found"]
PICK_SCORES += ["n_layers", "n_missed_layers", "n_false_layers"]


def score_folders(
    predictions, truth, *, output=None, picks=False, suppressed=False, tolerance=0.0075, tolerance_bins=None,
    max_distance_bins=10.0, within_bins=2.0, n_bootstrap=1000, seed=0, processes=1, progress=lambda steps, total: steps,
):  # fmt: skip
    """Edge scores and errors of picks of a tracker, from two folders of files.

    Parameters
    ----------
    predictions, truth : path_like
        Folders of .png, .npy or .nc files, or one file each. Edge maps are in [0, 1] or 8-bit,
        layers bright; truth is a mask, layer numbers, or layers in range bins; truth without a
        prediction is not scored. Of the published predictor's folder, as it stands, the maps of
        `output` are scored, by default `fuse`.
    picks : bool
        Predictions are layers, not edge maps, in the forms of the truth; they have no edge scores.
        Else picks are followed through the edge maps, at the threshold of the best F of the set.
    suppressed : bool
        Edge maps are thin already: no non-maximum suppression.
    tolerance, tolerance_bins : float
        Largest distance of a matched pair as a share of the image diagonal; or, where not None, in
        pixels.
    max_distance_bins, within_bins : float
        How far from a layer a pick may lie to be its own; which errors count as small [range bins].
    n_bootstrap, seed : int
        Resamples of the images for the intervals, and what they are drawn with.
    processes : int
        How many work at once; scores do not depend on it.
    progress : callable
        Wraps an iterable of known length: ``progress(steps, total)``.

    Returns
    -------
    pandas.DataFrame
        A row for each `image`, then `all` of them, and the `low` and `high` end of its 95 %
        interval: `ods`, `ois`, `ap`, `threshold` of the best F; `mean_absolute_error_bins`,
        `bias_bins`, `share_within`, `share_found` of the true pixels; `n_layers`,
        `n_missed_layers`, `n_false_layers`.

    Raises
    ------
    ValueError
        In one line: no pairs, a prediction without truth, sizes that differ, truth without a layer,
        maps that leave [0, 1], dark layers on bright ground, files that cannot be read.

    Examples
    --------
    >>> import numpy as np
    >>> truth = 50 + 30 * np.arange(4)[:, None] + np.sin(np.arange(256) / 20)
    >>> near = np.abs(np.arange(300)[:, None, None] - truth - 1).min(axis=1)  # a range bin too deep
    >>> np.save("truth.npy", truth)
    >>> np.save("map.npy", np.exp(-((near / 2) ** 2)))
    >>> table = score_folders("map.npy", "truth.npy")
    >>> [round(float(table[column][0]), 2) for column in ("ods", "mean_absolute_error_bins", "n_missed_layers")]
    [1.0, 1.0, 0.0]
    """
    pairs = pair_files(predictions, truth, output=output, picks=picks)
    with ExitStack() as stack:
        mapped = stack.enter_context(ProcessPoolExecutor(processes)).map if processes > 1 else map

        def each(function, **settings):
            return list(progress(mapped(partial(function, **settings), pairs), len(pairs)))

        threshold = counts = None
        if not picks:
            how = {"max_dist": tolerance, "max_dist_pixels": tolerance_bins}
            counts = each(_count, suppressed=suppressed, how=how)
            threshold = score(counts, THRESHOLDS)["ods_threshold"]
        follow = {"max_distance_bins": max_distance_bins, "within_bins": within_bins}
        rows = each(_pick, suppressed=suppressed, threshold=threshold, follow=follow)
    names, rng = [name for name, _, _ in pairs], np.random.default_rng(seed)
    return _tabulated(names, counts, rows, n_bootstrap=n_bootstrap, rng=rng)


def _edges_and_truth(prediction, truth, suppressed):
    probability = read_map(prediction)
    mask, layer_bins = read_labels(truth, probability.shape)
    if not mask.any():
        raise refusal(truth, "truth", "at least one layer in the image", "none")
    on, off = probability[mask], probability[~mask]
    if off.size and np.median(probability) > 0.5 and on.mean() < off.mean():
        found = f"a mean of {on.mean():.2g} on them and {off.mean():.2g} off"
        msg = f"{prediction}: expected bright layers on a dark ground, got {found}"
        raise ValueError(msg)
    return (
        probability if suppressed else suppress(probability, where=str(prediction)),
        mask,
        layer_bins,
    )


def _count(pair, *, suppressed, how):
    """Counts of one image."""
    edges, mask, _ = _edges_and_truth(*pair[1:], suppressed)
    return match_counts(edges, mask, THRESHOLDS, **how, where=str(pair[1]))


def _pick(pair, *, suppressed, threshold, follow):
    """What became of the layers of one image; without a threshold, in picks that are the tracker's own."""
    _, prediction, truth = pair
    if threshold is None:
        picks, layer_bins = read_labels(prediction)[1], read_labels(truth)[1]
    else:
        edges, _, layer_bins = _edges_and_truth(prediction, truth, suppressed)
        picks = pick_layers(edges, threshold=threshold, where=str(prediction))
    layer_bins = layer_bins[np.isfinite(layer_bins).any(axis=1)]
    if layer_bins.size == 0:
        raise refusal(truth, "truth", "at least one layer", "none")
    if picks.shape[1] != layer_bins.shape[1]:
        raise refusal(
            prediction, "size", f"{layer_bins.shape[1]} range lines as {truth} has", picks.shape[1]
        )
    return layer_rows(picks, layer_bins, **follow)


def _tabulated(names, counts, picks, *, n_bootstrap, rng):
    """Table of `score_folders` from what `match_counts` (or None) and `layer_rows` give of each image.

    `low` and `high` are the 2.5 and 97.5 percentiles of resamples of the images, drawn with
    replacement, NaN for one image alone, whose `ods` and `ois` are its best F.
    """
    sums = pd.DataFrame([rows[list(SUMS)].sum() for rows in picks])
    draws = rng.integers(len(names), size=(n_bootstrap, len(names)))
    times = np.array([np.bincount(draw, minlength=len(names)) for draw in draws])
    # Every image once, all of them, and each as often as a resample has it.
    parts = [
        sums,
        sums.sum().to_frame().T,
        pd.DataFrame(times @ sums.to_numpy(), columns=sums.columns),
    ]
    parts = [errors_of_sums(part, bin_size_m=1)[PICK_SCORES] for part in parts]
    if counts is not None:
        stacked = stack_counts(counts)
        edges = [[_of_edges([image]) for image in counts], [_of_edges(stacked)]]
        edges.append(
            [dict(zip(METRICS, replica_scores([stacked], draw)[0], strict=True)) for draw in draws]
        )
        parts = [
            pd.concat([pd.DataFrame(e), part], axis=1) for e, part in zip(edges, parts, strict=True)
        ]
    ends = parts[2].quantile([0.025, 0.975]) if len(names) > 1 else pd.DataFrame(index=range(2))
    table = pd.concat([*parts[:2], ends], ignore_index=True)
    table.insert(0, "image", [*names, "all", "low", "high"])
    return table


def _of_edges(counts):
    scores = score(counts, THRESHOLDS)
    return {name: scores[name] for name in METRICS} | {"threshold": scores["ods_threshold"]}
