import numpy as np
import pytest
from numpy.testing import assert_allclose
from refusals import refusal

from snowsim.metrics.edges import precision_recall, score, stack_counts


def counts_of(matched, n_truth, n_prediction):
    """Counts of one image; matched and n_prediction by threshold."""
    matched = np.array(matched)
    n = {"n_truth": np.full(matched.size, n_truth), "n_prediction": np.array(n_prediction)}
    return {"matched_truth": matched, "matched_prediction": matched, **n}


TWO_IMAGES = [counts_of([8, 6, 2], 10, [20, 8, 2]), counts_of([10, 4, 1], 10, [10, 4, 1])]


def test_ods_ois_ap_and_the_pooled_curve_follow_their_definitions():
    scores = score(TWO_IMAGES, thresholds=[0.2, 0.5, 0.8])
    # Pooled: 18 of 20 true, 18 of 30 predicted: P 0.6, R 0.9; then P 10/12, R 0.5; then P 1, R
    # 0.15.
    assert_allclose(scores["ods"], 2 * 0.6 * 0.9 / 1.5)
    assert scores["ods_index"] == 0
    assert scores["ods_threshold"] == 0.2
    # Own best: image one at the middle threshold (F 2/3 over 8/15), image two at the lowest: 16 of
    # 20, 16 of 18.
    assert_allclose(scores["ois"], 2 * 16 / (20 + 18))
    # Recalls 0.15, 0.5, 0.9: trapezia of linear pieces, summed at hundredths.
    recall = np.arange(15, 91) / 100
    precision = np.interp(recall, [0.15, 0.5, 0.9], [1, 10 / 12, 0.6])
    assert_allclose(scores["ap"], precision.sum() / 100)
    assert scores["n_images"] == 2
    curve = precision_recall(TWO_IMAGES)
    assert_allclose(curve["precision"], [0.6, 10 / 12, 1])
    assert_allclose(curve["recall"], [0.9, 0.5, 0.15])
    assert_allclose(curve["f"].max(), scores["ods"])


def test_of_equal_recalls_the_lowest_threshold_counts_and_precision_is_taken_at_101_recalls():
    # Precision = recall from 0 to 1: sum of 0, 0.01 ... 1 over 100.
    both = [counts_of([10, 0], 10, [10, 0])]
    assert score(both)["ods"] == score(both)["ois"] == 1
    assert_allclose(score(both)["ap"], 50.5 / 100)
    assert score([counts_of([5, 5], 10, [10, 5])])["ap"] == 0
    # Recall 0.5 twice, precision 0.25 at the lower threshold.
    tied = [counts_of([5, 5, 1], 10, [20, 5, 1])]
    recall = np.arange(10, 51) / 100
    assert_allclose(score(tied)["ap"], (1 - (recall - 0.1) / 0.4 * 0.75).sum() / 100)


def test_images_without_truth_are_counted_and_cost_false_positives():
    empty = counts_of([0, 0, 0], 0, [5, 3, 1])
    with_empty, without = score([*TWO_IMAGES, empty]), score(TWO_IMAGES)
    assert with_empty["n_without_truth"] == 1
    assert without["n_without_truth"] == 0
    # Its false positive at the highest threshold joins OIS: 16 of 20 true, 16 of 18 + 1 predicted.
    assert_allclose(with_empty["ois"], 2 * 16 / (20 + 19))
    # As the published code counts, those at the lowest, 5.
    published = score([*TWO_IMAGES, empty], as_published=True)
    assert_allclose(published["ois"], 2 * 16 / (20 + 23))
    assert with_empty["ods"] < without["ods"]
    alone = score([empty])
    assert alone["ods"] == alone["ois"] == alone["ap"] == 0


def test_shards_pool_to_the_same_scores_in_any_order():
    whole = score(TWO_IMAGES)
    assert score(TWO_IMAGES[::-1]) == whole
    shards = [stack_counts([image]) for image in TWO_IMAGES]
    pooled = {name: np.concatenate([shard[name] for shard in shards]) for name in shards[0]}
    assert score(pooled) == whole


@pytest.mark.parametrize(
    ("change", "thresholds", "message"),
    [
        ({"matched_truth": [60, 40]}, None, r"n_truth less matched_truth must be .*, got -10"),
        ({}, [0.8, 0.3], "thresholds must not decrease"),
        ({}, [0.5], "at least one image and as many thresholds as they have"),
    ],
)
def test_counts_that_do_not_fit_are_refused(change, thresholds, message):
    counts = {"matched_truth": [50, 40], "n_truth": [50, 50]}
    counts |= {"matched_prediction": [50, 40], "n_prediction": [60, 40]}
    with refusal(message):
        score([counts | change], thresholds)
