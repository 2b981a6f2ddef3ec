"""Per-image scores to the paper's tables: Table II, SSIM against depth, Table III with intervals."""

import numpy as np
import pandas as pd

from snowsim.metrics.edges import score, stack_counts

OUTPUTS = ("side_1", "side_2", "side_3", "side_4", "side_5", "fuse")
COUNTS = ("matched_truth", "n_truth", "matched_prediction", "n_prediction")


def similarity_table(images):
    """Table II: minimum, mean and maximum of each metric over the images, a column a method.

    Parameters
    ----------
    images : pandas.DataFrame
        Columns `scene, method, rmse, psnr, ssim`, a row per image and method.

    Returns
    -------
    pandas.DataFrame
        Columns `metric, statistic` and one per method, methods in alphabetical order.
    """
    rows = [
        {
            "metric": metric,
            "statistic": statistic,
            **{method: getattr(group[metric], statistic)() for method, group in images.groupby("method")},
        }
        for metric in ("ssim", "psnr", "rmse")
        for statistic in ("min", "mean", "max")
    ]
    return pd.DataFrame(rows)


def ssim_against_depth(rows, window_rows):
    """Mean SSIM of every row over the depth that all images share, and its moving average (Fig. 12).

    Parameters
    ----------
    rows : pandas.DataFrame
        Columns `scene, method, range_bin, ssim`: the row means of each image's SSIM map.
    window_rows : int
        Length of the centred moving average [range bins]; fewer rows at the two ends.

    Returns
    -------
    pandas.DataFrame
        Columns `method, range_bin, ssim, ssim_smooth`.
    """
    common_depth = rows.groupby(["method", "scene"])["range_bin"].max().min()
    common = rows[rows["range_bin"] <= common_depth]
    mean = common.groupby(["method", "range_bin"], as_index=False)["ssim"].mean()
    smooth = mean.groupby("method")["ssim"].transform(
        lambda ssim: ssim.rolling(window_rows, center=True, min_periods=1).mean()
    )
    return mean.assign(ssim_smooth=smooth)


def counts_by_image(table):
    """One output's per-threshold counts as the list that `snowsim.metrics.edges.score` takes, images sorted by name."""
    ordered = table.sort_values(["scene", "threshold"])
    return [{name: group[name].to_numpy() for name in COUNTS} for _, group in ordered.groupby("scene", sort=True)]


def counts_of_runs(tables, training_sets, n_replicas, outputs=OUTPUTS):
    """Counts of several trainings, as `tracker_intervals` takes them.

    Parameters
    ----------
    tables : sequence of pandas.DataFrame
        Counts of every training, columns `scene, output, threshold` and the counts; replicas of the first training set
        first.
    training_sets : sequence of str
    n_replicas : int
        Trainings of each set.
    outputs : sequence of str

    Returns
    -------
    dict
        (training set, output) -> list over replicas of lists over images of count dicts.
    """
    counts = {(training_set, output): [] for training_set in training_sets for output in outputs}
    keys = [training_set for training_set in training_sets for _ in range(n_replicas)]
    for training_set, table in zip(keys, tables, strict=True):
        for output in outputs:
            counts[training_set, output].append(counts_by_image(table[table["output"] == output]))
    return counts


def tracker_table(intervals):
    """Table III in the paper's layout from the long table of `tracker_intervals`: a row per output."""
    wide = intervals.assign(column=intervals["training_set"] + "_" + intervals["metric"])
    columns = list(dict.fromkeys(wide["column"]))
    table = wide.pivot_table(index="output", columns="column", values="mean").reindex(index=OUTPUTS, columns=columns)
    return table.rename_axis(columns=None).reset_index()


def tracker_intervals(counts, training_sets, *, outputs=OUTPUTS, n_bootstrap, rng):
    """Scores of every training set and output, with intervals, and their differences to the first set.

    Parameters
    ----------
    counts : dict
        (training set, output) -> list over replicas of lists over images of count dicts; images in one order.
    training_sets : sequence of str
        The first is the one others are compared with.
    outputs : sequence of str
    n_bootstrap : int
        Resamples of the paired bootstrap: images, and replicas, are drawn with replacement, the same images for
        every training set.
    rng : numpy.random.Generator

    Returns
    -------
    pandas.DataFrame
        Columns `output, training_set, metric, mean, low, high, difference, difference_low, difference_high,
        n_replicas, n_images, n_without_truth`; intervals are the 2.5 and 97.5 percentiles. Images without truth put
        their false positives into OIS at the lowest threshold, see `snowsim.metrics.edges.score`.
    """
    stacked = {key: [stack_counts(images) for images in replicas] for key, replicas in counts.items()}
    first = counts[training_sets[0], outputs[0]]
    n_replicas, n_images = len(first), len(first[0])
    n_without_truth = score(first[0])["n_without_truth"]
    draws = [
        (rng.integers(n_replicas, size=n_replicas), rng.integers(n_images, size=n_images)) for _ in range(n_bootstrap)
    ]
    rows = []
    for output in outputs:
        point = {s: _mean_scores(stacked[s, output]) for s in training_sets}
        resampled = {
            s: [
                _mean_scores([_taken(stacked[s, output][replica], images) for replica in replicas])
                for replicas, images in draws
            ]
            for s in training_sets
        }
        for training_set in training_sets:
            for metric in ("ods", "ois", "ap"):
                here = np.array([scores[metric] for scores in resampled[training_set]])
                base = np.array([scores[metric] for scores in resampled[training_sets[0]]])
                low, high = np.percentile(here, [2.5, 97.5])
                difference_low, difference_high = np.percentile(here - base, [2.5, 97.5])
                rows.append(
                    {
                        "output": output,
                        "training_set": training_set,
                        "metric": metric,
                        "mean": point[training_set][metric],
                        "low": low,
                        "high": high,
                        "difference": point[training_set][metric] - point[training_sets[0]][metric],
                        "difference_low": difference_low,
                        "difference_high": difference_high,
                        "n_replicas": n_replicas,
                        "n_images": n_images,
                        "n_without_truth": n_without_truth,
                    }
                )
    return pd.DataFrame(rows)


def _taken(stacked, images):
    """Counts of these images, in this order, of counts stacked over all."""
    return {name: values[images] for name, values in stacked.items()}


def _mean_scores(replicas):
    scores = [score(stacked) for stacked in replicas]
    return {metric: float(np.mean([one[metric] for one in scores])) for metric in ("ods", "ois", "ap")}
