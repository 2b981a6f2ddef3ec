import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.stats import ks_2samp

from evaluation.lib.speed_accuracy import quantile_distance
from snowsim.phy import draw_speckle
from snowsim.phy.speckle import METHODS, quantile_table

N_VALUES = 1_000_000
ROWS = np.ones((1000, N_VALUES // 1000))


@pytest.mark.parametrize("n_looks", [1, 10, 30])
def test_samplers_draw_what_the_sum_of_looks_draws(n_looks, rng):
    summed = draw_speckle(ROWS, n_looks, method="looks", rng=rng).ravel()
    for method in ("gamma", "quantile"):
        values = draw_speckle(ROWS, n_looks, method=method, rng=rng).ravel()
        # Two samples of n from one distribution differ by more than 1.95 sqrt(2 / n) = 2.8e-3 once
        # in 1000.
        distance = ks_2samp(summed, values, method="asymp").statistic
        assert distance < 1.95 * np.sqrt(2 / N_VALUES), method


@pytest.mark.parametrize("method", ["gamma", "quantile"])
@pytest.mark.parametrize("n_looks", [10, 100])
def test_equivalent_number_of_looks_is_that_asked_for(method, n_looks, rng):
    values = draw_speckle(ROWS.astype(np.float32), n_looks, method=method, rng=rng).astype(float)
    # The variance of n values of small kurtosis is known to sqrt((2 + 6 / M) / n) = 1.6e-3; the
    # claim is 1 %.
    assert_allclose(values.mean() ** 2 / values.var(), n_looks, rtol=0.01)
    assert_allclose(values.mean(), 1, atol=5 / np.sqrt(n_looks * N_VALUES))


@pytest.mark.parametrize(
    ("n_looks", "distance"), [(1, 1e-5), (30, 1e-5), (1000, 1e-5), (1e6, 4e-5)]
)
def test_quantiles_are_as_close_to_gamma_as_stated(n_looks, distance):
    table = quantile_table(float(n_looks)).astype(float)
    assert quantile_distance(n_looks) < distance
    # Cell means keep the mean; float32 rounds each by 6e-8, at random.
    assert_allclose(table.mean(), 1, rtol=1e-9)
    assert_allclose(table.mean() ** 2 / table.var(), n_looks, rtol=1e-4)


@pytest.mark.parametrize(
    ("method", "correlation"), [*((method, None) for method in METHODS), ("quantile", [1, 0.2])]
)
def test_same_seed_same_bytes_whatever_the_memory_order_and_speckle_scales_with_the_mean(
    method, correlation, rng
):
    mean_power = rng.uniform(0.1, 1, (30, 40)).astype(np.float32)
    options = {"n_looks": 16, "method": method, "correlation": correlation}
    given = (
        mean_power,
        np.asfortranarray(mean_power),
        4 * mean_power,
        0 * mean_power,
        mean_power.astype(float),
    )
    rows, columns, four, none, double = (
        draw_speckle(m, **options, rng=np.random.default_rng(3)) for m in given
    )
    assert (rows.dtype, double.dtype) == (np.float32, np.float64)
    assert_array_equal(rows, columns)
    assert_array_equal(four, 4 * rows)
    assert_array_equal(none, 0)
    if method == "quantile":
        assert_allclose(double, rows, rtol=1e-6)


@pytest.mark.parametrize(
    ("mean_power", "n_looks", "method", "message"),
    [
        (
            [[1.0, -1.0]],
            10,
            "gamma",
            r"mean_power must be finite, at least 0, got -1 at \(0, 1\)",
        ),
        ([[1.0]], 0, "gamma", "n_looks must be finite, at least 1, got 0"),
        ([[1.0]], 2.5, "looks", "looks needs a whole number of looks, got 2.5"),
        ([[1.0]], 2e6, "quantile", "quantile must be finite, .* at most 1e.06, got 2e.06"),
        (
            [[1.0]],
            10,
            "rice",
            "speckle method must be one of looks, gamma, quantile, got 'rice'",
        ),
    ],
)
def test_bad_input_is_refused(mean_power, n_looks, method, message, rng):
    with pytest.raises(ValueError, match=message):
        draw_speckle(mean_power, n_looks, method=method, rng=rng)
