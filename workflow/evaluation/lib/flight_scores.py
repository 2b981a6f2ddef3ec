"""Scores of whole flights: what training sets are worth over flights, and scenes that they save.

Flights, generators within flights, trainings and images within both are nested and balanced: each
flight has its own generators and test scenes, and as many trainings. Of such a mixed model the
mean over flights of the flights' own means is the estimate, and its error is the spread of these
means: it holds what flights, generators, trainings and images bring, in their right proportions.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np
import pandas as pd
from scipy.optimize import isotonic_regression
from scipy.stats import t as student

from evaluation.lib.flights import CURVE_SETS, UNIVERSAL
from lib.score_tables import counts_by_image
from snowsim.metrics.comparison import METRICS, holm, replica_scores
from snowsim.metrics.edges import stack_counts

LEVEL = 0.05  # of a two-sided test
# Named before the study is run.
ENDPOINT = ("rd_pd", "rd", "ods")
# Exploratory: run less base.
PAIRS = (
    ("rd_pd", "rd"),
    ("pd", "rd"),
    ("gd", "rd"),
    ("rd_gd", "rd"),
    ("rd_pd_gd", "rd"),
    ("rd_full", "rd"),
    ("rd_own", "rd"),
    ("rd_pd_gd", "rd_pd"),
    ("rd_full_pd", "rd_full"),
    ("pd", "rd_full"),
    ("rd_pd", "rd_full"),
    ("rd_pd", "rd_own"),
    (UNIVERSAL, "rd"),
    (UNIVERSAL, "rd_pd"),
    (UNIVERSAL, "rd_full"),
)
ON_CURVE = (*CURVE_SETS, UNIVERSAL)


def pairs_of(curve):
    """`PAIRS`, and drawn scenes by the picks of as many train scenes as a learning curve has."""
    if not curve:
        return PAIRS
    n = max(curve)
    return (*PAIRS, (f"pd_of_{n}", "rd"), (f"rd_pd_of_{n}", "rd"))


def stacked_runs(table):
    """Counts of a flight's trainings by run, a list over replicas, stacked over images.

    `table` has columns `run, replica, scene, threshold` and the counts.
    """
    found = {}
    for (run, _), rows in table.groupby(["run", "replica"], sort=True):
        found.setdefault(run, []).append(stack_counts(counts_by_image(rows)))
    return found


def score_rows(flight, runs):
    """Scores of every training of a flight: rows of `flight, run, replica` and `METRICS`."""
    rows = []
    for run, replicas in runs.items():
        for replica, scores in enumerate(replica_scores(replicas)):
            row = {"flight": flight, "run": run, "replica": replica}
            rows.append(row | dict(zip(METRICS, scores, strict=True)))
    return pd.DataFrame(rows)


@dataclass(frozen=True)
class Errors:
    """What one flight's difference owes to its trainings and images, standard errors."""

    of_trainings: float
    of_images: float


def errors_in_flight(replicas, base_replicas, *, n_bootstrap, rng):
    """`Errors` of a flight's difference, by metric, between runs of stacked counts."""
    differences = replica_scores(replicas) - replica_scores(base_replicas)
    n = len(differences)
    of_trainings = np.full(len(METRICS), np.nan)
    if n > 1:
        of_trainings = differences.std(axis=0, ddof=1) / np.sqrt(n)
    n_images = len(replicas[0]["n_truth"])
    resampled = []
    for _ in range(n_bootstrap):
        images = rng.integers(n_images, size=n_images)
        here = replica_scores(replicas, images).mean(axis=0)
        resampled.append(here - replica_scores(base_replicas, images).mean(axis=0))
    of_images = np.std(resampled, axis=0, ddof=1)
    pairs = zip(of_trainings, of_images, strict=True)
    return {metric: Errors(*pair) for metric, pair in zip(METRICS, pairs, strict=True)}


def mean_over_flights(differences):
    """Mean of the flights' differences, its 95 % interval and test: Student's t over flights.

    Exact where differences are normal; one flight leaves interval and test unknown (NaN).
    """
    differences = np.asarray(differences, dtype=float)
    n = differences.size
    mean = differences.mean()
    spread = differences.std(ddof=1) if n > 1 else np.nan
    error = spread / np.sqrt(n)
    reach = student.ppf(1 - LEVEL / 2, n - 1) * error
    p_value = 1.0  # also of scores that are all the same
    if mean != 0:
        with np.errstate(divide="ignore"):
            p_value = 2 * student.sf(abs(mean) / error, n - 1)
    return {
        "difference": mean,
        "low": mean - reach,
        "high": mean + reach,
        "p_value": p_value,
        "n_higher": int((differences > 0).sum()),
        "n_flights": n,
        "flight_spread": spread,
    }


def compare_over_flights(scores, errors, pairs):
    """Worth of runs over flights: a row per pair and metric, the endpoint first.

    `scores` of `score_rows`; `errors` maps (flight, run, base) to `errors_in_flight`, and flights
    that have not both are left out, and pairs that no flight has. Columns
    `run, base, metric, family`, means, those of `mean_over_flights`, `p_holm` within the family,
    and what parts of `flight_spread` there are: `training_error` and `image_error` of one flight,
    `between_flights` what is left, of flights and generators.
    """
    means = scores.groupby(["run", "flight"])[list(METRICS)].mean()
    rows = []
    had = [pair for pair in pairs if pair[0] in set(scores["run"])]
    for (run, base), metric in product(had, METRICS):
        differences = (means.loc[run, metric] - means.loc[base, metric]).dropna()
        here = [errors[flight, run, base][metric] for flight in differences.index]
        is_endpoint = (run, base, metric) == ENDPOINT
        family = "endpoint" if is_endpoint else f"exploratory, {metric}"
        row = {"run": run, "base": base, "metric": metric, "family": family}
        row |= {"mean": means.loc[run, metric].mean(), "base_mean": means.loc[base, metric].mean()}
        row |= mean_over_flights(differences)
        rows.append(row | _parts(row["flight_spread"], here))
    table = pd.DataFrame(rows)
    corrected = table.groupby("family")["p_value"].transform(holm)
    table.insert(table.columns.get_loc("p_value") + 1, "p_holm", corrected)
    is_endpoint = table["family"] == "endpoint"
    return pd.concat([table[is_endpoint], table[~is_endpoint]])


