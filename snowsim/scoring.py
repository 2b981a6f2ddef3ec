"""Scores of the files of a tracker, for `snowsim.score_folders` and the command `snowsim score`."""

from concurrent.futures import ProcessPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from os import PathLike

import numpy as np
import pandas as pd

from snowsim.echogram import check_choice, layer_mask
from snowsim.io.files import listed, refusal
from snowsim.io.predictions import pair_files, read_labels, read_map, read_picks, refuse_image
from snowsim.limits import BIN_S_LIMITS, check_count, check_values
from snowsim.metrics.edges import (
    CURVATURE,
    METRICS,
    THRESHOLDS,
    f_measure,
    match_counts,
    score,
    select_images,
    stack_counts,
    suppress,
    thresholds_of,
)
from snowsim.metrics.picks import SUMS, errors_of_sums, layer_rows
from snowsim.progress import with_progress
from snowsim.tracker import pick_layers

POSITIVE_OPTIONS = ("max_distance_bins", "bin_s")
LEAST_WHOLE_NUMBER = {"n_bootstrap": 1, "seed": 0, "processes": 1}
# Fewest distinct values above 0 for which the AP of a map is given. Maps that use all of [0, 1]
# change their AP by up to 0.01 if they are rounded to 16 even steps, by 0.03 with 4 steps, and by
# 0.56 with one step.
LEAST_LEVELS = 16
# Largest difference between the times of a range line in two files.
SAME_TIME = np.timedelta64(1, "ms")
PICK_SCORES = [
    "mean_absolute_error_bins",
    "bias_bins",
    "share_within",
    "share_found",
    "n_layers",
    "n_missed_layers",
    "n_false_layers",
]


