import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.signal import lfilter

from snowsim.metrics import texture


@pytest.mark.parametrize(("along", "axis"), [("range_line", 1), ("range_bin", 0)])
def test_autocorrelation_of_an_autoregressive_texture_falls_geometrically(rng, along, axis):
    image = lfilter([1], [1, -0.8], rng.standard_normal((600, 600)), axis=axis)[100:, 100:]
    other = "range_bin" if along == "range_line" else "range_line"
    # Independent pixels: 250,000 x (1 - 0.8^2) / (1 + 0.8^2) = 55,000; four of 1 / sqrt(55,000) is
    # 0.017.
    lags = np.array([0, 1, 2, 5, 10])
    assert_allclose(texture.autocorrelation(image, lags, along=along), 0.8**lags, atol=0.017)
    assert_allclose(texture.autocorrelation(image, [1, 10], along=other), 0, atol=0.017)


def test_texture_does_not_depend_on_gain_or_offset(rng):
    image = rng.standard_normal((50, 60))
    plain = texture.autocorrelation(image, [1, 2, 3], along="range_bin")
    assert_allclose(
        texture.autocorrelation(5 + 3 * image, [1, 2, 3], along="range_bin"),
        plain,
        rtol=1e-10,
        atol=1e-12,
    )


@pytest.mark.parametrize(
    ("image", "lag", "along", "message"),
    [
        (np.ones((5, 5)), 1, "range_bin", "not be constant"),
        (np.full((8, 8), np.nan), 1, "range_bin", "finite"),
        (np.eye(5), 5, "range_bin", r"\[0, 4\]"),
        (np.eye(5), 1, "slow_time", "range_bin or range_line"),
    ],
)
def test_bad_input_is_refused(image, lag, along, message):
    with pytest.raises(ValueError, match=message):
        texture.autocorrelation(image, [lag], along=along)
