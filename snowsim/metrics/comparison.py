"""Differences between the edge scores of two training sets, paired by image and by replica."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.optimize import brentq
from scipy.stats import t as student

from snowsim.metrics.edges import score, stack_counts

METRICS = ("ods", "ois", "ap")
LEVEL = 0.05  # significance level of two-sided tests
POWER = 0.8  # probability with which a `detectable` difference is found
MOST_SEEDS = 100


def compare(counts, pairs, *, n_bootstrap, rng):
    """Table of differences between edge scores, a row for each pair (name, base) and metric.

    `counts` maps each name to a list over replicas of lists over images of count dicts. Replicas
    and images of all names have the same order: replica r of every name began from the same
    weights. `n_bootstrap` resamples of the images, the same for every name, give the error that
    comes from the choice of images. Columns are `name, base, metric, mean, base_mean`, those of
    `paired_difference`, and `bootstrap_low, bootstrap_high`: percentiles over resamples of images
    and replicas at once, which are too narrow where replicas are few. `p_holm` is `p_value`
    corrected for the number of rows.
    """
    stacked = {
        name: [stack_counts(images) for images in replicas] for name, replicas in counts.items()
    }
    n_images = next(iter(stacked.values()))[0]["n_truth"].shape[0]
    draws = rng.integers(n_images, size=(n_bootstrap, n_images))
    places = rng.random((n_bootstrap, max(map(len, stacked.values()))))
    points = {name: replica_scores(replicas) for name, replicas in stacked.items()}
    resampled = {
        name: np.array([replica_scores(replicas, images) for images in draws])
        for name, replicas in stacked.items()
    }
    rows = []
    for name, base in pairs:
        for index, metric in enumerate(METRICS):
            here = points[name][:, index]
            there = points[base][:, index]
            differences = resampled[name][..., index] - resampled[base][..., index]
            image_error = float(np.std(differences.mean(axis=1), ddof=1))
            replicas = (places[:, : here.size] * here.size).astype(int)
            both = np.take_along_axis(differences, replicas, axis=1).mean(axis=1)
            low, high = np.percentile(both, [50 * LEVEL, 100 - 50 * LEVEL])
            row = {"name": name, "base": base, "metric": metric}
            row |= {"mean": here.mean(), "base_mean": there.mean()}
            row |= paired_difference(here - there, image_error, n_images)
            row |= {"bootstrap_low": low, "bootstrap_high": high}
            rows.append(row)
    table = pd.DataFrame(rows)
    after_p_value = table.columns.get_loc("p_value") + 1
    table.insert(after_p_value, "p_holm", holm(table["p_value"]))
    return table


def paired_difference(differences, image_error, n_images):
    """Mean of paired differences (replica,), its 95 % interval and test, and what can be resolved.

    `image_error` is the standard error of the mean that comes from the choice of images. Returns

    - `difference`, `low`, `high`: the mean and its interval;
    - `p_value`: two-sided, the level at which the interval just reaches zero;
    - `outcome`: `higher`, `lower` or `not resolved`;
    - `seed_spread`: standard deviation between replicas, NaN for one replica;
    - `detectable`: the smallest true difference that is found in 80 % of cases;
    - `seeds_to_resolve`: number of replicas that would find a true difference of this size in 80 %
      of cases, -1 if more than a hundred are needed;
    - `image_error`, `n_replicas`, `n_images`.

    The choice of seeds and the choice of images err independently: ``reach^2 = (t_{n-1} s)^2 / n +
    (t_{images-1} e)^2``, where t are 0.975 quantiles of Student's t, or ``t_0.975 + t_0.8`` for the
    detectable difference. Each part has its own degrees of freedom, so that two seeds do not count
    as more; the interval covers a little more than 95 %. The error of a single replica is that of
    images alone.
    """
    differences = np.asarray(differences, dtype=float)
    n = differences.size
    mean = float(differences.mean())
    spread = float(differences.std(ddof=1)) if n > 1 else float("nan")
    errors = Errors(spread, image_error, n_images)
    reach = float(errors.reach([1 - LEVEL / 2], n))
    outcome = "higher" if mean > 0 else "lower"
    if abs(mean) <= reach:
        outcome = "not resolved"
    return {
        "difference": mean,
        "low": mean - reach,
        "high": mean + reach,
        "p_value": _p_value(abs(mean), errors, n),
        "outcome": outcome,
        "seed_spread": spread,
        "image_error": image_error,
        "detectable": float(errors.reach([1 - LEVEL / 2, POWER], n)),
        "seeds_to_resolve": _seeds_to_resolve(abs(mean), errors),
        "n_replicas": n,
        "n_images": n_images,
    }


def holm(p_values):
    """P values of several tests, corrected for their number: Holm (1979), Scand. J. Stat. 6, 65-70.

    The k-th smallest of m values, k from 0, is multiplied by m - k. It then becomes at most 1, and
    at least what a smaller value has become.
    """
    p_values = np.asarray(p_values, dtype=float)
    order = np.argsort(p_values)
    n_left = np.arange(p_values.size, 0, -1)
    at_least = np.maximum.accumulate(p_values[order] * n_left)
    corrected = np.empty_like(p_values)
    corrected[order] = np.minimum(at_least, 1)
    return corrected


@dataclass(frozen=True)
class Errors:
    """Errors of the mean of paired differences: spread between replicas, and error of images.

    `spread` is NaN where it is unknown, that is, for one replica.
    """

    spread: float
    image_error: float
    n_images: int

    def reach(self, probabilities, n):
        """Half width of an interval for `n` replicas: a sum of t quantiles times the error."""

        def quantiles(freedom):
            return sum(student.ppf(probability, freedom) for probability in probabilities)

        n = np.asarray(n)
        of_seeds = quantiles(np.maximum(n - 1, 1)) * np.nan_to_num(self.spread) / np.sqrt(n)
        of_images = quantiles(max(self.n_images - 1, 1)) * self.image_error
        return np.hypot(np.where(n > 1, of_seeds, 0.0), of_images)


def _p_value(difference, errors, n):
    """Level at which the interval of a difference just reaches zero."""

    def beyond(level):
        return float(errors.reach([1 - level / 2], n)) - difference

    least = 1e-12
    if beyond(least) < 0:
        return least
    if difference == 0:
        return 1.0
    return float(brentq(beyond, least, 1))


def _seeds_to_resolve(difference, errors):
    """Least number of replicas, from 2 on, that resolves a difference; -1 if there is none."""
    if not np.isfinite(errors.spread):
        return -1
    n = np.arange(2, MOST_SEEDS + 1)
    enough = errors.reach([1 - LEVEL / 2, POWER], n) <= difference
    return int(n[np.argmax(enough)]) if enough.any() else -1


def replica_scores(replicas, images=slice(None)):
    """`METRICS` of each replica's stacked counts, on some images, (replica, metric)."""
    rows = []
    for replica in replicas:
        scores = score({name: values[images] for name, values in replica.items()})
        rows.append([scores[metric] for metric in METRICS])
    return np.array(rows)
