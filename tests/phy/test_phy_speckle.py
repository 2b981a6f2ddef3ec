import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from refusals import refusal
from scipy.special import gammainc, ndtr

from snowsim.phy import draw_speckle
from snowsim.phy.speckle import METHODS, MOST_LAGS, QUANTILE_REACH, normal_quantiles

# A Hann window at 0.58 and 0.31 of its resolution, a slow decay, one that turns negative, one lag
# far off, and one that no process has.
SHAPES = [
    (1, 0.157, 0.003),
    (1, 0.66, 0.18, 0.02),
    tuple(0.6 ** np.arange(9)),
    (1, -0.2, 0.05),
    (1, 0, 0, 0, 0.25),
    (1, 0.54),
]


def correlated(shape, n_looks, correlation, rng):
    ones = np.ones(shape, dtype=np.float32)
    power = draw_speckle(ones, n_looks, method="quantile", correlation=correlation, rng=rng)
    return power.astype(float)


@pytest.mark.parametrize(
    ("n_looks", "distance"), [(1, 1e-5), (16, 1e-5), (1000, 1e-5), (1e6, 4e-5)]
)
def test_quantiles_are_as_close_to_gamma_as_stated(n_looks, distance):
    quantile = normal_quantiles(float(n_looks)).astype(float)
    normal = np.linspace(-QUANTILE_REACH, QUANTILE_REACH, quantile.size)
    assert_allclose(gammainc(n_looks, n_looks * quantile), ndtr(normal), rtol=0, atol=distance)


@pytest.mark.parametrize("n_looks", [1, 16])
@pytest.mark.parametrize("correlation", SHAPES)
def test_correlation_drawn_is_that_asked_for(correlation, n_looks, rng):
    asked = np.pad(correlation, (0, MOST_LAGS + 1 - len(correlation)))
    deviation = correlated((300, 4000), n_looks, correlation, rng) - 1
    products = (deviation[: 300 - lag] * deviation[lag:] for lag in range(MOST_LAGS + 1))
    # Range lines are independent.
    by_line = n_looks * np.array([product.mean(axis=0) for product in products])
    measured = by_line.mean(axis=1)
    scatter = by_line.std(axis=1) / np.sqrt(4000)
    # Of 400 values in all, 4.5 errors are exceeded once in 400. Two terms for the law of a look
    # leave 5e-3; spectra that turn negative are lost in part: 6e-3, and 0.03 of the one that no
    # process has.
    allowed = 0.03 if correlation == (1, 0.54) else 6e-3
    assert np.all(np.abs(measured - asked) < 4.5 * scatter + allowed)
    assert scatter[1:].max() < 3e-3


def test_edges_are_as_anywhere_else(rng):
    n_lines = 100_000
    deviation = correlated((12, n_lines), 5, [1, 0.4, 0.1], rng) - 1
    # Variances of Gamma(5) to sqrt((2 + 6 / 5) / n): four of those.
    variance = (deviation**2).mean(axis=1)
    assert_allclose(5 * variance, 1, atol=4 * np.sqrt(3.2 / n_lines))
    across = np.corrcoef(deviation[:, :-1].ravel(), deviation[:, 1:].ravel())[0, 1]
    assert abs(across) < 4 * 1.5 / np.sqrt(12 * n_lines)  # range lines stay independent


@pytest.mark.parametrize(
    ("method", "correlation"), [*((method, None) for method in METHODS), ("quantile", [1, 0.2])]
)
def test_same_seed_same_bytes_whatever_the_memory_order_and_speckle_scales_with_the_mean(
    method, correlation, rng
):
    mean_power = rng.uniform(0.1, 1, (30, 40)).astype(np.float32)

    def speckled(mean_power):
        options = {"n_looks": 16, "method": method, "correlation": correlation}
        return draw_speckle(mean_power, **options, rng=np.random.default_rng(3))

    rows = speckled(mean_power)
    assert rows.dtype == np.float32
    assert_array_equal(speckled(np.asfortranarray(mean_power)), rows)
    assert_array_equal(speckled(4 * mean_power), 4 * rows)
    assert_array_equal(speckled(0 * mean_power), 0)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"mean_power": [[1.0, -1.0]]},
            r"mean_power must be finite, at least 0, got -1 at \(0, 1\)",
        ),
        ({"n_looks": 2.5, "method": "looks"}, "looks needs a whole number of looks, got 2.5"),
        ({"method": "rice"}, "speckle method must be one of looks, gamma, quantile, got 'rice'"),
        (
            {"method": "quantile", "correlation": [1, 0.8]},
            "speckle correlation 0.8 at lag 1 is not possible: the nearest is 0.6",
        ),
        ({"method": "quantile", "correlation": [0.5]}, "speckle correlation must be 1 at lag 0"),
        (
            {"correlation": [1, 0.1]},
            "speckle method gamma draws independent range bins, a correlation needs quantile",
        ),
    ],
)
def test_bad_input_is_refused_in_one_line(change, message, rng):
    given = {"mean_power": np.ones((4, 4)), "n_looks": 16} | change
    with refusal(message):
        draw_speckle(**given, rng=rng)