def score_folders(
    predictions: str | PathLike[str],
    truth: str | PathLike[str],
    *,
    picks: bool = False,
    thresholds: str = "quantiles",
    suppressed: bool = False,
    tolerance: float = 0.0075,
    max_distance_bins: float = 10.0,
    within_bins: float = 2.0,
    n_bootstrap: int = 1000,
    seed: int = 0,
    processes: int = 1,
    bin_s: float | None = None,
) -> pd.DataFrame:
    """Table of edge scores and errors of picks of a tracker, from two folders or two files.

    Parameters
    ----------
    predictions, truth : path_like
        Folders of files, or one file each. Edge maps are 8-bit grey PNG images or .npy files of
        floats in [0, 1], layers bright. Truth is a mask or layer numbers, as PNG or as .npy of
        whole numbers, or layers in range bins, as .npy of floats. Truth drawn thicker than a pixel
        is thinned to the middle of its layers. Truth without a prediction counts as an empty map;
        predictions without a truth are left out.
    picks : bool
        Predictions are layers, not edge maps. Both are labels as above, or both are layer files
        that `snowsim.io.read_layers` reads, such as those of `snowsim track`. There are no edge
        scores. Without `picks`, layers are followed through the edge maps, at the threshold of the
        best F of all images.
    thresholds : {"quantiles", "published"}
        "quantiles" scores edge maps at quantiles of their own values, so that their scale does not
        matter (`snowsim.metrics.edges.thresholds_of`). "published" scores them as the published
        code does, at 0.01 to 0.99.
    suppressed : bool
        Edge maps are thin already, and non-maximum suppression is left out.
    tolerance : float
        Largest distance between matched pixels, as a share of the image diagonal.
    max_distance_bins : float
        Largest distance between a pick and its layer [range bins].
    within_bins : float
        Largest error of a pick that counts in `share_within` [range bins].
    n_bootstrap, seed : int
        Number of resamples of the images, from which the intervals come, and their random seed.
    processes : int
        Number of processes that work at once; scores do not depend on it.
    bin_s : float
        Length of a range bin of the echograms [s], two-way; needed for layer files only.

    Returns
    -------
    pandas.DataFrame
        A row for each `image`, one for `all` images, and `low` and `high`, the ends of its 95 %
        interval. Columns are `ods`, `ois`, `ap` and the `threshold` of the best F;
        `mean_absolute_error_bins`, `bias_bins`, `share_within` (share of the found pixels) and
        `share_found` (share of the true pixels); `n_layers`, `n_missed_layers` and
        `n_false_layers`. `ap` is NaN for maps with fewer than 16 distinct values above 0.

        ``table.attrs["notes"]`` is a list of sentences. They name missing predictions and truths,
        and truths that have no layer or were thinned. They explain an AP that is 0 or not given,
        and warn if 8-bit and float maps are mixed, or if the best F is below that of a map with all
        pixels on.

    Raises
    ------
    ValueError
        In one line, if there are no pairs, sizes or times differ, no truth has a layer, a map
        leaves [0, 1] or has dark layers on bright ground, a map is the image beside its truth, or a
        file cannot be read.

    Examples
    --------
    >>> import numpy as np
    >>> truth = 50 + 30 * np.arange(4)[:, None] + np.sin(np.arange(256) / 20)
    >>> near = np.abs(np.arange(300)[:, None, None] - truth - 1).min(axis=1)  # a range bin too deep
    >>> np.save("truth.npy", truth)
    >>> np.save("map.npy", np.exp(-((near / 2) ** 2)))
    >>> table = score_folders("map.npy", "truth.npy")
    >>> columns = ["ods", "mean_absolute_error_bins", "n_missed_layers"]
    >>> [round(float(table[column][0]), 1) for column in columns]
    [1.0, 1.0, 0.0]
    """
    numbers = {
        "tolerance": tolerance,
        "max_distance_bins": max_distance_bins,
        "within_bins": within_bins,
        "n_bootstrap": n_bootstrap,
        "seed": seed,
        "processes": processes,
        "bin_s": bin_s,
    }
    _check_settings(thresholds, numbers)
    as_published = thresholds == "published"
    pairs, left_out = pair_files(predictions, truth, picks=picks)
    with ExitStack() as stack:
        pool = stack.enter_context(ProcessPoolExecutor(processes)) if processes > 1 else None
        map_function = map if pool is None else pool.map

        def for_each_pair(function, **settings):
            results = map_function(partial(function, **settings), pairs)
            return list(with_progress(results, len(pairs), unit="image"))

        threshold = counts = score_counts = None
        if not picks:
            edges = partial(_thin_edges, suppressed=suppressed, as_published=as_published)
            values = None if as_published else for_each_pair(_edge_values, edges=edges)
            levels = THRESHOLDS if as_published else thresholds_of(values)
            counts = for_each_pair(_count_edges, edges=edges, thresholds=levels, max_dist=tolerance)
            score_counts = partial(score, thresholds=levels, as_published=as_published)
            # Picks need a threshold below 1, which maps of one level do not have.
            threshold = min(score_counts(counts)["ods_threshold"], THRESHOLDS[-1])
        rows = for_each_pair(
            _pick_errors,
            threshold=threshold,
            bin_s=bin_s,
            max_distance_bins=max_distance_bins,
            within_bins=within_bins,
        )
    names = [name for name, _, _ in pairs]
    n_layers = [row["n_layers"].sum() for row in rows]
    without_layers = [name for name, n in zip(names, n_layers, strict=True) if n == 0]
    if len(without_layers) == len(pairs):
        raise refusal(truth, "truth", "at least one layer", "none")
    rng = np.random.default_rng(seed)
    table = _make_table(names, counts, score_counts, rows, n_bootstrap=n_bootstrap, rng=rng)
    notes = _notes_of_pairs(pairs, left_out, without_layers)
    if not picks:
        notes += _notes_of_maps(counts, pairs, table.iloc[-3]["ods"]) + _leave_out_ap(table, counts)
    table.attrs["notes"] = notes
    return table


