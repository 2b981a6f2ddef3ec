import json

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.special import gammainc, gammainccinv, gammaincinv, ndtr, ndtri
from scipy.stats import gamma, kstest

from evaluation.lib.literal_phy import planted_scene
from snowsim.phy import draw_speckle, plan, render
from snowsim.phy.correlated import (
    HALF_TAPS,
    LARGEST_ERROR,
    correlating_taps,
    draw_normals,
    filter_to_power,
    normal_quantiles,
)

LOOKS = [1, 5, 16, 100]
# A Hann window at 0.58 and 0.31 of its resolution, a slow decay, one that turns negative, one lag
# far off.
SHAPES = [
    (1, 0.157, 0.003),
    (1, 0.66, 0.18, 0.02),
    0.6 ** np.arange(9),
    (1, -0.2, 0.05),
    (1, 0, 0, 0, 0.25),
]


def correlated(shape, n_looks, correlation, rng):
    ones = np.ones(shape, dtype=np.float32)
    power = draw_speckle(ones, n_looks, method="quantile", correlation=correlation, rng=rng)
    return power.astype(float)


@pytest.mark.parametrize("n_looks", [*LOOKS, 1000])
def test_law_is_as_close_to_gamma_as_stated(n_looks, rng):
    # Distribution functions at a million normals, unfiltered.
    normals = ndtri((np.arange(1_000_000) + 0.5) / 1_000_000).astype(np.float32)[:, None]
    power = np.ones(normals.shape)
    one_tap = np.ones(1, dtype=np.float32)
    filter_to_power(normals, one_tap, normal_quantiles(float(n_looks)), power, power)
    exact = gammainc(n_looks, n_looks * power)
    assert_allclose(exact, ndtr(normals.astype(float)), rtol=0, atol=1e-5)
    # The table's mean and looks, by trapezoids over the normal density: their error is below 1e-8
    # of steps 1/256.
    quantile = normal_quantiles(float(n_looks))
    normal = np.linspace(-8, 8, quantile.size)
    density = np.exp(-(normal**2) / 2)
    weight = density / density.sum()
    mean = weight @ quantile
    variance = weight @ (quantile - mean) ** 2
    assert_allclose(mean, 1, atol=1e-5)
    assert_allclose(mean**2 / variance, n_looks, rtol=1e-5)
    # Of lag 1 alone, so every second bin is independent: beyond 1.95 / sqrt(n) once in 1000.
    drawn = correlated((1000, 1000), n_looks, [1, 0.3], rng)[::2].ravel()
    distance = kstest(drawn, gamma(n_looks, scale=1 / n_looks).cdf).statistic
    assert distance < 1.95 / np.sqrt(drawn.size)


@pytest.mark.parametrize("n_looks", LOOKS)
@pytest.mark.parametrize("correlation", SHAPES)
def test_correlation_drawn_is_that_asked_for(correlation, n_looks, rng):
    n_lags = HALF_TAPS + 1
    asked = np.pad(correlation, (0, n_lags - len(correlation)))
    deviation = correlated((300, 4000), n_looks, correlation, rng) - 1
    by_line = []
    for lag in range(n_lags):
        product = deviation[: 300 - lag] * deviation[lag:]
        by_line.append(n_looks * product.mean(axis=0))
    measured = np.mean(by_line, axis=1)
    # Lines are independent, so their scatter is the error; of 340 values in all, 4.5 errors are
    # exceeded once in 400. The filter's own error is largest, 6e-3, where one look leaves the
    # spectrum of normals a negative part.
    scatter = np.std(by_line, axis=1) / np.sqrt(4000)
    _, filter_error = correlating_taps(correlation, n_looks)
    bound = 4.5 * scatter + filter_error
    assert np.all(np.abs(measured - asked) < bound)
    assert bound[1:].max() < 0.02


