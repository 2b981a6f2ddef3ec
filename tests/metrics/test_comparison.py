import numpy as np
from edge_counts import image_counts
from numpy.testing import assert_allclose
from scipy.stats import norm
from scipy.stats import t as student

from snowsim.metrics.comparison import compare, holm, paired_difference


def test_one_replica_leaves_the_images_error_alone():
    result = paired_difference([0.02], image_error=0.01, n_images=61)
    assert_allclose([result["low"], result["high"]], 0.02 + 0.01 * student.ppf([0.025, 0.975], 60))
    assert result["outcome"] == "not resolved"
    assert np.isnan(result["seed_spread"])
    assert result["seeds_to_resolve"] == -1
    # 50 errors away: less than what is told.
    assert paired_difference([0.5], image_error=0.01, n_images=61)["p_value"] == 1e-12


def test_without_image_error_it_is_the_paired_t_test():
    differences = np.array([0.01, 0.02, 0.06, 0.03])
    result = paired_difference(differences, image_error=0.0, n_images=60)
    error = differences.std(ddof=1) / 2
    assert_allclose(result["high"] - result["difference"], student.ppf(0.975, 3) * error)
    assert_allclose(result["p_value"], 2 * student.sf(0.03 / error, 3))
    assert_allclose(result["detectable"], (student.ppf(0.975, 3) + student.ppf(0.8, 3)) * error)


def typical(n_replicas, spread):
    """Differences of this standard deviation, as even as those of so many replicas can be."""
    ranks = norm.ppf((np.arange(n_replicas) + 0.5) / n_replicas)
    return spread / ranks.std(ddof=1) * ranks


def test_errors_of_seeds_and_of_images_add_in_quadrature():
    differences = [0.01, 0.02, 0.06, 0.03]
    of_seeds, of_images, of_both = (
        np.diff([result["low"], result["high"]])
        for result in (
            paired_difference(differences, 0.0, 60),
            paired_difference([0.03], 0.01, 60),
            paired_difference(differences, 0.01, 60),
        )
    )
    assert_allclose(of_both, np.hypot(of_seeds, of_images))


def test_as_many_seeds_as_stated_resolve_a_difference_and_one_fewer_does_not():
    differences = np.array([0.012, -0.001, 0.009, 0.004])
    result = paired_difference(differences, image_error=0.001, n_images=60)
    n = result["seeds_to_resolve"]
    assert n > 4
    enough, too_few = (
        paired_difference(typical(k, result["seed_spread"]), 0.001, 60) for k in (n, n - 1)
    )
    assert enough["detectable"] <= result["difference"] < too_few["detectable"]
    # No number of seeds resolves what the images hide.
    assert (
        paired_difference([0.001, 0.002, 0.0], image_error=0.01, n_images=60)["seeds_to_resolve"]
        == -1
    )


def test_a_set_compared_with_itself_does_not_differ_and_a_better_one_does(rng):
    worse, better = ([image_counts(share, 30, rng=rng) for _ in range(3)] for share in (0.7, 0.8))
    pairs = [("a", "a"), ("b", "a")]
    table = compare({"a": worse, "b": better}, pairs, n_bootstrap=100, rng=rng).set_index(
        ["name", "metric"]
    )
    same = table.loc[("a", "ods")]
    assert (same["difference"], same["detectable"], same["outcome"]) == (0, 0, "not resolved")
    assert same["p_value"] == 1
    assert_allclose(table["p_holm"], holm(table["p_value"]))
    ods = table.loc[("b", "ods")]
    assert ods["outcome"] == "higher"
    # Best of three thresholds, each a mean of 6000 trials: 0.006 and some.
    assert_allclose(ods["difference"], 0.1, atol=0.02)
    # An image is 200 trials at one of three thresholds: sqrt(2 x 0.7 x 0.3 / 200 / 30) for a
    # replica, / sqrt(3) for 3.
    assert_allclose(ods["image_error"], np.sqrt(2 * 0.21 / 200 / 30 / 3), rtol=0.5)


def test_holm_s_correction_is_the_step_down_procedure(rng):
    p_values = rng.uniform(0, 0.06, 12)
    corrected = holm(p_values)
    for level in rng.uniform(0, 1, 200):
        # Reject in order while p_(k) <= level / (m - k), and stop at the first that is not.
        rejected = np.zeros(12, dtype=bool)
        for k, test in enumerate(np.argsort(p_values)):
            if p_values[test] > level / (12 - k):
                break
            rejected[test] = True
        np.testing.assert_array_equal(corrected <= level, rejected)
    assert holm([0.03, 0.6])[1] == 0.6
    assert holm([0.7, 0.8]).tolist() == [1, 1]


def test_the_bootstrap_takes_in_trainings_and_images(rng):
    images, better = (image_counts(share, 40, rng=rng) for share in (0.6, 0.7))
    counts = {"a": [images, images], "b": [images, better]}
    table = compare(counts, [("b", "a")], n_bootstrap=400, rng=rng).set_index("metric")
    row = table.loc["ods"]
    # Replica 0 is the same in both: a quarter of the resamples draws it twice and finds nothing.
    assert row["bootstrap_low"] <= 0 <= row["bootstrap_high"]
    assert row["bootstrap_low"] <= row["difference"] <= row["bootstrap_high"]
    table = compare({"a": [images], "b": [better]}, [("b", "a")], n_bootstrap=400, rng=rng)
    alone = table.set_index("metric").loc["ods"]
    # One replica leaves the images' error, Gaussian or not, to a tenth; 3.92 of it wide.
    width = alone["bootstrap_high"] - alone["bootstrap_low"]
    assert_allclose(width, 3.92 * alone["image_error"], rtol=0.3)