def _check_settings(thresholds, numbers):
    """ValueError if settings of `score_folders` are out of range."""
    check_choice("thresholds", thresholds, ("quantiles", "published"))
    for name, value in numbers.items():
        if name in LEAST_WHOLE_NUMBER:
            check_count(name, value, LEAST_WHOLE_NUMBER[name])
        elif name == "bin_s":
            if value is not None:
                check_values("bin_s [s]", value, *BIN_S_LIMITS, number=True)
        else:
            check_values(name, value, 0, above=name in POSITIVE_OPTIONS, number=True)


def _notes_of_pairs(pairs, left_out, without_layers):
    """Sentences about files without a partner and about truths without a layer."""
    missing = [name for name, prediction, _ in pairs if prediction is None]
    notes = []
    if left_out:
        n_predictions = len(pairs) - len(missing) + len(left_out)
        notes.append(_note("predictions without a truth are left out", left_out, n_predictions))
    if missing:
        notes.append(_note("truths without a prediction count as empty maps", missing, len(pairs)))
    if without_layers:
        words = "in truths without a layer every prediction is false"
        notes.append(_note(words, without_layers, len(pairs)))
    return notes


def _note(words, names, n_all):
    """Sentence of `words`, with the number and the names of the files that it is about."""
    return f"{words} ({len(names)} of {n_all}): {listed(names)}"


def _notes_of_maps(counts, pairs, ods):
    """Sentences about low scores, thick truths and mixed file types of maps."""
    notes = []
    # With every pixel on, each true pixel is matched by itself: recall is 1.
    n_truth = sum(int(image["n_truth"][0]) for image in counts)
    constant = f_measure(n_truth / sum(image["n_pixels"] for image in counts), 1)
    if ods < constant:
        notes.append(
            f"the best F of the set, {ods:.3g}, is below that of a map with all pixels on, "
            f"{constant:.3g}: are these maps of layers, and of these images?"
        )
    names = [name for name, _, _ in pairs]
    thick = [name for name, image in zip(names, counts, strict=True) if image["thickness"] > 1]
    if thick:
        most = max(image["thickness"] for image in counts)
        words = f"truths are thinned to the middle of layers drawn up to {most:g} pixels thick"
        notes.append(_note(words, thick, len(names)))
    outside = [name for name, image in zip(names, counts, strict=True) if image["is_cut"]]
    if outside:
        words = (
            "layers of truths leave the rows of their maps, and edge scores do not count them there"
        )
        notes.append(_note(words, outside, len(names)))
    is_8_bit = [path.suffix == ".png" for _, path, _ in pairs if path is not None]
    if 0 < sum(is_8_bit) < len(is_8_bit):
        notes.append(
            f"{sum(is_8_bit)} of {len(is_8_bit)} maps are 8-bit images, the others floats: their "
            "ap cannot be compared, since 8 bits alone can change it by 0.07"
        )
    return notes


def _leave_out_ap(table, counts):
    """Sentences about AP; in the table, `ap` is set to NaN for maps with too few levels.

    An empty map has no level, and its AP stays 0. For the last three rows, which are about all
    images, the levels of all maps are counted together.
    """
    levels = [image["levels"] for image in counts]
    levels += [np.unique(np.concatenate(levels))] * 3
    has_few = np.array([0 < values.size < LEAST_LEVELS for values in levels])
    table.loc[has_few, "ap"] = np.nan
    notes = []
    if has_few.any():
        words = f"no ap of maps with fewer than {LEAST_LEVELS} distinct values above 0"
        names = table["image"].iloc[:-3]
        notes.append(_note(words, names[has_few[:-3]], len(names)))
    all_images = table.iloc[-3]
    if all_images["ap"] == 0 < all_images["ods"]:
        notes.append("ap is 0 because recall is the same at every threshold: a curve of one point")
    return notes


