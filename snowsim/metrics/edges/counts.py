"""Matched and unmatched pixels of one edge map at every threshold."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from snowsim.limits import check_values
from snowsim.metrics.edges.matching import Matching
from snowsim.metrics.edges.suppression import check_prediction
from snowsim.metrics.edges.thinning import (
    DELETABLE,
    neighbour_steps,
    switch_on,
    thin_pixels,
)

THRESHOLDS = np.linspace(0.01, 0.99, 99)  # thresholds of the published code


def thresholds_of(edges):
    """Thresholds for maps of any scale: 99 quantiles of their values, ascending.

    Parameters
    ----------
    edges : iterable of ndarray
        Suppressed maps of all images that are scored together.

    Returns
    -------
    ndarray, (threshold,)
        Counted from the top, the k-th threshold is reached by a share ``(k / 100)^2`` of the
        distinct values above 0. The smallest share is a ten-thousandth, so that precision is known
        at small recalls; equal steps would begin at a hundredth. If there are fewer than 99
        distinct values, as in some 8-bit maps, thresholds repeat. If all pixels are 0, the result
        is `THRESHOLDS`.

    Examples
    --------
    Counts of pixels stay the same under any increasing function of the values, here a square:

    >>> edges = np.random.default_rng(1).random((30, 40))
    >>> [int((edges**2 >= each).sum()) for each in thresholds_of([edges**2])[::-33]]
    [1, 139, 539]
    """
    values = np.unique(np.concatenate([each[each > 0] for each in edges]))
    if values.size == 0:
        return THRESHOLDS
    share = (np.arange(THRESHOLDS.size, 0, -1) / 100) ** 2
    return values[((1 - share) * values.size).astype(int)]


def match_counts(
    prediction: ArrayLike,
    truth: ArrayLike,
    thresholds: ArrayLike,
    *,
    max_dist: float = 0.0075,
    thin: bool = True,
) -> dict[str, NDArray[np.integer]]:
    """Numbers of matched and of all pixels of one image, predicted and true, at every threshold.

    The map is not suppressed here: pass `suppress(prediction)` for the usual scores.

    Parameters
    ----------
    prediction : array_like, (range_bin, range_line)
        Edge map in [0, 1]; a pixel is on where it is at least the threshold.
    truth : array_like of bool (or 0 and 1), (range_bin, range_line)
        True edges, which are never thinned.
    thresholds : array_like, (threshold,)
        Thresholds in any order; counts have the same order.
    max_dist : float
        Largest distance between the pixels of a pair, as a share of the image diagonal.
    thin : bool
        If True, every thresholded map is first thinned to one-pixel lines by algorithm A1 of Guo &
        Hall (1989), Commun. ACM 32. Thinning stops where the Python port of the Berkeley benchmark
        (py-bsds500) stops, so that counts compare with published ones.

    Returns
    -------
    dict of ndarray of int64, (threshold,)
        `matched_truth`, `n_truth`, `matched_prediction`, `n_prediction`. Pairs are one-to-one, so
        the two numbers of matched pixels are equal.

    Raises
    ------
    ValueError
        If the prediction is empty, not a number or outside [0, 1]; sizes differ; the truth is not
        binary; there is no threshold or one is not finite; the distance is negative or not finite;
        `thin` is not True or False.

    Notes
    -----
    This is the protocol of the Berkeley benchmark (Martin, Fowlkes & Malik 2004, IEEE TPAMI 26).
    Its minimum-cost assignment with outliers is replaced by the exact maximum-cardinality matching:
    the largest number of pairs with ``d^2 <= (max_dist diagonal)^2``. Thresholds are processed from
    the highest down, and each matching is repaired from the one before. If thinning changes little,
    all thresholds therefore cost little more than the lowest one.

    Examples
    --------
    >>> truth = np.zeros((40, 60), dtype=bool)
    >>> truth[20, 5:55] = True
    >>> prediction = np.zeros((40, 60))
    >>> prediction[19, 5:55] = 0.9  # one range bin off, within 0.03 of the diagonal
    >>> prediction[30, 20:30] = 0.4  # nothing there
    >>> counts = match_counts(prediction, truth, [0.3, 0.8], max_dist=0.03)
    >>> counts["matched_prediction"], counts["n_prediction"], counts["n_truth"]
    (array([50, 50]), array([60, 50]), array([50, 50]))
    """
    prediction = check_prediction(prediction)
    truth = np.asarray(truth)
    if truth.shape != prediction.shape or not np.isin(truth, (0, 1)).all():
        msg = "truth must hold 0 and 1 alone in the prediction's shape, "
        msg += f"{prediction.shape}, got shape {truth.shape}"
        raise ValueError(msg)
    truth = truth.astype(bool)
    thresholds = np.asarray(thresholds, dtype=float)
    is_row = thresholds.ndim == 1 and thresholds.size > 0 and np.isfinite(thresholds).all()
    if not is_row or not isinstance(thin, bool | np.bool_):
        msg = "thresholds must be numbers in a row and thin True or False, "
        msg += f"got {thresholds} and thin {thin!r}"
        raise ValueError(msg)
    check_values("max_dist", max_dist, 0, number=True)
    radius = max_dist * np.hypot(*truth.shape)
    levels, level_of_threshold = np.unique(thresholds, return_inverse=True)
    # Thinning needs a border of empty pixels; the truth gets one too, so that flat indices agree.
    matching = Matching(np.pad(truth, 1), radius)
    matched = np.zeros(levels.size, dtype=np.int64)
    n_prediction = np.zeros(levels.size, dtype=np.int64)
    n_on = 0
    for level, removed, added in _changes_by_level(np.pad(prediction, 1), levels, thin):
        n_on += added.size - removed.size
        n_prediction[level] = n_on
        matched[level] = matching.update(removed, added)
    return {
        "matched_truth": matched[level_of_threshold],
        "n_truth": np.full(thresholds.size, matching.n_truth, dtype=np.int64),
        "matched_prediction": matched[level_of_threshold],
        "n_prediction": n_prediction[level_of_threshold],
    }


def _changes_by_level(framed, levels, thin):
    """Iterator over levels from the top down: number, pixels turned off, pixels turned on.

    Pixels are flat indices. They differ between the map at this level and at the level above; both
    maps are thinned if `thin`.
    """
    above_lowest = framed >= levels[0]
    # The border is not part of the map, even if its zeros reach a level of 0 or less.
    above_lowest[[0, -1]] = False
    above_lowest[:, [0, -1]] = False
    pixels = np.flatnonzero(above_lowest)
    n_levels_reached = np.searchsorted(levels, framed.flat[pixels], side="right").astype(np.uint16)
    pixels = pixels[np.argsort(levels.size - n_levels_reached, kind="stable")]
    n_pixels_reaching = np.bincount(n_levels_reached, minlength=levels.size + 1)
    ends = np.cumsum(n_pixels_reaching[::-1])  # the first counts pixels that reach every level
    steps = neighbour_steps(framed.shape[1])
    on = np.zeros(framed.size, dtype=np.uint8)
    codes = np.zeros_like(on)
    was_on = np.zeros_like(on)
    nothing = pixels[:0]
    start = 0
    for level, end in zip(range(levels.size)[::-1], ends, strict=False):
        joining = pixels[start:end]
        start = end
        if not (thin and joining.size):
            yield level, nothing, joining
            continue
        switch_on(joining, on, codes, steps)
        thinned = on.copy()
        reached = pixels[:end]
        thin_pixels(reached, thinned, codes.copy(), steps, DELETABLE)
        changed = reached[thinned[reached] != was_on[reached]]
        joined = thinned[changed] == 1
        was_on = thinned
        yield level, changed[~joined], changed[joined]
