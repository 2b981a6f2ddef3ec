"""The paper's tables from scores: Table II, SSIM against depth, and Table III with intervals."""

from functools import partial
from itertools import product

import numpy as np
import pandas as pd

from snowsim.constants import OUTPUTS
from snowsim.metrics.edges import COUNTS, METRICS, score, select_images, stack_counts

# Scores of each grid of thresholds by their names in Table III: `f` is F at the threshold that is
# best on the validation scenes.
NAMES = {
    "quantiles": {metric: metric for metric in METRICS},
    "validation": {"ods": "f"},
    "published": {metric: f"published_{metric}" for metric in METRICS},
}


def similarity_table(images):
    """Table II: minimum, mean and maximum of each metric over the images.

    `images` has columns `scene, method, rmse, psnr, ssim`; the table has columns `metric,
    statistic` and one for each method.
    """
    of_methods = images.groupby("method")[["ssim", "psnr", "rmse"]].agg(["min", "mean", "max"])
    return of_methods.T.rename_axis(["metric", "statistic"]).rename_axis(columns=None).reset_index()


def ssim_against_depth(rows, window_rows):
    """Mean SSIM of every row that all images have, and its moving average (Fig. 12).

    `rows` has columns `scene, method, range_bin, ssim`, with means of SSIM maps over range lines.
    The moving average is centred and takes `window_rows` range bins, fewer at the two ends. The
    table has columns `method, range_bin, ssim, ssim_smooth`.
    """
    common_depth = rows.groupby(["method", "scene"])["range_bin"].max().min()
    common = rows[rows["range_bin"] <= common_depth]
    mean = common.groupby(["method", "range_bin"], as_index=False)["ssim"].mean()

    def moving_average(ssim):
        return ssim.rolling(window_rows, center=True, min_periods=1).mean()

    smooth = mean.groupby("method")["ssim"].transform(moving_average)
    return mean.assign(ssim_smooth=smooth)


def counts_by_image(table, output, grid="quantiles"):
    """Counts and thresholds of one output for `snowsim.metrics.edges.score`, a dict an image.

    Images are sorted by name, thresholds ascend.
    """
    table = table[(table["output"] == output) & (table["grid"] == grid)]
    by_scene = table.sort_values(["scene", "threshold"]).groupby("scene", sort=True)
    names = ["threshold", *COUNTS]
    return [{name: group[name].to_numpy() for name in names} for _, group in by_scene]


def counts_of_runs(tables, training_sets, n_replicas, grid="quantiles"):
    """Counts of trainings for `tracker_intervals`, at the thresholds of one grid.

    `tables` holds one table for each training, all replicas of the first training set first, as
    from `lib.tracker_scores.count_edges`.
    """
    counts = {}
    for number, training_set in enumerate(training_sets):
        replicas = tables[number * n_replicas :][:n_replicas]
        for output in OUTPUTS:
            of_output = [counts_by_image(table, output, grid) for table in replicas]
            counts[training_set, output] = of_output
    return counts


def tracker_table(intervals):
    """Table III as the paper prints it, a row for each output, from `tracker_intervals`."""
    columns = intervals["training_set"] + "_" + intervals["metric"]
    wide = intervals.assign(column=columns).pivot_table(
        index="output", columns="column", values="mean"
    )
    table = wide.reindex(index=OUTPUTS, columns=columns.unique())
    return table.rename_axis(columns=None).reset_index()


def tracker_intervals(
    counts, training_sets, *, outputs=OUTPUTS, grid="quantiles", n_bootstrap, rng
):
    """Scores of every training set and output, with intervals, and differences to the first set.

    `counts` maps (training set, output) to a list over replicas of lists over images of count
    dicts; images always have the same order. Intervals are the 2.5 and 97.5 percentiles of a paired
    bootstrap: images are drawn `n_bootstrap` times with replacement, the same ones for every
    training set. They are intervals over images alone: of two trainings, draws would tell too
    little. Scores have the `NAMES` of their grid of thresholds. Columns are `output,
    training_set, metric, mean, low, high, difference, difference_low, difference_high, n_replicas,
    n_images, n_without_truth`. How images without truth count is said at
    `snowsim.metrics.edges.score`.
    """
    first = counts[training_sets[0], outputs[0]]
    n_replicas = len(first)
    n_images = len(first[0])
    n_without_truth = score(first[0])["n_without_truth"]
    draws = [rng.integers(n_images, size=n_images) for _ in range(n_bootstrap)]
    scored = partial(score, as_published=grid == "published")
    tables = []
    for output, training_set in product(outputs, training_sets):
        replicas = [stack_counts(images) for images in counts[training_set, output]]
        mean = _means(replicas, scored)
        here = _resampled(replicas, draws, scored)
        if training_set == training_sets[0]:
            base_mean = mean
            base = here
        low, high = np.percentile(here, [2.5, 97.5], axis=0)
        difference_low, difference_high = np.percentile(here - base, [2.5, 97.5], axis=0)
        rows = {
            "output": output,
            "training_set": training_set,
            "metric": METRICS,
            "mean": mean,
            "low": low,
            "high": high,
            "difference": mean - base_mean,
            "difference_low": difference_low,
            "difference_high": difference_high,
            "n_replicas": n_replicas,
            "n_images": n_images,
            "n_without_truth": n_without_truth,
        }
        tables.append(pd.DataFrame(rows))
    table = pd.concat(tables, ignore_index=True)
    return table.assign(metric=table["metric"].map(NAMES[grid])).dropna(subset="metric")


def _means(replicas, scored, images=slice(None)):
    """Mean over replicas of each of `METRICS`, on some images, (metric,)."""
    scores = [scored(select_images(replica, images)) for replica in replicas]
    return np.array([np.mean([each[metric] for each in scores]) for metric in METRICS])


def _resampled(replicas, draws, scored):
    """Means as from `_means` for each draw of images, (draw, metric)."""
    return np.array([_means(replicas, scored, images) for images in draws])