@dataclass(frozen=True)
class _Image:
    """Edge map of one image, and its truth as a thin mask and as layers in range bins."""

    probability: np.ndarray
    mask: np.ndarray
    thickness: float  # median thickness of layers in the mask before it was thinned [pixels]
    layer_bins: np.ndarray


def _read_image(prediction, truth):
    """Edge map and truth of one image, from their files.

    Without a prediction, the map is empty. It is then as high as the truth. If the truth holds
    layers in range bins, it ends below the deepest layer.
    """
    probability = None if prediction is None else read_map(prediction)
    shape = None if prediction is None else probability.shape
    mask, layer_bins = read_labels(truth, shape, prediction)
    if mask is None:
        mask = layer_mask(layer_bins, int(np.nanmax(layer_bins, initial=0)) + 2)
    if probability is None:
        probability = np.zeros(mask.shape)
    elif mask.any() and not mask.all() and np.median(probability) > 0.5:
        on = probability[mask].mean()
        off = probability[~mask].mean()
        if on < off:
            found = f"a mean of {on:.2g} on them and {off:.2g} off"
            msg = f"{prediction}: expected bright layers on a dark ground, got {found}"
            raise ValueError(msg)
    return _Image(probability, *_thin_mask(mask, layer_bins), layer_bins)


def _thin_mask(mask, layer_bins):
    """Mask with the middle of each layer only, and the median thickness of layers before [pixels].

    A mask is returned as it is if the median thickness of its layers is one pixel.
    """
    begins = mask.copy()
    begins[1:] &= ~mask[:-1]
    runs = np.cumsum(begins, axis=0) + len(mask) * np.arange(mask.shape[1])
    _, heights = np.unique(runs[mask], return_counts=True)
    thickness = np.median(heights) if heights.size else 1.0
    return (layer_mask(layer_bins, len(mask)) if thickness > 1 else mask), thickness


def _thin_edges(probability, prediction, *, suppressed, as_published):
    """Edge map of one image after non-maximum suppression; `suppressed` maps are not changed."""
    if suppressed:
        return probability
    added_curvature = CURVATURE if as_published else 0
    return suppress(probability, added_curvature=added_curvature, where=str(prediction))


def _edge_values(pair, *, edges):
    """Values above 0 in the thin edge map of one image."""
    _, prediction, truth = pair
    thin = edges(_read_image(prediction, truth).probability, prediction)
    return thin[thin > 0]


def _count_edges(pair, *, edges, thresholds, max_dist):
    """Counts of `match_counts` for one image, with values for notes.

    These are `thickness`, `levels`, `n_pixels` and `is_cut`, whether a layer leaves the map.
    `levels` are the lowest distinct values of the map above 0, at most `LEAST_LEVELS`.
    """
    _, prediction, truth = pair
    image = _read_image(prediction, truth)
    if prediction is not None:
        refuse_image(image.probability, prediction, truth)
    thin = edges(image.probability, prediction)
    counts = match_counts(thin, image.mask, thresholds, max_dist=max_dist)
    levels = np.unique(image.probability[image.probability > 0])[:LEAST_LEVELS]
    rows = np.rint(image.layer_bins[np.isfinite(image.layer_bins)])
    of_image = {
        "thickness": image.thickness,
        "levels": levels,
        "n_pixels": image.mask.size,
        "is_cut": bool(((rows < 0) | (rows >= len(image.mask))).any()),
    }
    return counts | of_image


def _pick_errors(pair, *, threshold, bin_s, **limits):
    """Table `layer_rows` of one image, the errors of its picks by layer.

    The picks are layers followed through the edge map at `threshold`. If it is None, they are the
    prediction itself.
    """
    _, prediction, truth = pair
    if threshold is None:
        picks, layer_bins = _picks_and_truth(prediction, truth, bin_s)
    else:
        image = _read_image(prediction, truth)
        layer_bins = image.layer_bins
        picks = pick_layers(image.probability, threshold=threshold, where=str(prediction))
    return layer_rows(picks, layer_bins[np.isfinite(layer_bins).any(axis=1)], **limits)


