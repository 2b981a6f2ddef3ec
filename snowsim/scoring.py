"""Scores of a tracker's files: `snowsim.score_folders`, which the command `snowsim score` calls."""

from concurrent.futures import ProcessPoolExecutor
from contextlib import ExitStack
from functools import partial

import numpy as np

from snowsim.io.guard import refusal
from snowsim.io.predictions import pair_files, read_labels, read_map
from snowsim.metrics.edges import THRESHOLDS, match_counts, score, suppress
from snowsim.metrics.pick_tables import layer_rows
from snowsim.metrics.picks import pick_layers
from snowsim.metrics.summary import check_polarity, tabulate_scores


def score_folders(
    predictions, truth, *, output=None, picks=False, suppressed=False, tolerance=0.0075, tolerance_bins=None,
    max_distance_bins=10.0, within_bins=2.0, n_bootstrap=1000, seed=0, processes=1, progress=lambda steps, total: steps,
):  # fmt: skip
    """Edge scores and errors of picks of a tracker, from two folders of files.

    Parameters
    ----------
    predictions, truth : path_like
        Folders of .png, .npy or .nc files, or one file each. Edge maps are in [0, 1] or 8-bit, layers bright; truth is
        a mask, layer numbers, or layers in range bins; truth without a prediction is not scored. Of the published
        predictor's folder, as it stands, the maps of `output` are scored, by default `fuse`.
    picks : bool
        Predictions are layers, not edge maps, in the forms of the truth; they have no edge scores. Else picks are
        followed through the edge maps, at the threshold of the best F of the set.
    suppressed : bool
        Edge maps are thin already: no non-maximum suppression.
    tolerance, tolerance_bins : float
        Largest distance of a matched pair as a share of the image diagonal; or, where not None, in pixels.
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
        A row for each `image`, then `all` of them, and the `low` and `high` end of its 95 % interval: `ods`, `ois`,
        `ap`, `threshold` of the best F; `mean_absolute_error_bins`, `bias_bins`, `share_within`, `share_found` of the
        true pixels; `n_layers`, `n_missed_layers`, `n_false_layers`.

    Raises
    ------
    ValueError
        In one line: no pairs, a prediction without truth, sizes that differ, truth without a layer, maps that leave
        [0, 1], dark layers on bright ground, files that cannot be read.

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
    return tabulate_scores(names, counts, rows, thresholds=THRESHOLDS, n_bootstrap=n_bootstrap, rng=rng)


def _edges_and_truth(prediction, truth, suppressed):
    probability = read_map(prediction)
    mask, layer_bins = read_labels(truth, probability.shape)
    if not mask.any():
        raise refusal(truth, "truth", "at least one layer in the image", "none")
    check_polarity(probability, mask, str(prediction))
    return probability if suppressed else suppress(probability, where=str(prediction)), mask, layer_bins


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
        raise refusal(prediction, "size", f"{layer_bins.shape[1]} range lines as {truth} has", picks.shape[1])
    return layer_rows(picks, layer_bins, **follow)