def _parts(spread, errors):
    """Parts of the spread of flights' differences, root mean squares over flights."""
    trainings = np.sqrt(np.mean([error.of_trainings**2 for error in errors]))
    images = np.sqrt(np.mean([error.of_images**2 for error in errors]))
    left = spread**2 - np.nan_to_num(trainings) ** 2 - images**2
    return {
        "training_error": trainings,
        "image_error": images,
        "between_flights": np.sqrt(np.maximum(left, 0)),
    }


def curve_scores(runs, numbers, images, replicas):
    """Fused ODS of `ON_CURVE` on some images, means of some replicas, (set, number).

    NaN where the scenes held too little to draw from; the universal tracker's is the same at every
    number.
    """
    ods = METRICS.index("ods")
    scores = np.full((len(ON_CURVE), len(numbers)), np.nan)
    scores[-1] = replica_scores(runs[UNIVERSAL], images)[:, ods].mean()
    for (row, name), (column, n) in product(enumerate(CURVE_SETS), enumerate(numbers)):
        trained = runs.get(f"{name}_of_{n}")
        if trained is None:
            continue
        chosen = [trained[replica] for replica in replicas]
        scores[row, column] = replica_scores(chosen, images)[:, ods].mean()
    return scores


def resampled_curves(runs, numbers, *, n_bootstrap, rng):
    """`curve_scores` of resampled images and trainings, (draw, set, number).

    One training fewer is drawn than there are, so that their variance comes out right also where
    they are few (Rao & Wu 1988, J. Am. Stat. Assoc. 83, 231-241).
    """
    first = runs[f"rd_of_{numbers[0]}"]
    n_images = len(first[0]["n_truth"])
    n_replicas = len(first)
    drawn = []
    for _ in range(n_bootstrap):
        images = rng.integers(n_images, size=n_images)
        replicas = rng.integers(n_replicas, size=max(n_replicas - 1, 1))
        drawn.append(curve_scores(runs, numbers, images, replicas))
    return np.array(drawn)


def scenes_for(score, numbers, curve):
    """Annotated scenes with which a learning curve comes to a score.

    The curve is made to rise (isotonic regression) and is straight between `numbers` in their
    logarithm. Infinite for a score above its end; the least of `numbers` for one below its start;
    NaN for none.
    """
    if np.isnan(score):
        return np.nan
    rising = isotonic_regression(curve).x
    reached = np.flatnonzero(rising >= score)
    if reached.size == 0:
        return np.inf
    after = reached[0]
    if after == 0:
        return float(numbers[0])
    before = after - 1
    share = (score - rising[before]) / (rising[after] - rising[before])
    logarithm = np.log(numbers)
    return float(np.exp(logarithm[before] + share * (logarithm[after] - logarithm[before])))


def scenes_saved(curves, numbers):
    """Scenes of `ON_CURVE` that RD needs beyond their own to score alike, (set, number).

    Of RD itself NaN. The universal tracker has no scenes of its own.
    """
    base = CURVE_SETS.index("rd")
    saved = np.empty_like(curves)
    for row, curve in enumerate(curves):
        saved[row] = [scenes_for(score, numbers, curves[base]) for score in curve]
    saved[base] = np.nan
    saved[:-1] -= numbers
    return saved


def curve_table(flight, runs, few, *, n_bootstrap, rng):
    """Learning curve of a flight, with 95 % intervals over its trainings and images.

    Rows of `flight, training_set, n_scenes, ods, low, high, saved, saved_low, saved_high`; saved
    scenes are infinite where RD does not come to the score. `few` says, by `n_scenes`, of what
    `radiometry` drawn scenes could be. The universal tracker has one row, of no scenes.
    """
    numbers = list(few["n_scenes"])
    n_replicas = len(runs[f"rd_of_{numbers[0]}"])
    means = curve_scores(runs, numbers, slice(None), range(n_replicas))
    drawn = resampled_curves(runs, numbers, n_bootstrap=n_bootstrap, rng=rng)
    saved = scenes_saved(means, numbers)
    saved_drawn = np.array([scenes_saved(curves, numbers) for curves in drawn])
    low, high = np.percentile(drawn, [50 * LEVEL, 100 - 50 * LEVEL], axis=0)
    # Not interpolated: infinite numbers have no mean.
    ends = {"q": [50 * LEVEL, 100 - 50 * LEVEL], "axis": 0, "method": "nearest"}
    saved_low, saved_high = np.percentile(saved_drawn, **ends)
    rows = []
    for (row, name), (column, n) in product(enumerate(ON_CURVE), enumerate(numbers)):
        if name == UNIVERSAL and column:
            continue
        at = (row, column)
        rows.append(
            {
                "flight": flight,
                "training_set": name,
                "n_scenes": 0 if name == UNIVERSAL else n,
                "ods": means[at],
                "low": low[at],
                "high": high[at],
                "saved": saved[at],
                "saved_low": saved_low[at],
                "saved_high": saved_high[at],
                "n_replicas": len(runs[UNIVERSAL]) if name == UNIVERSAL else n_replicas,
                "radiometry": "" if name == UNIVERSAL else few["radiometry"].iloc[column],
            }
        )
    return pd.DataFrame(rows)