def _picks_and_truth(prediction, truth, bin_s):
    """Predicted and true layers of two files in range bins, both (layer, range_line).

    Either both are peaks of echoes, or both are interfaces. A missing prediction has no layers.
    """
    true = read_picks(truth, bin_s)
    if prediction is None:
        peak_bins = true.interface_bins if true.peak_bins is None else true.peak_bins
        return peak_bins[:0], peak_bins
    predicted = read_picks(prediction, bin_s)
    expected = f"{_lines(true)} as {truth} has"
    if _lines(predicted) != _lines(true):
        raise refusal(prediction, "size", expected, _lines(predicted))
    if predicted.slow_time is not None:
        away = np.abs(predicted.slow_time - true.slow_time).max()
        if away > SAME_TIME:
            raise refusal(prediction, "slow_time", expected, f"one {away} away")
    if predicted.peak_bins is not None and true.peak_bins is not None:
        return predicted.peak_bins, true.peak_bins
    if predicted.interface_bins is not None and true.interface_bins is not None:
        return predicted.interface_bins, true.interface_bins
    interfaces = "interfaces alone"
    peaks = "peaks of echoes, which lie below them"
    if true.peak_bins is None:
        raise refusal(prediction, "twtt", f"{interfaces}, as {truth} has, or both", peaks)
    raise refusal(prediction, "twtt", f"peaks of echoes, as {truth} has, or both", interfaces)


def _lines(picks):
    """Number and kind of the range lines of picks, in words for error messages."""
    peak_bins = picks.interface_bins if picks.peak_bins is None else picks.peak_bins
    n_lines = peak_bins.shape[1]
    return f"{n_lines} range lines {'of an image' if picks.slow_time is None else 'with times'}"


def _make_table(names, counts, score_counts, picks, *, n_bootstrap, rng):
    """Table of `score_folders` from the `match_counts` (or None) and `layer_rows` of each image.

    `score_counts` is a function from counts to edge scores. `low` and `high` are the 2.5th and
    97.5th percentiles over resamples of the images, drawn with replacement. They are NaN if there
    is only one image. The `ods` and `ois` of one image are its best F.
    """
    sums = pd.DataFrame([rows[list(SUMS)].sum() for rows in picks])
    draws = rng.integers(len(names), size=(n_bootstrap, len(names)))
    times = np.array([np.bincount(draw, minlength=len(names)) for draw in draws])
    images = _errors(sums)
    whole = _errors(sums.sum().to_frame().T)
    resampled = _errors(pd.DataFrame(times @ sums.to_numpy(), columns=sums.columns))
    if counts is not None:
        stacked = stack_counts(counts)
        resamples = with_progress(draws, unit="resample")
        scores = [score_counts(select_images(stacked, draw)) for draw in resamples]
        images = _with_edge_scores(images, [score_counts([image]) for image in counts])
        whole = _with_edge_scores(whole, [score_counts(stacked)])
        resampled = _with_edge_scores(resampled, scores)
    ends = pd.DataFrame(index=range(2))
    if len(names) > 1:
        ends = resampled.quantile([0.025, 0.975])
    table = pd.concat([images, whole, ends], ignore_index=True)
    table.insert(0, "image", [*names, "all", "low", "high"])
    return table


def _errors(sums):
    """Columns `PICK_SCORES`, from sums of `layer_rows`."""
    return errors_of_sums(sums, bin_size_m=1)[PICK_SCORES]


def _with_edge_scores(errors, scores):
    """Table of errors with edge scores in its first columns; `scores` has a dict for each row."""
    edges = pd.DataFrame(scores).rename(columns={"ods_threshold": "threshold"})
    return pd.concat([edges[[*METRICS, "threshold"]], errors], axis=1)