@pytest.mark.parametrize("n_looks", LOOKS)
def test_without_correlation_each_normal_gives_its_own_quantile(n_looks):
    drawn = correlated((40, 50), n_looks, [1, 0, 0], np.random.default_rng(4))
    normal = draw_normals((40, 50), np.random.default_rng(4)).astype(float)
    in_tail = ndtr(-np.abs(normal))
    upper = gammainccinv(n_looks, in_tail) / n_looks
    lower = gammaincinv(n_looks, in_tail) / n_looks
    expected = np.where(normal > 0, upper, lower)
    # Straight lines between nodes 1/256 apart are off by up to z^2 / 8 / 256^2 of the value: 3e-5
    # at four deviations.
    assert_allclose(drawn, expected, rtol=3e-5)


def test_edges_are_as_anywhere_else(rng):
    n_lines = 100_000
    n_looks = 5
    deviation = correlated((12, n_lines), n_looks, [1, 0.4, 0.1], rng) - 1
    # Variances of Gamma(5) to sqrt((2 + 6 / 5) / n), products of neighbours to 1.6 / sqrt(n): four
    # and more of those.
    variance = (deviation**2).mean(axis=1)
    assert_allclose(n_looks * variance, 1, atol=4 * np.sqrt(3.2 / n_lines))
    neighbours = n_looks * (deviation[:-1] * deviation[1:]).mean(axis=1)
    assert_allclose(neighbours, 0.4, atol=4 * 1.6 / np.sqrt(n_lines))
    across = np.corrcoef(deviation[:, :-1].ravel(), deviation[:, 1:].ravel())[0, 1]
    assert abs(across) < 4 * 1.5 / np.sqrt(12 * n_lines)  # range lines stay independent


def test_what_no_process_has_is_brought_near_and_said():
    # Of a filter over two bins the correlation is at most 0.5; 0.54, as sampling may leave it, is
    # near.
    taps, error = correlating_taps([1, 0.54], 100.0)
    assert_allclose((taps**2).sum(), 1, rtol=1e-12)
    assert 0.005 < error < LARGEST_ERROR


@pytest.mark.parametrize(
    ("method", "correlation", "message"),
    [
        (
            "quantile",
            [1, 0.8],
            "speckle correlation 0.8 at lag 1 is not possible: the nearest is 0.6",
        ),
        ("quantile", [1, np.nan], r"speckle correlation must be finite, .* got nan at \(1,\)"),
        (
            "gamma",
            [1, 0.1],
            "speckle method gamma draws independent range bins, a correlation needs quantile",
        ),
        ("looks", [1, 0.1], "speckle method looks draws independent range bins"),
    ],
)
def test_bad_correlations_are_refused_in_one_line(method, correlation, message, rng):
    with pytest.raises(ValueError, match=message) as refused:
        draw_speckle(np.ones((4, 4)), 16, method=method, correlation=correlation, rng=rng)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("tolerance_db", [None, 0.05])
def test_a_plan_takes_the_correlation_of_its_parameters(tolerance_db, rng):
    layer_bins, parameters = planted_scene(3, 64, 200, n_looks=16)
    correlated_too = parameters | {"speckle_correlation": np.array([1, 0.4, 0.1])}
    options = {"n_range_bins": 200, "tolerance_db": tolerance_db, "speckle": "gamma"}
    planned = plan(layer_bins, correlated_too, **options)
    notes = json.loads(json.dumps(planned.notes()))
    assert notes["plan_speckle"] == "quantile, correlated"
    assert notes["plan_correlation_error"] < 1e-3
    assert plan(layer_bins, parameters, **options).notes()["plan_speckle"] == "gamma"
    # In the noise above the layers: 64 lines of 20 bins give a correlation to 0.03.
    air = render(layer_bins, correlated_too, **options, rng=rng)[:20]
    neighbours = np.corrcoef(air[:-1].ravel(), air[1:].ravel())[0, 1]
    assert_allclose(neighbours, 0.4, atol=4 * 0.03)
    with pytest.raises(ValueError, match="speckle method looks draws independent range bins"):
        plan(layer_bins, correlated_too, 200, tolerance_db=tolerance_db, speckle="looks")
