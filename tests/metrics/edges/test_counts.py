import numpy as np
import pytest
from numpy.testing import assert_array_equal
from refusals import refusal
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import maximum_bipartite_matching
from scipy.spatial.distance import cdist
from slow_thinning import thin_slowly

from snowsim.metrics.edges import match_counts


def largest_matching(predicted, true, max_dist):
    """Size of the maximum matching of two binary maps, from the full graph."""
    a, b = np.argwhere(predicted), np.argwhere(true)
    if len(a) == 0 or len(b) == 0:
        return 0
    near = csr_matrix(cdist(a, b) <= max_dist * np.hypot(*true.shape))
    return (maximum_bipartite_matching(near, perm_type="column") >= 0).sum()


def draw_map(rng, shape):
    """A prediction in 8 steps, so that ties and plateaus occur, and a truth of some density."""
    prediction = np.round(rng.random(shape) ** rng.uniform(0.5, 3) * 8) / 8
    return prediction, rng.random(shape) < rng.uniform(0.02, 0.4)


@pytest.mark.parametrize("thin", [True, False])
def test_every_threshold_has_the_maximum_matching(rng, thin):
    # Some at values of pixels, which are then on, some between; in any order, and some twice.
    thresholds = rng.permutation(np.append(np.linspace(0, 1, 13), [0.25, 0.5]))
    for _ in range(40):
        shape = tuple(rng.integers(1, 26, size=2))
        prediction, truth = draw_map(rng, shape)
        max_dist = rng.uniform(0, 0.2)
        counts = match_counts(prediction, truth, thresholds, max_dist=max_dist, thin=thin)
        maps = [prediction >= threshold for threshold in thresholds]
        if thin:
            maps = [thin_slowly(each, early=True) for each in maps]
        assert_array_equal(counts["n_prediction"], [each.sum() for each in maps])
        assert_array_equal(
            counts["matched_truth"], [largest_matching(each, truth, max_dist) for each in maps]
        )
        assert_array_equal(counts["matched_prediction"], counts["matched_truth"])
        assert_array_equal(counts["n_truth"], truth.sum())


def test_long_chains_of_displaced_pairs_are_resolved():
    # Row pixels 0..n-1 against 1..n with a reach of one pixel: all pair up only if every pair moves
    # the same way.
    truth, prediction = np.zeros((2, 1, 400))
    truth[0, 1:301] = 1
    prediction[0, :300] = np.linspace(0.2, 0.9, 300)
    counts = match_counts(prediction, truth, [0.1], max_dist=1.5 / np.hypot(1, 400), thin=False)
    assert counts["matched_truth"] == [300]


@pytest.mark.parametrize(("line", "n_pairs"), [(202, 1), (203, 0)])  # 0.0075 * 500 = 3.75 px
def test_pixels_at_the_tolerance_pair_and_beyond_it_do_not(line, n_pairs):
    truth, prediction = np.zeros((2, 300, 400))
    truth[150, 200] = prediction[153, line] = 1
    assert match_counts(prediction, truth, [0.5])["matched_truth"] == [n_pairs]


def test_the_default_lies_within_the_error_of_the_published_code_on_every_map(shared_data):
    # Counts of py-bsds500 on 14 maps, which were scored without suppression.
    paths = sorted((shared_data / "edge_scores").glob("*.npz"))
    assert len(paths) >= 14
    for path in paths:
        with np.load(path) as file:
            reference = dict(file)
        arrays = (reference[key] for key in ("pred", "gt", "thresholds"))
        counts = match_counts(*arrays, max_dist=float(reference["max_dist"]), thin=True)
        assert_array_equal(counts["n_truth"], reference["sum_r"])
        # Both stop thinning at the same pixel; thinned until nothing changes, 7 of the 14 maps
        # have up to 11 pixels less.
        assert_array_equal(counts["n_prediction"], reference["sum_p"], err_msg=path.stem)
        # Same pixels: a maximum matching cannot be smaller; the reference's random outliers cost
        # it up to 0.6 %.
        surplus = counts["matched_truth"] - reference["count_r"]
        assert (surplus >= 0).all(), path.stem
        assert (surplus <= max(3, 0.006 * reference["gt"].sum())).all(), path.stem


GOOD = np.full((4, 5), 0.5)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"prediction": GOOD * 2.1}, r"prediction must .* at most 1, got 1.05 at \(0, 0\)"),
        ({"truth": GOOD[:3] > 0}, r"truth must hold 0 and 1 alone .*, got shape \(3, 5\)"),
        ({"thin": "full"}, "numbers in a row and thin True or False"),
        ({"max_dist": -1.0}, "max_dist must be finite, at least 0"),
    ],
)
def test_bad_input_is_refused_in_one_line(changes, message):
    arguments = {"prediction": GOOD, "truth": GOOD > 0, "thresholds": [0.5]} | changes
    with refusal(message):
        match_counts(**arguments)
