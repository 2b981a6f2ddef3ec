"""Scores of a set of images from their counts: ODS, OIS, AP and the precision-recall curve."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from snowsim.limits import check_values

METRICS = ("ods", "ois", "ap")
COUNTS = ("matched_truth", "n_truth", "matched_prediction", "n_prediction")
EVERY_HUNDREDTH = np.linspace(0, 1, 101)


def stack_counts(counts):
    """Counts of a set of images as a dict of arrays (image, threshold).

    `counts` is a list of results of `match_counts`, one for each image, or a dict of such arrays.
    """
    if isinstance(counts, dict):
        return {name: np.asarray(counts[name]) for name in COUNTS}
    return {name: np.array([image[name] for image in counts]) for name in COUNTS}


def select_images(counts, images):
    """Stacked counts of the images with these numbers, which may repeat."""
    return {name: values[images] for name, values in counts.items()}


def score(
    counts: Sequence[Mapping[str, ArrayLike]],
    thresholds: ArrayLike | None = None,
    *,
    as_published: bool = False,
) -> dict[str, float]:
    """ODS, OIS and AP of a set of images.

    Parameters
    ----------
    counts : sequence of dict, or dict of ndarray (image, threshold)
        Results of `match_counts` for every image, at ascending thresholds, or of `stack_counts`.
    thresholds : array_like, (threshold,), optional
        Thresholds of the counts; only `ods_threshold` needs them.
    as_published : bool
        In OIS, use the lowest threshold for an image in which no layer is found.

    Returns
    -------
    dict
        `ods`, the best F of the pooled counts at one threshold for all images; `ois`, the F of the
        counts pooled over images, each at its own best threshold; `ap`, the mean precision over
        recalls; `ods_index` and `ods_threshold`, number and value of the threshold of `ods` (NaN
        unless thresholds are given); `n_images` and `n_without_truth`.

    Raises
    ------
    ValueError
        If there is no image, shapes of counts differ, more pixels match than there are, thresholds
        decrease, or their number is not that of the counts.

    Notes
    -----
    ``F = 2 P R / (P + R)`` with ``P = matched_prediction / n_prediction`` and ``R =
    matched_truth / n_truth``, 0 where there is no pixel. Of thresholds with equal F the lowest is
    best. An image without truth, or in which no layer is found, has F = 0 at every threshold. OIS
    counts its false positives at the highest threshold, where they are fewest. The published code
    counts them at the lowest, so that OIS can be below ODS. `n_without_truth` is the number of
    images without truth.

    AP follows the 101-point rule of Dollar & Zitnick (2015), IEEE TPAMI 37. Precision is
    interpolated linearly at recalls 0, 0.01 ... 1. Of thresholds with equal recall, the lowest is
    used. Recalls outside those observed are dropped. The sum of up to 101 values is divided by 100,
    so that AP can reach 1.01. As in the published code, AP is 0 if recall is the same at every
    threshold: the curve of a perfect map of one level is a point, without an area.

    Examples
    --------
    One image, 50 true pixels; at the lower of two thresholds 10 predicted pixels match none:

    >>> counts = {"matched_truth": [50, 40], "n_truth": [50, 50]}
    >>> counts |= {"matched_prediction": [50, 40], "n_prediction": [60, 40]}
    >>> scores = score([counts], thresholds=[0.3, 0.8])
    >>> round(scores["ods"], 3), scores["ods_threshold"]  # 2 P R / (P + R) with P = 50 / 60, R = 1
    (0.909, 0.3)
    """
    stacked = stack_counts(counts)
    shapes = {values.shape for values in stacked.values()}
    shape = stacked["n_truth"].shape
    fits = len(shapes) == 1 and len(shape) == 2 and 0 not in shape
    if not fits or (thresholds is not None and np.shape(thresholds) != shape[1:]):
        msg = "expected counts of at least one image and as many thresholds as they have, "
        msg += f"got counts (image, threshold) {shape}, thresholds {np.shape(thresholds)}"
        raise ValueError(msg)
    for of in ("truth", "prediction"):
        matched = stacked[f"matched_{of}"]
        unmatched = np.subtract(stacked[f"n_{of}"], matched, dtype=float)
        what = f"matched_{of} and n_{of} less matched_{of}"
        check_values(what, np.minimum(matched, unmatched), 0)
    if thresholds is not None:
        check_values("thresholds must not decrease: steps", np.diff(thresholds), 0)
    pooled = {name: values.sum(axis=0) for name, values in stacked.items()}
    f = f_measure(*_precision_and_recall(pooled))
    f_of_images = f_measure(*_precision_and_recall(stacked))
    best = np.argmax(f_of_images, axis=1)
    if not as_published:
        best[f_of_images.max(axis=1) == 0] = shape[1] - 1
    images = np.arange(best.size)
    at_own_best = {name: values[images, best].sum() for name, values in stacked.items()}
    ods_index = int(np.argmax(f))
    return {
        "ods": float(f[ods_index]),
        "ois": float(f_measure(*_precision_and_recall(at_own_best))),
        "ap": _average_precision(pooled),
        "ods_index": ods_index,
        "ods_threshold": np.nan if thresholds is None else float(thresholds[ods_index]),
        "n_images": int(best.size),
        "n_without_truth": int((stacked["n_truth"][:, 0] == 0).sum()),
    }


def precision_recall(counts):
    """Precision, recall and F of the pooled counts of a set, dict of ndarray (threshold,).

    `counts` are those of `score`.
    """
    pooled = {name: values.sum(axis=0) for name, values in stack_counts(counts).items()}
    precision, recall = _precision_and_recall(pooled)
    return {"precision": precision, "recall": recall, "f": f_measure(precision, recall)}


def f_measure(precision, recall):
    """Harmonic mean of precision and recall, 0 where both are 0."""
    total = precision + recall
    return 2 * precision * recall / np.where(total == 0, 1, total)


def _average_precision(pooled):
    """Mean precision at 101 recalls from 0 to 1; recalls outside the range of the counts add 0."""
    precision, recall = _precision_and_recall(pooled)
    recalls, lowest = np.unique(recall, return_index=True)
    if recalls.size < 2:
        return 0.0
    # Equal recalls take the precision at their lowest threshold.
    interpolated = np.interp(EVERY_HUNDREDTH, recalls, precision[lowest], left=np.nan, right=np.nan)
    return float(np.nansum(interpolated) / 100)


def _precision_and_recall(counts):
    """Precision and recall of counts, 0 where there is no pixel."""
    precision = counts["matched_prediction"] / np.maximum(counts["n_prediction"], 1)
    recall = counts["matched_truth"] / np.maximum(counts["n_truth"], 1)
    return precision, recall
